from pathlib import Path

import numpy as np
import pytest

from sunset.classes import CLASS_OF_CARLA_ID
from sunset.data import render_views
from sunset.errors import OutputError
from sunset.training.frames import FrameCounts, FramePlan, Passage, Views, render_set


def test_no_set_sees_the_default_flights_town_and_held_out_towns_are_held_out() -> None:
    towns = {name: {views.town for views in plan.views} for name, plan in FrameCounts().plans().items()}
    assert towns["train"] == {2, 3, 4, 5, 6}
    assert towns["validation"] == towns["validation_flight"] == {7}
    assert towns["test"] == towns["test_flight"] == {8}


def test_a_set_is_rendered_once_and_again_for_another_plan(tmp_path: Path) -> None:
    calls: list[tuple[int, int]] = []

    def progress(done: int, total: int) -> None:
        calls.append((done, total))

    plan = FramePlan((Views(3, 2, 1, flight=True), Passage(3, 2, 50.0)))
    frames = render_set(plan, tmp_path / "set", jobs=1, progress=progress)
    assert frames.bgr.shape == (4, 144, 256, 3)
    assert frames.labels.max() < 28
    assert calls == [(2, 4), (4, 4)]
    expected = next(render_views(3, 1, 1, heights=(50,), pitches=(60,), times=("noon",), weathers=("clear",)))
    assert np.array_equal(frames.bgr[0], expected.rgb)
    assert np.array_equal(frames.labels[0], CLASS_OF_CARLA_ID[expected.labels])
    render_set(plan, tmp_path / "set", jobs=1, progress=progress)
    assert len(calls) == 2
    other = FramePlan((Views(3, 1, 2, flight=False),))
    assert len(render_set(other, tmp_path / "set", jobs=1, progress=progress)) == 1


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    plan = FramePlan((Passage(3, 1, 50.0),))
    with pytest.raises(OutputError, match=r"The training frames cannot be written to .*file"):
        render_set(plan, tmp_path / "file" / "set", jobs=1)


def test_what_is_no_set_of_frames_is_not_removed(tmp_path: Path) -> None:
    (tmp_path / "photo.txt").write_text("dear", encoding="utf-8")
    with pytest.raises(OutputError, match=r"holds photo\.txt, which is none of a training's frames"):
        render_set(FramePlan((Passage(3, 1, 50.0),)), tmp_path, jobs=1)
    assert (tmp_path / "photo.txt").read_text(encoding="utf-8") == "dear"
