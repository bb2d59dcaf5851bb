"""Images as what was done to which image: pixels are computed when they are read, and measurements looked up."""

from sunset.images.cache import ImageCache as ImageCache
from sunset.images.cache import open_cache as open_cache
from sunset.images.cache import platform_features as platform_features
from sunset.images.lazy import LazyImage as LazyImage
from sunset.images.lazy import Pixels as Pixels
from sunset.images.lazy import digest_of as digest_of
from sunset.images.lazy import key_of as key_of
