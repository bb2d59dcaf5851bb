import hashlib

import numpy as np
import pytest

from sunset.files import image_digests
from sunset.files.image_digests import image_digest, remember_digest

BGR = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)


def test_a_digest_is_of_the_bytes_alone() -> None:
    expected = hashlib.blake2b(BGR.tobytes(), digest_size=16).digest()
    assert image_digest(BGR) == image_digest(BGR.reshape(-1)) == image_digest(BGR.view(np.int8)) == expected
    assert image_digest(BGR[:, ::2]) == image_digest(BGR[:, ::2].copy()) != expected


def test_pixels_that_somebody_may_write_to_are_looked_at_every_time() -> None:
    pixels = BGR.copy()
    before = image_digest(pixels)
    pixels[0, 0, 0] += 1
    assert image_digest(pixels) != before


def test_what_nobody_may_write_to_is_looked_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    pixels = BGR.copy()
    pixels.flags.writeable = False
    first = image_digest(pixels)
    monkeypatch.setattr(image_digests, "digest_of", lambda _: b"computed again")
    assert image_digest(pixels.reshape(-1)) == first
    assert image_digest(pixels[1:]) == b"computed again"
    for _ in range(100):  # it is not kept for ever
        others = BGR.copy()
        others.flags.writeable = False
        image_digest(others)
    assert image_digest(pixels) == b"computed again"


def test_a_remembered_digest_is_that_of_the_pixels_and_goes_with_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pixels = np.arange(24, dtype=np.uint8).reshape(4, 6)
    pixels.flags.writeable = False
    expected = hashlib.blake2b(pixels.tobytes(), digest_size=16).digest()
    remembered = image_digests._remembered
    before = dict(remembered)

    remember_digest(pixels)
    monkeypatch.setattr(image_digests, "digest_of", None)  # it is not computed again

    assert image_digest(pixels) == image_digest(pixels.view()) == expected
    del pixels
    assert remembered == before
