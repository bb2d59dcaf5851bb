import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from sunset.data import Frame, read_bag, write_bag
from sunset.harness.frames import LazyFrames
from sunset_ros.seeding import generator


@pytest.fixture
def frames(tmp_path: Path) -> Iterator[LazyFrames]:
    rng = generator(1, "frames")
    recorded = [
        Frame(
            rgb=rng.integers(0, 256, (6, 8, 3), dtype=np.uint8),
            depth=rng.integers(0, 65536, (6, 8), dtype=np.uint16),
            labels=rng.integers(0, 23, (6, 8), dtype=np.uint8),
        )
        for _ in range(3)
    ]
    with read_bag(write_bag(tmp_path / "bag", recorded, [1, 2, 3])) as bag:
        yield LazyFrames(bag, None)


def test_frames_that_are_kept_are_the_same_and_are_not_read_again(frames: LazyFrames) -> None:
    read = [frames.frame(index) for index in range(3)]
    frames.keep()
    shutil.rmtree(frames.bag.path)
    for index, frame in enumerate(read):
        kept = frames.frame(index)
        assert frames.frame(index) is kept is not frame
        assert kept.rgb.digest == frame.rgb.digest
        assert kept.depth.digest == frame.depth.digest
        np.testing.assert_array_equal(kept.labels.pixels, frame.labels.pixels)


def test_more_frames_than_a_process_should_hold_are_not_kept(
    frames: LazyFrames, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sunset.harness.frames._MOST_KEPT", 100)
    frames.keep()
    assert frames.frame(0) is not frames.frame(0)
