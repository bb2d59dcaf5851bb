"""Images whose pixels are computed when they are read."""

import hashlib
import sys
from collections.abc import Callable
from functools import cache, cached_property
from typing import Any, Final, TypeVar, cast

import msgspec
import numpy as np
import numpy.typing as npt

from sunset.files.sources import PACKAGES, package_version
from sunset.images.cache import ImageCache, platform_features

Pixels = npt.NDArray[Any]
"""An image of any sensor's type."""
Measured = TypeVar("Measured", float, bytes)

_BYTES: Final = 16


def digest_of(content: Pixels | bytes) -> bytes:
    """Return the digest of an image's bytes: BLAKE2b, 16 bytes long."""
    data = content if isinstance(content, bytes) else np.ascontiguousarray(content).data
    return hashlib.blake2b(data, digest_size=_BYTES).digest()


def key_of(*parts: object) -> bytes:
    """Return the digest of what `repr` tells apart, which names a value in the cache."""
    return digest_of(repr(parts).encode())


class LazyImage:
    """An image as what was done to which image.

    Its pixels are computed when they are first read. What is measured on it is looked up in the cache by its `key`,
    without its pixels.

    Args:
        size: height and width in pixels.
        make: returns the pixels, the same each time.
        name: returns a name of the pixels that no others have; None to name them by their content.
        cache: where measurements are looked up; None to compute them each time.
    """

    def __init__(
        self,
        size: tuple[int, int],
        make: Callable[[], Pixels],
        *,
        name: Callable[[], bytes] | None,
        cache: ImageCache | None,
    ) -> None:
        self.size: Final = size
        self.cache: Final = cache
        self._make = make
        self._name = name

    @classmethod
    def of(cls, pixels: Pixels, cache: ImageCache | None = None) -> "LazyImage":
        """Return the image of existing pixels (H, W, …), which must not change afterwards."""
        return cls((pixels.shape[0], pixels.shape[1]), lambda: pixels, name=None, cache=cache)

    def __repr__(self) -> str:
        return f"LazyImage({self.size[1]}x{self.size[0]})"

    @cached_property
    def pixels(self) -> Pixels:
        """The pixels (H, W, …), read-only."""
        pixels = self._make().view()  # the array that it looks at stays as it is
        pixels.flags.writeable = False
        return pixels

    @cached_property
    def digest(self) -> bytes:
        """The digest of the pixels' bytes, as `digest_of`."""
        return digest_of(self.pixels) if self._name is None else self.measure(digest_of)

    @cached_property
    def key(self) -> bytes:
        """What names the pixels, 16 bytes."""
        if self._name is not None:
            return self._name()
        return key_of(self.digest, self.pixels.dtype.str, self.pixels.shape)

    def then(self, function: Callable[..., Pixels], *arguments: object) -> "LazyImage":
        """Return the image, of the same size, that a function makes of this image's pixels and further arguments.

        Only an image that a function of SUNSET makes with plain arguments is named by what was done; any other image is
        named by its content.
        """
        named = _is_named(function, arguments)
        return LazyImage(
            self.size,
            lambda: function(self.pixels, *map(_pixels_of, arguments)),
            name=(lambda: self._key_of(function, arguments)) if named else None,
            cache=self.cache,
        )

    def measure(self, function: Callable[..., Measured], *arguments: object) -> Measured:
        """Return what a function measures on this image's pixels and on further arguments, such as images.

        It is looked up if the function is SUNSET's, and the arguments are images or plain.
        """
        if self.cache is None or not _is_named(function, arguments):
            return function(self.pixels, *map(_pixels_of, arguments))

        def measured() -> bytes:
            return msgspec.msgpack.encode(function(self.pixels, *map(_pixels_of, arguments)))

        known = self.cache.look_up(self._key_of(function, arguments), measured)
        return cast("Measured", msgspec.msgpack.decode(known))

    def _key_of(self, function: Callable[..., object], arguments: tuple[object, ...]) -> bytes:
        named = (each.key if isinstance(each, LazyImage) else each for each in arguments)
        return key_of(_identity(function), self.key, *named)


_NAMED: Final = frozenset({bool, int, float, str, LazyImage})
"""The types of arguments that name an image or a measurement."""


def _pixels_of(argument: object) -> object:
    return argument.pixels if isinstance(argument, LazyImage) else argument


def _is_named(function: Callable[..., object], arguments: tuple[object, ...]) -> bool:
    """Return whether a function is a module's of SUNSET, and arguments are what `repr` tells apart."""
    name = getattr(function, "__module__", None) or ""
    if name.partition(".")[0] not in PACKAGES or any(type(each) not in _NAMED for each in arguments):
        return False
    return getattr(sys.modules.get(name), getattr(function, "__name__", ""), None) is function


@cache
def _identity(function: Callable[..., object]) -> bytes:
    """Return what names a function of SUNSET and its code, on this kind of computer."""
    return key_of(platform_features(), package_version(), function.__module__, function.__qualname__)
