"""The suites from `single` on, run end to end: what they say comes, and nothing is seen of what is calm."""

from collections.abc import Iterator
from dataclasses import replace
from math import inf
from pathlib import Path

import pytest

from sunset.data import read_bag, write_bag
from sunset.experiments import BenchSpec, RunSpec, Settings, Timing, bench, run
from sunset.recording import StoredRun, read_stored_run
from sunset.scenarios import Scenario, ScenarioFault, load_scenario, onsets, suite
from sunset.texts.names import RUN_FILE

BEGINNINGS = {
    "single/image_shift": 2.0,
    "outages/hardware_disconnect+sync_issue+gpu_failure": 2.0,
    "timed/camera_driver_issue+depth_degradation+autofocus_needed": 4.0,
    "transient/hardware_disconnect-for-2-s": 7.5,
    "cascade/pairs-then-leak": 9.5,
    "calm/slight-depth_degradation": 3.5,
    "long/first": 6.0,
}
"""A scenario of each suite → how much of it is run in little time [s]."""

QUARTER_OF_THE_FRAMES = Timing(warm_up_s=0.4, period_s=0.4)
"""What is asked of the suites is in seconds; what a threshold sees of calm frames is asked of all of them."""
AT_ONCE = replace(QUARTER_OF_THE_FRAMES, duration_s=6.8)
"""Enough where all faults come at once: for the longest redeploy, and what follows it."""
UNTIL_ALL_CAME = replace(QUARTER_OF_THE_FRAMES, duration_s=14.4)
"""Enough for all that heals, and for what comes last to be missed; longer, nothing new would come."""

TIMINGS = {
    "single": AT_ONCE,
    "outages": AT_ONCE,
    "timed": UNTIL_ALL_CAME,
    "transient": UNTIL_ALL_CAME,
    "cascade": UNTIL_ALL_CAME,
    "calm": Timing(duration_s=14.4, warm_up_s=0.5),
    "long": QUARTER_OF_THE_FRAMES,  # as long as the scenarios are
}
"""Suite → how its scenarios are run where a managing system has time to repair."""


def beginning(scenario: Scenario, duration_s: float) -> Scenario:
    """Return a scenario without what comes later."""
    begun = zip(scenario.faults, onsets(scenario.faults), strict=True)
    faults = tuple(fault for fault, onset in begun if onset < duration_s)
    return replace(scenario, faults=faults, duration=duration_s)


def times(fault: ScenarioFault, onset: float, end: float) -> Iterator[tuple[str, float, float | None]]:
    """Yield when a fault that nobody cures comes and when it heals, as often as it does."""
    last = end if fault.until is None else fault.until
    on, off = fault.profile.on or inf, fault.profile.off or inf
    while onset < min(last, end):
        healed = min(onset + on, last)
        yield fault.name, onset, healed if healed < end else None
        onset += on + off


def check_untouched(result: StoredRun, scenario: Scenario) -> None:
    """Check that every fault came when the scenario says, and healed when it says, where nothing was repaired."""
    begun = zip(scenario.faults, onsets(scenario.faults), strict=True)
    expected = sorted(one for fault, onset in begun for one in times(fault, onset, scenario.duration))
    came = sorted(
        (one.fault, one.time, None if (one.healed or inf) > scenario.duration else one.healed)
        for one in result.timeline.injections
    )
    assert [name for name, _, _ in came] == [name for name, _, _ in expected]
    for (_, *there), (_, *planned) in zip(came, expected, strict=True):
        assert there == pytest.approx(planned, abs=0.05)
    assert result.metrics.adaptations == 0


def check_followed(result: StoredRun, scenario: Scenario) -> None:
    """Check that a fault came after another one if that was still there, and only then."""
    came = {one.fault: one for one in result.timeline.injections}
    for fault in scenario.faults:
        if fault.after is None:
            continue
        cause = came.get(fault.after.fault)
        due = inf if cause is None else cause.time + fault.after.delay
        is_there = cause is not None and (cause.ended is None or cause.ended > due)
        assert (fault.name in came) == is_there, (scenario.name, fault.name)


@pytest.mark.usefixtures("flight")
@pytest.mark.parametrize(("name", "duration_s"), BEGINNINGS.items())
def test_a_scenario_of_each_suite_begins_as_it_says(name: str, duration_s: float, tmp_path: Path) -> None:
    scenario = beginning(load_scenario(name), duration_s)
    settings = Settings(timing=Timing(warm_up_s=0.5))

    result = run(RunSpec(scenario=scenario, manager="none", seed=2, settings=settings), tmp_path / "run")

    assert result.valid
    check_untouched(result, scenario)
    assert (result.metrics.episodes == 0) == name.startswith("calm/")


@pytest.mark.thorough
@pytest.mark.usefixtures("flight")
@pytest.mark.parametrize("name", TIMINGS)
def test_every_scenario_runs_to_its_end_with_none_and_the_baseline(
    name: str, flight: Path, tmp_path: Path
) -> None:
    timing = TIMINGS[name]
    settings = Settings(timing=timing)
    if name == "long":  # longer than the flight: a part of it does, again and again
        bag = tmp_path / "bag"
        with read_bag(flight) as reader:
            write_bag(bag, map(reader.frame, range(40)), reader.stamps_ns[:40])
        settings = replace(settings, bag=bag, loop=True)
    spec = BenchSpec(suite=name, references=False, score=False, repetitions=1, seed=5, settings=settings)

    bench(spec, tmp_path / "out", jobs=1)

    runs = [read_stored_run(file.parent) for file in tmp_path.glob(f"out/runs/*/*/*/*/{RUN_FILE}")]
    results = {(one.record.manager, one.record.scenario): one for one in runs}
    assert len(results) == len(runs) == 2 * len(suite(name))
    costs: dict[str, list[float]] = {"none": [], "baseline": []}
    for scenario in suite(name):
        untouched, repaired = (results[manager, scenario.name] for manager in costs)
        assert untouched.valid, untouched.record.reason
        assert repaired.valid, repaired.record.reason
        check_untouched(untouched, beginning(scenario, timing.duration_s or scenario.duration))
        for manager, downs in costs.items():
            downs.append(results[manager, scenario.name].metrics.t_down_s)
        if name == "calm":
            assert untouched.metrics.episodes == repaired.metrics.episodes == 0, scenario.name
            assert repaired.metrics.adaptations == 0
            assert repaired.metrics.iou_all == untouched.metrics.iou_all
        else:
            assert untouched.metrics.episodes > 0, scenario.name
        check_followed(repaired, scenario)
    if name == "calm":
        assert costs["none"] == costs["baseline"]
    elif name == "transient":  # some are worth repairing, and some are not
        cheaper = [one < other for one, other in zip(*costs.values(), strict=True)]
        assert any(cheaper)
        assert not all(cheaper)
    else:
        assert sum(costs["baseline"]) < sum(costs["none"])
    if name == "cascade":  # the baseline cures some in time, and others not
        kept = [
            len(results["none", one.name].timeline.injections)
            - len(results["baseline", one.name].timeline.injections)
            for one in suite(name)
        ]
        assert min(kept) == 0
        assert max(kept) > 0


@pytest.mark.thorough
@pytest.mark.usefixtures("flight")
def test_no_threshold_sees_what_is_calm_wherever_in_the_flight_it_begins(tmp_path: Path) -> None:
    settings = Settings(timing=Timing(warm_up_s=0.5))
    spec = BenchSpec(
        suite="calm",
        managers=("none",),
        references=False,
        score=False,
        repetitions=1,
        seed=11,
        settings=settings,
    )
    bench(spec, tmp_path, jobs=1)
    runs = [read_stored_run(file.parent) for file in tmp_path.glob(f"runs/*/*/*/*/{RUN_FILE}")]
    assert len(runs) == len(suite("calm"))
    assert [(one.record.scenario, one.record.seed) for one in runs if one.metrics.episodes] == []
