from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from sunset.classes import IGNORED
from sunset.errors import DataError
from sunset.training import FrameSet, FrameSets
from sunset.training.batches import augment, batches, class_weights


def test_a_step_sees_the_same_batch_however_the_run_got_there(sets: FrameSets) -> None:
    whole = list(batches(sets.train, 4, 1, range(4)))
    resumed = list(batches(sets.train, 4, 1, range(2, 4)))
    for expected, got in zip(whole[2:], resumed, strict=True):
        assert np.array_equal(expected.bgr, got.bgr)
        assert np.array_equal(expected.depth, got.depth)
        assert np.array_equal(expected.labels, got.labels)
        assert expected.phase == got.phase


def test_there_are_as_many_batches_as_numbers(sets: FrameSets) -> None:
    assert [len(list(batches(sets.train, 4, 1, range(count)))) for count in range(3)] == [0, 1, 2]


def test_steps_and_seeds_see_different_batches(sets: FrameSets) -> None:
    steps = list(batches(sets.train, 4, 1, range(3)))
    other = next(batches(sets.train, 4, 2, [0]))
    for first, second in pairwise([other, *steps]):
        assert not np.array_equal(first.labels, second.labels)


def test_a_batch_larger_than_the_set_repeats_frames(sets: FrameSets) -> None:
    few = FrameSet(sets.train.bgr[:2], sets.train.depth[:2], sets.train.labels[:2])
    assert next(batches(few, 5, 1, [0])).bgr.shape == (5, 144, 256, 3)


def test_augmentation_moves_colour_depth_and_labels_alike(sets: FrameSets) -> None:
    bgr, depth, labels = sets.train.bgr[0], sets.train.depth[0], sets.train.labels[0]
    for seed in range(20):
        _, moved, classes = augment(bgr, depth, labels, np.random.default_rng(seed))
        assert np.array_equal(moved, 2500 + 60 * classes.astype(np.float32))


def test_augmentation_mirrors_half_and_enlarges_half_of_the_frames() -> None:
    x = np.arange(256, dtype=np.uint16) * np.ones((144, 1), dtype=np.uint16)
    bgr, labels = np.full((144, 256, 3), 100, dtype=np.uint8), np.zeros((144, 256), dtype=np.uint8)
    mirrored, enlarged, gains = 0, 0, []
    for seed in range(200):
        picture, depth, _ = augment(bgr, x, labels, np.random.default_rng(seed))
        left, right = depth[70, 0], depth[70, 255]
        mirrored += left > right
        enlarged += abs(left - right) < 255
        assert abs(left - right) >= 255 / 1.31
        gains.append(picture[0, 0, 0])
    assert 70 < mirrored < 130
    assert 70 < enlarged < 130
    assert 90 <= min(gains) < 95
    assert 105 < max(gains) <= 110


def test_rare_classes_weigh_more_within_limits() -> None:
    labels = np.zeros((1, 100, 100), dtype=np.uint8)
    labels[0, :20] = 1
    labels[0, 0, 0] = 2
    labels[0, 99] = IGNORED
    weights = class_weights(labels, (0.5, 3.0))
    assert weights[0] < weights[1] < weights[2] == 3.0
    assert weights[3] == 0.5


def test_frames_come_back_as_they_were_saved(sets: FrameSets, tmp_path: Path) -> None:
    sets.train.save(tmp_path / "frames")
    loaded = FrameSet.load(tmp_path / "frames")
    assert np.array_equal(loaded.bgr, sets.train.bgr)
    assert np.array_equal(loaded.depth, sets.train.depth)
    assert np.array_equal(loaded.labels, sets.train.labels)


def test_missing_frames_are_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"The training frames in .* cannot be read"):
        FrameSet.load(tmp_path)


def test_arrays_that_do_not_belong_together_are_refused(sets: FrameSets) -> None:
    with pytest.raises(DataError, match="consists of three arrays of shapes"):
        FrameSet(sets.train.bgr, sets.train.depth[:3], sets.train.labels)
