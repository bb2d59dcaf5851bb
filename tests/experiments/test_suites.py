"""The suites from `single` on, run end to end: what they say comes, and nothing is seen of what is calm."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from sunset.experiments import BenchSpec, RunSpec, Settings, Timing, bench, run
from sunset.recording import RUN_FILE, StoredRun, read_stored_run
from sunset.scenarios import Scenario, load_scenario, onsets, suite

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

AT_ONCE_S = 6.5
"""How long is enough where all faults come at once: for the longest redeploy, and what follows it."""


def beginning(scenario: Scenario, duration_s: float) -> Scenario:
    """Return a scenario without what comes later."""
    begun = zip(scenario.faults, onsets(scenario.faults), strict=True)
    faults = tuple(fault for fault, onset in begun if onset < duration_s)
    return replace(scenario, faults=faults, duration=duration_s)


def check_untouched(result: StoredRun, scenario: Scenario) -> None:
    """Check that every fault came when the scenario says, and healed when it says, where nothing was repaired."""
    begun = sorted(zip(onsets(scenario.faults), scenario.faults, strict=True), key=lambda pair: pair[0])
    came = sorted(result.timeline.injections, key=lambda injection: injection.time)
    assert Counter(one.fault for one in came) == Counter(fault.name for _, fault in begun)
    assert [one.time for one in came] == pytest.approx([onset for onset, _ in begun], abs=0.05)
    expected = {
        (fault.name, fault.until) for _, fault in begun if fault.until and fault.until < scenario.duration_s
    }
    healed = {(one.fault, round(one.healed, 1)) for one in came if one.healed is not None}
    assert healed == expected
    assert result.metrics.adaptations == 0


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
@pytest.mark.parametrize("name", ["single", "outages", "timed", "transient", "cascade", "calm", "long"])
def test_every_scenario_runs_to_its_end_with_none_and_the_baseline(name: str, tmp_path: Path) -> None:
    at_once = name in {"single", "outages"}
    settings = Settings(timing=Timing(duration_s=AT_ONCE_S if at_once else None), loop=name == "long")
    spec = BenchSpec(suite=name, references=False, repetitions=1, seed=5, settings=settings)

    bench(spec, tmp_path, jobs=1)

    runs = [read_stored_run(file.parent) for file in tmp_path.glob(f"runs/*/*/*/*/{RUN_FILE}")]
    results = {(one.record.manager, one.record.scenario): one for one in runs}
    assert len(results) == len(runs) == 2 * len(suite(name))
    costs: dict[str, list[float]] = {"none": [], "baseline": []}
    for scenario in suite(name):
        untouched, repaired = (results[manager, scenario.name] for manager in costs)
        assert untouched.valid, untouched.record.reason
        assert repaired.valid, repaired.record.reason
        check_untouched(untouched, beginning(scenario, AT_ONCE_S) if at_once else scenario)
        for manager, downs in costs.items():
            downs.append(results[manager, scenario.name].metrics.t_down_s)
        if name == "calm":
            assert untouched.metrics.episodes == repaired.metrics.episodes == 0, scenario.name
            assert repaired.metrics.adaptations == 0
            assert repaired.metrics.iou_all == untouched.metrics.iou_all
        else:
            assert untouched.metrics.episodes > 0, scenario.name
        if name == "cascade":
            first = repaired.timeline.injections[0]
            assert (len(repaired.timeline.injections) == 1) == (first.cause != ""), scenario.name
    if name == "calm":
        assert costs["none"] == costs["baseline"]
    elif name == "transient":  # some are worth repairing, and some are not
        cheaper = [one < other for one, other in zip(*costs.values(), strict=True)]
        assert any(cheaper)
        assert not all(cheaper)
    else:
        assert sum(costs["baseline"]) < sum(costs["none"])


@pytest.mark.thorough
@pytest.mark.usefixtures("flight")
def test_no_threshold_sees_what_is_calm_wherever_in_the_flight_it_begins(tmp_path: Path) -> None:
    spec = BenchSpec(suite="calm", managers=("none",), references=False, repetitions=2, seed=11)
    bench(spec, tmp_path, jobs=1)
    runs = [read_stored_run(file.parent) for file in tmp_path.glob(f"runs/*/*/*/*/{RUN_FILE}")]
    assert len(runs) == 2 * len(suite("calm"))
    assert [(one.record.scenario, one.record.seed) for one in runs if one.metrics.episodes] == []
