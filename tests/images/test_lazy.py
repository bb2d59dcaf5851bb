import hashlib
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from sunset.faults import degrade_image, enhance_image, sharpness
from sunset.images import ImageCache, LazyImage, Pixels, digest_of

BGR = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)

looks: list[str] = []


def brightened(pixels: Pixels, by: int) -> Pixels:
    looks.append("brightened")
    return pixels + np.uint8(by)


def mean(pixels: Pixels) -> float:
    looks.append("mean")
    return float(pixels.mean())


def sunset_function(pixels: Pixels, other: Pixels) -> Pixels:
    summed: Pixels = pixels + other[0]
    return summed


sunset_function.__module__ = "sunset.faults"


@pytest.fixture(autouse=True)
def _nobody_has_looked() -> Iterator[None]:
    looks.clear()
    yield
    looks.clear()


@pytest.fixture
def cache(tmp_path: Path) -> ImageCache:
    return ImageCache(tmp_path / "cache.sqlite")


def test_a_digest_is_of_the_bytes_alone() -> None:
    expected = hashlib.blake2b(BGR.tobytes(), digest_size=16).digest()
    assert digest_of(BGR) == digest_of(BGR.reshape(-1)) == digest_of(BGR.tobytes()) == expected
    assert digest_of(BGR[:, ::2]) == digest_of(BGR[:, ::2].copy()) != expected


def test_pixels_are_computed_once_and_only_if_somebody_looks() -> None:
    image = LazyImage.of(BGR).then(brightened, 7)
    assert (image.size, looks) == ((2, 4), [])
    np.testing.assert_array_equal(image.pixels, BGR + 7)
    assert not image.pixels.flags.writeable
    assert image.digest == digest_of(BGR + np.uint8(7))
    assert looks == ["brightened"]


def unwanted() -> Pixels:
    raise AssertionError("nobody needs the pixels")


def unseen(image: LazyImage, cache: ImageCache) -> LazyImage:
    """Return the same image, whose pixels cannot be computed."""
    return LazyImage(image.size, unwanted, name=lambda: image.key, cache=cache)


def test_measurements_are_looked_up_without_the_pixels(cache: ImageCache) -> None:
    first = LazyImage.of(BGR, cache)
    darker = first.then(degrade_image, 0.5).then(enhance_image, 0.25)
    measured = darker.measure(sharpness), darker.digest
    assert measured == (sharpness(darker.pixels), digest_of(darker.pixels))

    again = unseen(first, cache).then(degrade_image, 0.5).then(enhance_image, 0.25)
    assert (again.measure(sharpness), again.digest) == measured
    with pytest.raises(AssertionError, match="nobody needs"):
        _ = again.pixels


def test_looking_at_an_array_leaves_it_writeable() -> None:
    pixels = BGR.copy()
    assert not LazyImage.of(pixels).pixels.flags.writeable
    assert pixels.flags.writeable


def test_without_a_cache_everything_is_measured_each_time() -> None:
    image = LazyImage.of(BGR)
    assert [image.measure(mean), image.measure(mean)] == [11.5, 11.5]
    assert looks == ["mean", "mean"]


def test_what_differs_has_another_key() -> None:
    image, other = LazyImage.of(BGR), LazyImage.of(BGR + np.uint8(1))
    images = [
        image,
        other,
        LazyImage.of(BGR.reshape(4, 2, 3)),
        LazyImage.of(BGR.view(np.int8)),
        image.then(degrade_image, 1),
        image.then(degrade_image, 1.0),
        image.then(degrade_image, 0.5),
        image.then(enhance_image, 1),
        other.then(degrade_image, 1),
        image.then(degrade_image, 1).then(degrade_image, 1),
    ]
    assert len({each.key for each in images}) == len(images)
    assert LazyImage.of(BGR.copy()).then(degrade_image, 1).key == images[4].key


USERS: dict[str, Callable[[LazyImage, int], LazyImage]] = {
    "a function": lambda image, by: image.then(brightened, by),
    "a lambda": lambda image, by: image.then(lambda pixels: pixels + np.uint8(by)),
    "a partial": lambda image, by: image.then(partial(brightened, by=by)),
    "a function of SUNSET's with an array": lambda image, by: image.then(
        sunset_function, np.full(2000, by, np.uint8)
    ),
}


@pytest.mark.parametrize("users", USERS.values(), ids=USERS)
def test_what_a_users_code_makes_is_named_by_its_content(
    users: Callable[[LazyImage, int], LazyImage], cache: ImageCache
) -> None:
    for by in (3, 4, 3):
        image = users(LazyImage.of(BGR, cache), by)
        assert image.digest == digest_of(BGR + np.uint8(by))
        assert image.key == LazyImage.of(BGR + np.uint8(by)).key


def test_what_a_users_code_measures_is_measured_each_time(cache: ImageCache) -> None:
    image = LazyImage.of(BGR, cache)
    assert [image.measure(mean), image.measure(mean)] == [11.5, 11.5]
    assert looks == ["mean", "mean"]
    assert len(cache) == 0
