"""Faults that come, heal, grow and follow each other in a live run, as in the simulation."""

from pathlib import Path

import pytest

from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.metrics import Injection
from sunset.scenarios import parse_scenario

pytestmark = [pytest.mark.xdist_group("live"), pytest.mark.thorough]

SCENARIO = """\
name: timed
duration: 8
faults:
  - {name: camera_driver_issue, at: 1.0, until: 3.0}
  - {name: image_degradation, at: 1.5, until: 6.0, profile: {kind: ramp, rise: 2.0}}
  - {name: autofocus_needed, at: 4.0, until: 7.0, profile: {kind: intermittent, on: 1.0, off: 0.8}}
  - {name: cuda_out_of_memory, at: 3.5}
  - {name: gpu_failure, after: {fault: cuda_out_of_memory, delay: 2.5}}
"""


def injections(folder: Path, manager: str, middleware: str) -> tuple[Injection, ...]:
    settings = Settings(timing=Timing(warm_up_s=1.0), middleware=middleware)
    spec = RunSpec(scenario=parse_scenario(SCENARIO, "here"), manager=manager, seed=3, settings=settings)
    return run(spec, folder).timeline.injections


def test_faults_come_and_go_live_as_in_the_simulation(tmp_path: Path) -> None:
    simulated = injections(tmp_path / "sim", "none", "sim")
    live = injections(tmp_path / "live", "none", "cyclonedds")

    assert [(one.fault, one.cause) for one in live] == [(one.fault, one.cause) for one in simulated]
    for ours, theirs in zip(live, simulated, strict=True):
        assert ours.time == pytest.approx(theirs.time, abs=0.15)
        assert ours.healed == pytest.approx(theirs.healed, abs=0.15)
    assert [one.fault for one in live].count("gpu_failure") == 1


def test_what_is_cured_in_time_brings_nothing_live(tmp_path: Path) -> None:
    # which cure comes first depends on what is heard first
    cured = {one.fault: one.cause for one in injections(tmp_path, "reactive", "cyclonedds")}
    assert cured.pop("image_degradation") == ""
    assert all(cured.values())
    assert set(cured) == {"camera_driver_issue", "autofocus_needed", "cuda_out_of_memory"}
