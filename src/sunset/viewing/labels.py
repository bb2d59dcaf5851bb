"""Images of class indices as bytes that a page can unpack by itself, without loss.

A browser may change pixels that a script reads from a decoded picture, to tell users apart; so these are no pictures.
"""

import zlib

import numpy as np
import numpy.typing as npt

_LONGEST = 65535
"""Pixels of a run, which two bytes count."""


def pack(labels: npt.NDArray[np.uint8]) -> bytes:
    """Return an image (H, W) of class indices, packed.

    Row after row, it is divided into runs of equal pixels. What is deflated (RFC 1951) has the values of all runs, then
    the low bytes of their lengths, then the high ones.
    """
    pixels = labels.reshape(-1)
    changes = np.flatnonzero(np.diff(pixels)) + 1
    starts = np.union1d(np.concatenate([[0], changes]), np.arange(0, pixels.size, _LONGEST))
    lengths = np.diff(np.append(starts, pixels.size)).astype("<u2")
    low, high = lengths.view(np.uint8)[::2], lengths.view(np.uint8)[1::2]
    packer = zlib.compressobj(9, wbits=-zlib.MAX_WBITS)
    return packer.compress(pixels[starts].tobytes() + low.tobytes() + high.tobytes()) + packer.flush()


def unpack(packed: bytes, height: int, width: int) -> npt.NDArray[np.uint8]:
    """Return the image (height, width) that was packed, as the page does.

    >>> unpack(pack(np.array([[7, 7, 7], [7, 2, 2]], np.uint8)), 2, 3).tolist()
    [[7, 7, 7], [7, 2, 2]]
    """
    parts = np.frombuffer(zlib.decompress(packed, -zlib.MAX_WBITS), np.uint8).reshape(3, -1)
    lengths = parts[1].astype(np.int64) + 256 * parts[2].astype(np.int64)
    return np.repeat(parts[0], lengths).reshape(height, width)
