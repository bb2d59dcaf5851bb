"""Labels of a page, unpacked as its script does."""

import zlib

import numpy as np
import numpy.typing as npt


def unpack(packed: bytes, height: int, width: int) -> npt.NDArray[np.uint8]:
    """Return the labels (height, width)."""
    parts = np.frombuffer(zlib.decompress(packed, -zlib.MAX_WBITS), np.uint8).reshape(3, -1)
    lengths = parts[1].astype(np.int64) + 256 * parts[2].astype(np.int64)
    return np.repeat(parts[0], lengths).reshape(height, width)
