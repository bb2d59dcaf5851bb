"""Augmentation, against OpenCV's, and on torch's `meta` device, which refuses tensors of another and to be waited for."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from sunset.training import FrameSet, FrameSets
from sunset.training.batches import draw

torch = pytest.importorskip("torch")

from sunset.training.augment import DeviceFrames  # noqa: E402  needs torch

CPU = torch.device("cpu")
SIZE = (256, 144)


def noise(count: int) -> FrameSet:
    rng = np.random.default_rng(0)
    depth = rng.integers(0, 2**16, (count, 144, 256), dtype=np.uint16)
    return FrameSet(
        rng.integers(0, 256, (count, 144, 256, 3), dtype=np.uint8), depth, (depth % 28).astype(np.uint8)
    )


def test_a_batch_is_what_opencv_makes_of_the_same_draw() -> None:
    frames = noise(6)
    to_corners = np.array([[2 / 256, 0, 1 / 256 - 1], [0, 2 / 144, 1 / 144 - 1], [0, 0, 1]])
    for number in range(8):
        drawn = draw(6, 4, 1, number)
        batch = DeviceFrames(frames, CPU).batch(drawn)
        for place, (index, transform, gain) in enumerate(
            zip(drawn.frames, drawn.transforms, drawn.gains, strict=True)
        ):
            between_corners = np.vstack([transform, (0, 0, 1)])
            matrix = (np.linalg.inv(to_corners) @ between_corners @ to_corners)[:2]

            def warped(image: np.ndarray, interpolation: int, matrix: np.ndarray = matrix) -> np.ndarray:
                flags = interpolation | cv2.WARP_INVERSE_MAP
                return cv2.warpAffine(image, matrix, SIZE, flags=flags, borderMode=cv2.BORDER_REPLICATE)

            colours = cv2.convertScaleAbs(warped(frames.bgr[index], cv2.INTER_LINEAR), alpha=float(gain))
            difference = np.abs(batch.bgr[place].numpy().astype(int) - colours)
            assert difference.max() <= 2  # of rounding, twice
            assert (difference > 0).mean() < 0.001
            for found, image in ((batch.depth, frames.depth), (batch.labels, frames.labels)):
                expected = warped(image[index], cv2.INTER_NEAREST)
                assert (
                    found[place].numpy() != expected
                ).mean() < 0.02  # a row or a column half-way between two
        assert batch.phase == drawn.phase


def test_augmentation_moves_colour_depth_and_labels_alike(sets: FrameSets) -> None:
    batch = DeviceFrames(sets.train, CPU).batch(draw(12, 20, 1, 0))
    assert torch.equal(batch.depth, 2500 + 60 * batch.labels.float())


def test_augmentation_mirrors_half_and_enlarges_half_of_the_frames() -> None:
    x = np.arange(256, dtype=np.uint16) * np.ones((1, 144, 1), dtype=np.uint16)
    plain = FrameSet(np.full((1, 144, 256, 3), 100, np.uint8), x, np.zeros((1, 144, 256), np.uint8))
    batch = DeviceFrames(plain, CPU).batch(draw(1, 200, 1, 0))
    left, right = batch.depth[:, 70, 0], batch.depth[:, 70, 255]
    assert 70 < (left > right).sum() < 130
    assert 70 < ((left - right).abs() < 255).sum() < 130
    assert (left - right).abs().min() >= 255 / 1.31
    gains = batch.bgr[:, 0, 0, 0]
    assert 90 <= gains.min() < 95
    assert 105 < gains.max() <= 110


def test_depth_beyond_half_its_range_is_not_negative() -> None:
    frames = noise(3)
    plain = DeviceFrames(frames, CPU).plain(np.array([2, 0]))
    assert np.array_equal(plain.depth, frames.depth[[2, 0]])
    assert np.array_equal(plain.bgr, frames.bgr[[2, 0]])
    assert np.array_equal(plain.labels, frames.labels[[2, 0]])


def test_read_only_frames_can_be_learned_from(sets: FrameSets) -> None:
    labels = sets.train.labels.copy()
    labels.flags.writeable = False
    assert len(DeviceFrames(replace(sets.train, labels=labels), CPU)) == len(labels)
