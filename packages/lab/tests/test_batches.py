from dataclasses import astuple
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from sunset.classes import IGNORED
from sunset_lab import FrameSet
from sunset_lab.frames import FrameSets

pytestmark = pytest.mark.thorough

pytest.importorskip("torch")

from sunset_lab.augment import class_weights, draw  # noqa: E402  needs torch


def test_a_step_draws_the_same_batch_whatever_was_drawn_before() -> None:
    for number in range(3):
        first, again = draw(12, 4, 1, number), draw(12, 4, 1, number)
        assert all(np.array_equal(*pair) for pair in zip(astuple(first), astuple(again), strict=True))


def test_steps_and_seeds_see_different_batches() -> None:
    transforms = [draw(12, 4, seed, number).transforms for seed, number in ((2, 0), (1, 0), (1, 1), (1, 2))]
    assert not any(np.array_equal(first, second) for first, second in pairwise(transforms))


def test_a_batch_larger_than_the_set_repeats_frames() -> None:
    assert len(draw(2, 5, 1, 0).frames) == 5


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


def test_what_is_written_into_loaded_frames_does_not_reach_the_disk(sets: FrameSets, tmp_path: Path) -> None:
    sets.train.save(tmp_path)
    FrameSet.load(tmp_path).bgr[:] = 0
    assert np.array_equal(FrameSet.load(tmp_path).bgr, sets.train.bgr)
