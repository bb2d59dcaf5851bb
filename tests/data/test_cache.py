import hashlib
from pathlib import Path

import numpy as np
import pytest

from sunset.data import (
    FlightPlan,
    Frame,
    cache_folder,
    flight_bag,
    flight_bags,
    kept_bag,
    read_bag,
    render_frames,
)
from sunset.errors import InvalidInputError, OutputError

pytestmark = pytest.mark.xdist_group("towns")  # each is built once

PLAN = FlightPlan(frames=3, size=(36, 64))


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def _digest(folder: Path) -> str:
    digest = hashlib.sha256()
    for path in sorted(folder.iterdir()):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


def test_the_cache_folder_follows_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/home/someone")
    monkeypatch.delenv("SUNSET_CACHE_DIR", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert cache_folder() == Path("/home/someone/.cache/sunset")
    monkeypatch.setenv("XDG_CACHE_HOME", "/var/caches")
    assert cache_folder() == Path("/var/caches/sunset")
    monkeypatch.setenv("SUNSET_CACHE_DIR", "/mine")
    assert cache_folder() == Path("/mine")


def test_a_flight_is_rendered_once_and_kept(cache: Path) -> None:
    calls: list[tuple[int, int]] = []
    first = flight_bag(PLAN, jobs=1, progress=lambda done, total: calls.append((done, total)))
    assert calls == [(done, 3) for done in range(4)]
    assert flight_bag(PLAN, jobs=1, progress=lambda done, total: calls.append((done, total))) == first
    assert len(calls) == 4
    assert first.is_relative_to(cache)
    with read_bag(first) as bag:
        assert bag.stamps_ns == tuple(PLAN.stamps_ns())
        for index, frame in enumerate(render_frames(PLAN)):
            np.testing.assert_array_equal(bag.frame(index).rgb, frame.rgb)
            np.testing.assert_array_equal(bag.frame(index).depth, frame.depth)
            np.testing.assert_array_equal(bag.frame(index).labels, frame.labels)
    assert [path.name for path in first.parent.parent.iterdir()] == [first.parent.name]


@pytest.mark.thorough
def test_another_plan_is_another_flight(cache: Path) -> None:
    one = flight_bag(FlightPlan(frames=1, size=(18, 32)), jobs=1)
    other = flight_bag(FlightPlan(frames=1, size=(18, 32), seed=1), jobs=1)
    assert one != other
    assert cache in one.parents
    assert _digest(one) != _digest(other)


@pytest.mark.thorough
@pytest.mark.parametrize("harm", ["spoil", "truncate", "remove", "no checksum", "garbage checksum"])
def test_a_harmed_flight_is_rendered_again(cache: Path, harm: str) -> None:
    plan = FlightPlan(frames=2, size=(18, 32))
    bag = flight_bag(plan, jobs=1)
    before = _digest(bag)
    path, checksum = bag / "flight.mcap", bag.parent / "checksum.json"
    if harm == "spoil":
        raw = bytearray(path.read_bytes())
        raw[len(raw) // 2] ^= 1
        path.write_bytes(raw)
    elif harm == "truncate":
        path.write_bytes(path.read_bytes()[:-1])
    elif harm == "remove":
        path.unlink()
    elif harm == "no checksum":
        checksum.unlink()
    else:
        checksum.write_text("{")
    assert flight_bag(plan, jobs=1) == bag
    assert _digest(bag) == before
    assert cache in bag.parents


@pytest.mark.thorough
def test_the_number_of_processes_and_of_flights_changes_no_byte(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plans = [FlightPlan(frames=12, size=(36, 64)), FlightPlan(town=2, frames=11, size=(18, 32), seed=3)]
    calls: list[tuple[int, int]] = []
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(tmp_path / "together"))
    together = flight_bags(
        [*plans, plans[0]], jobs=2, progress=lambda done, total: calls.append((done, total))
    )
    assert calls == [(done, 23) for done in range(24)]
    assert together[0] == together[2]
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(tmp_path / "alone"))
    alone = [flight_bag(plan, jobs=1) for plan in plans]
    assert list(map(_digest, alone)) == list(map(_digest, together[:2]))


def test_no_process_at_all_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="at least 1 job, got 0"):
        flight_bag(PLAN, jobs=0)


def test_an_unwritable_cache_is_an_output_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(tmp_path / "file"))
    with pytest.raises(OutputError, match="set SUNSET_CACHE_DIR to another folder"):
        flight_bag(PLAN, jobs=1)


@pytest.mark.thorough
def test_an_interrupted_rendering_leaves_nothing_behind(cache: Path) -> None:
    def stop(done: int, total: int) -> None:
        if done == total // 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        flight_bag(PLAN, jobs=1, progress=stop)
    assert list((cache / "flights").iterdir()) == []


def test_frames_of_any_kind_are_kept_by_what_they_depend_on(cache: Path) -> None:
    del cache
    frames = list(render_frames(FlightPlan(frames=2, size=(18, 32))))
    made: list[str] = []

    def kept(name: str) -> Path:
        def render() -> list[Frame]:
            made.append(name)
            return frames

        return kept_bag("views", {"setting": name}, render, [0, 1])

    assert kept("near") == kept("near") != kept("far")
    assert made == ["near", "far"]
    with read_bag(kept("far")) as bag:
        np.testing.assert_array_equal(bag.frame(1).rgb, frames[1].rgb)
