from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from sunset.classes import CLASS_OF_CARLA_ID
from sunset.data import render_views
from sunset.errors import OutputError
from sunset_lab.frames import Views, frame_plans, render_set

pytestmark = pytest.mark.thorough


def test_no_set_sees_the_default_flights_town_and_held_out_towns_are_held_out() -> None:
    towns = {name: {views.town for views in plan} for name, plan in frame_plans(5500, further=False).items()}
    assert towns["train"] == {2, 3, 4, 5, 6}
    assert towns["validation"] == {7}
    assert towns["test"] == {8}


def test_a_set_is_rendered_once_and_again_for_another_plan(tmp_path: Path) -> None:
    calls: list[tuple[int, int]] = []

    def progress(done: int, total: int) -> None:
        calls.append((done, total))

    plan = (Views(3, 2, 1, flight=True), Views(3, 2, 2, flight=False))
    frames = render_set(plan, tmp_path / "set", jobs=1, progress=progress)
    assert frames.bgr.shape == (4, 144, 256, 3)
    assert frames.labels.max() < 28
    assert calls == [(2, 4), (4, 4)]
    expected = next(render_views(3, 1, 1, heights=(50,), pitches=(60,), times=("noon",), weathers=("clear",)))
    assert np.array_equal(frames.bgr[0], expected.rgb)
    assert np.array_equal(frames.labels[0], CLASS_OF_CARLA_ID[expected.labels])
    render_set(plan, tmp_path / "set", jobs=1, progress=progress)
    assert len(calls) == 2


@pytest.mark.parametrize("whole", [True, False])
def test_frames_of_another_plan_are_not_replaced(whole: bool, tmp_path: Path) -> None:
    def stop(*_: int) -> None:
        if not whole:
            raise KeyboardInterrupt

    with suppress(KeyboardInterrupt):
        render_set((Views(3, 1, 1, flight=True),), tmp_path, jobs=1, progress=stop)
    there = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(OutputError, match="name another work folder, or delete this one"):
        render_set((Views(3, 1, 2, flight=False),), tmp_path, jobs=1)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == there


def test_rendering_that_was_interrupted_goes_on_with_what_is_missing(tmp_path: Path) -> None:
    plan = (Views(3, 2, 1, flight=True), Views(3, 1, 2, flight=True), Views(3, 2, 3, flight=True))
    calls: list[tuple[int, int]] = []

    def stop(done: int, total: int) -> None:
        calls.append((done, total))
        if len(calls) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        render_set(plan, tmp_path / "parts", jobs=1, progress=stop)
    parts = render_set(plan, tmp_path / "parts", jobs=1, progress=stop)
    assert calls == [(2, 5), (3, 5), (5, 5)]
    whole = render_set(plan, tmp_path / "whole", jobs=2)
    for name in ("bgr", "depth", "labels"):
        assert np.array_equal(getattr(parts, name), getattr(whole, name))
    assert {path.name for path in (tmp_path / "parts").iterdir()} == {
        "plan.json",
        "finished.npy",
        "bgr.npy",
        "depth.npy",
        "labels.npy",
    }


def counts(frames: int, *, further: bool = False) -> dict[str, list[int]]:
    return {
        name: [views.count for views in plan] for name, plan in frame_plans(frames, further=further).items()
    }


def test_fewer_frames_are_asked_for_by_one_number() -> None:
    assert {views.town for views in frame_plans(100, further=False)["train"]} == {2, 3, 4, 5, 6}
    assert 100 <= sum(counts(100)["train"]) <= 110
    assert counts(5500) == {"train": [800, 300] * 5, "validation": [150], "test": [150]}
    assert counts(11000)["test"] == [150]
    assert counts(550) == {"train": [80, 30] * 5, "validation": [15], "test": [15]}
    assert counts(20_000, further=True)["train"] == [1600, 2400] * 5


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    plan = (Views(3, 1, 1, flight=True),)
    with pytest.raises(OutputError, match=r"The training frames cannot be written to .*file"):
        render_set(plan, tmp_path / "file" / "set", jobs=1)


def test_what_is_no_set_of_frames_is_not_removed(tmp_path: Path) -> None:
    (tmp_path / "photo.txt").write_text("dear", encoding="utf-8")
    with pytest.raises(OutputError, match=r"holds photo\.txt, which is not of this training's frames"):
        render_set((Views(3, 1, 1, flight=True),), tmp_path, jobs=1)
    assert (tmp_path / "photo.txt").read_text(encoding="utf-8") == "dear"
