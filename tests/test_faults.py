import cv2
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sunset.errors import ParameterError
from sunset.faults import (
    DEPTH_COUNTS_PER_METRE,
    blur,
    degrade_depth,
    degrade_image,
    enhance_image,
    sharpness,
    shift_image,
)
from sunset.system import BLUR_SIGMA


def scene(seed: int = 0, shape: tuple[int, int] = (72, 128)) -> npt.NDArray[np.uint8]:
    """Return smooth coloured blobs with edges, as an outdoor image has them."""
    rng = np.random.default_rng(seed)
    coarse = rng.integers(0, 256, (shape[0] // 8, shape[1] // 8, 3), dtype=np.uint8)
    image: npt.NDArray[np.uint8] = cv2.resize(coarse, (shape[1], shape[0]), interpolation=cv2.INTER_NEAREST)
    return image


def constant(value: tuple[int, int, int]) -> npt.NDArray[np.uint8]:
    return np.full((4, 6, 3), value, dtype=np.uint8)


def test_degraded_image_is_darker_and_mixes_each_channel_with_the_next() -> None:
    # strength 1.5: brightness 0.25, share 0.3; blue (0.7·200 + 0.3·100)·0.25 = 42.5 → 42 or 43
    degraded = degrade_image(constant((200, 100, 40)), 1.5)
    np.testing.assert_allclose(degraded[0, 0], [42.5, 20.5, 22.0], atol=0.5)


def test_degraded_grey_stays_grey() -> None:
    np.testing.assert_array_equal(degrade_image(constant((200, 200, 200)), 1.5), constant((50, 50, 50)))


@pytest.mark.parametrize("strength", [0.1, 0.5, 1.0, 1.5])
def test_enhancement_undoes_degradation_up_to_rounding(strength: float) -> None:
    image = scene()
    restored = enhance_image(degrade_image(image, strength), strength)
    share = 0.2 * strength
    mixing = (1 - share) * np.eye(3) + share * np.roll(np.eye(3), 1, axis=1)
    amplification = np.abs(np.linalg.inv((1 - 0.5 * strength) * mixing)).sum(axis=1).max()
    bound = 0.5 * amplification + 0.5 + 1e-6
    assert np.abs(restored.astype(int) - image).max() <= bound


def test_unneeded_enhancement_saturates_and_never_wraps() -> None:
    image = np.repeat(np.arange(256, dtype=np.uint8), 3).reshape(1, 256, 3)  # grey ramp
    enhanced = enhance_image(image, 1.5)
    expected = np.minimum(4 * np.arange(256), 255)
    np.testing.assert_allclose(enhanced[0, :, 1], expected, atol=1)
    assert enhanced[0, 64:].min() == 255


@given(
    st.floats(0, 1.9),
    st.tuples(st.integers(0, 255), st.integers(0, 255), st.integers(0, 255)),
)
@settings(max_examples=50, deadline=None)
def test_degradation_is_never_brighter_than_the_brightest_channel(
    strength: float, colour: tuple[int, int, int]
) -> None:
    assert degrade_image(constant(colour), strength).max() <= max(colour) * (1 - 0.5 * strength) + 1


def test_depth_noise_has_the_given_deviation_in_metres_and_no_bias() -> None:
    depth = np.full((200, 200), 30000, dtype=np.uint16)
    noise = degrade_depth(depth, 10.0, np.random.default_rng(1)).astype(float) - 30000
    assert noise.std() / DEPTH_COUNTS_PER_METRE == pytest.approx(10.0, rel=0.02)
    assert abs(noise.mean()) / DEPTH_COUNTS_PER_METRE < 0.2  # four standard errors


@pytest.mark.parametrize("level", [0, 65535])
def test_depth_noise_saturates_at_the_ends_of_the_range(level: int) -> None:
    noisy = degrade_depth(np.full((50, 50), level, dtype=np.uint16), 100.0, np.random.default_rng(2))
    assert noisy.dtype == np.uint16
    assert np.abs(noisy.astype(int) - level).max() < 32768  # six deviations; a wrap would be near 65535
    assert 0.4 < float((noisy == level).mean()) < 0.6


def test_depth_noise_is_the_generators() -> None:
    depth = np.full((8, 8), 1000, dtype=np.uint16)
    first = degrade_depth(depth, 1.0, np.random.default_rng(3))
    np.testing.assert_array_equal(first, degrade_depth(depth, 1.0, np.random.default_rng(3)))
    assert (first != degrade_depth(depth, 1.0, np.random.default_rng(4))).any()


def test_shift_moves_to_the_right_and_fills_with_black() -> None:
    image = scene()
    shifted = shift_image(image, 40)
    np.testing.assert_array_equal(shifted[:, 40:], image[:, :-40])
    assert not shifted[:, :40].any()


def test_negative_shift_moves_to_the_left() -> None:
    image = scene()
    shifted = shift_image(image, -5)
    np.testing.assert_array_equal(shifted[:, :-5], image[:, 5:])
    assert not shifted[:, -5:].any()


@pytest.mark.parametrize("px", [128, -128, 1920])
def test_shift_beyond_the_width_is_black(px: int) -> None:
    assert not shift_image(scene(), px).any()


def test_blur_is_refused_for_a_negative_sigma() -> None:
    with pytest.raises(ParameterError, match="from 0 on, got -1"):
        blur(scene(), -1)


def test_nothing_to_do_leaves_the_image_and_the_generator_alone() -> None:
    image, rng = scene(), np.random.default_rng(5)
    depth = np.ones((2, 2), dtype=np.uint16)
    for result in (degrade_image(image, 0), enhance_image(image, 0), shift_image(image, 0), blur(image, 0)):
        assert result is image
    assert degrade_depth(depth, 0, rng) is depth
    assert rng.random() == np.random.default_rng(5).random()


def test_read_only_images_are_taken_and_not_changed() -> None:
    image = scene()
    before = image.copy()
    image.flags.writeable = False
    for result in (degrade_image(image, 1), enhance_image(image, 1), shift_image(image, 3), blur(image, 2)):
        assert result.shape == image.shape
        assert result.dtype == np.uint8
        assert (result != before).any()
    np.testing.assert_array_equal(image, before)


def test_sharpness_of_a_single_pixel_chequerboard_is_at_its_greatest() -> None:
    board = (np.indices((32, 32)).sum(axis=0) % 2 * 255).astype(np.uint8)
    assert sharpness(np.repeat(board[..., None], 3, axis=2)) == pytest.approx(64.0)


def test_sharpness_of_one_colour_is_zero() -> None:
    assert sharpness(constant((9, 80, 200))) == 0.0


def test_blur_lowers_sharpness_and_more_blur_lowers_it_more() -> None:
    image = scene()
    values = [sharpness(blur(image, sigma)) for sigma in (0, 0.5, 1, BLUR_SIGMA, 4)]
    assert values == sorted(values, reverse=True)
    assert values[3] < 0.5 * values[0]


def test_darkening_does_not_look_like_blur() -> None:
    image = scene()
    assert sharpness(degrade_image(image, 1.5)) > 4 * sharpness(blur(image, BLUR_SIGMA))
    grey = np.repeat(image[..., :1], 3, axis=2)
    assert sharpness(degrade_image(grey, 1.0)) == pytest.approx(sharpness(grey), rel=0.02)
