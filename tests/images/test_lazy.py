import hashlib
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from sunset.images import ImageCache, LazyImage, Pixels, digest_of

BGR = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)

looks: list[str] = []


def brightened(pixels: Pixels, by: int) -> Pixels:
    looks.append("brightened")
    return pixels + np.uint8(by)


def darkened(pixels: Pixels, by: int) -> Pixels:
    return pixels - np.uint8(by)


def mean(pixels: Pixels) -> float:
    looks.append("mean")
    return float(pixels.mean())


def distance(pixels: Pixels, other: Pixels) -> bytes:
    looks.append("distance")
    return (pixels - other).tobytes()


def nothing(pixels: Pixels) -> float:
    del pixels
    return math.nan


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


def test_measurements_are_looked_up_without_the_pixels(cache: ImageCache) -> None:
    def measured() -> tuple[float, bytes, bytes]:
        image = LazyImage.of(BGR, cache).then(brightened, 7).then(brightened, 1)
        return image.measure(mean), image.measure(distance, LazyImage.of(BGR)), image.digest

    expected = (19.5, bytes([8] * 24), digest_of(BGR + np.uint8(8)))
    assert measured() == expected
    assert looks == ["brightened", "brightened", "mean", "distance"]
    assert measured() == expected
    assert len(looks) == 4


def test_without_a_cache_everything_is_measured_each_time() -> None:
    image = LazyImage.of(BGR)
    assert [image.measure(mean), image.measure(mean)] == [11.5, 11.5]
    assert looks == ["mean", "mean"]


def test_a_measurement_that_is_no_number_is_found_again(cache: ImageCache) -> None:
    for _ in range(2):
        assert math.isnan(LazyImage.of(BGR, cache).measure(nothing))
    assert len(cache) == 1


def test_what_differs_has_another_key() -> None:
    image, other = LazyImage.of(BGR), LazyImage.of(BGR + np.uint8(1))
    images = [
        image,
        other,
        LazyImage.of(BGR.reshape(4, 2, 3)),
        LazyImage.of(BGR.view(np.int8)),
        image.then(brightened, 1),
        image.then(brightened, 1.0),
        image.then(brightened, 2),
        image.then(darkened, 1),
        other.then(brightened, 1),
        image.then(brightened, 1).then(brightened, 1),
    ]
    assert len({each.key for each in images}) == len(images)
    assert LazyImage.of(BGR.copy()).then(brightened, 1).key == images[4].key


def test_the_key_of_a_users_function_changes_with_its_file(tmp_path: Path) -> None:
    keys = set()
    for number in (1, 2):
        path = tmp_path / f"effects{number}.py"
        path.write_text(f"def effect(pixels):\n    return pixels * {number}\n", encoding="utf-8")
        namespace: dict[str, object] = {"__name__": "effects"}
        exec(compile(path.read_text(encoding="utf-8"), path, "exec"), namespace)  # noqa: S102  as an import
        keys.add(LazyImage.of(BGR).then(namespace["effect"]).key)  # type: ignore[arg-type]
    assert len(keys) == 2
