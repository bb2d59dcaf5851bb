"""Digests of images, each computed once."""

import hashlib
import weakref
from collections import OrderedDict
from typing import Any, Final

import numpy as np
import numpy.typing as npt

Pixels = npt.NDArray[Any]
"""An image of any sensor's type."""

_BYTES: Final = 16
_KEPT: Final = 32

_known: OrderedDict[tuple[int, int], tuple[Pixels, bytes]] = OrderedDict()
"""Address and size → image and digest, of the last few read-only images; a kept image's address stays its own."""
_remembered: dict[tuple[int, int], bytes] = {}
"""Address and size → digest, of images whose owners keep them."""


def image_digest(pixels: Pixels) -> bytes:
    """Return the digest of an image's bytes: BLAKE2b, 16 bytes long."""
    pixels = np.ascontiguousarray(pixels)
    place = pixels.ctypes.data, pixels.nbytes
    if place in _remembered:
        return _remembered[place]
    if place in _known:
        return _known[place][1]
    digest = digest_of(pixels.data)
    if not pixels.flags.writeable:
        _known[place] = pixels, digest
        if len(_known) > _KEPT:
            _known.popitem(last=False)
    return digest


def remember_digest(pixels: Pixels) -> None:
    """Compute the digest of read-only pixels, and remember it as long as they exist, also in forked processes."""
    place = pixels.ctypes.data, pixels.nbytes
    _remembered[place] = digest_of(pixels.data)
    weakref.finalize(pixels, _remembered.pop, place, None).atexit = False


def digest_of(content: bytes | memoryview) -> bytes:
    """Return the digest of bytes, as of an image."""
    return hashlib.blake2b(content, digest_size=_BYTES).digest()
