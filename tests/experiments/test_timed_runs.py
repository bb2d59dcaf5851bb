"""Whole runs of scenarios in time: what a fault that heals costs, and whether one that is cured brings another."""

from pathlib import Path

import pytest

from sunset.errors import ScenarioError
from sunset.experiments import RunSpec, RunTiming, Settings, Timing, run, run_again
from sunset.recording import StoredRun, read_stored_run
from sunset.scenarios import Scenario, ScenarioFault, parse_scenario
from sunset.system import extended_system

SHORT = Timing(warm_up_s=0.5)
TRANSIENT = """\
name: transient
duration: 8
faults:
  - {name: camera_driver_issue, at: 1.5, until: 3.5}
  - {name: depth_degradation, at: 7, profile: {kind: ramp, rise: 0.5}}
"""
CASCADE = """\
name: cascade
duration: 5
faults:
  - cuda_out_of_memory
  - {name: gpu_failure, after: {fault: cuda_out_of_memory, delay: 3.5}}
"""


def fly(folder: Path, text: str, manager: str) -> StoredRun:
    spec = RunSpec(
        scenario=parse_scenario(text, "here"), manager=manager, seed=2, settings=Settings(timing=SHORT)
    )
    return run(spec, folder)


def test_an_outage_that_heals_costs_what_it_lasts_and_more_if_it_is_repaired(tmp_path: Path) -> None:
    untouched = fly(tmp_path / "untouched", TRANSIENT, "none")

    assert untouched.valid
    assert untouched.metrics.t_down_s == pytest.approx(2.0, abs=0.25)
    (outage, _) = untouched.timeline.injections
    assert (outage.time, outage.healed) == pytest.approx((1.5, 3.5), abs=0.01)
    camera = untouched.episodes[0]
    assert (camera.failure, camera.began) == ("F1", outage.time)
    assert untouched.metrics.episodes_resolved == 0
    assert untouched.metrics.episodes_subsided == 3
    assert "camera_driver_issue has healed by itself" in str(untouched)
    assert "camera_driver_issue (1.5 to 3.5 s), depth_degradation (from 7 s on, ramp)" in str(untouched)

    redeployed = fly(tmp_path / "redeployed", TRANSIENT, "baseline")

    assert redeployed.metrics.t_down_s > 4
    assert redeployed.metrics.redeploys_unnecessary == 3
    assert redeployed.timeline.injections[0].cause == "redeploy camera"
    assert redeployed.episodes[0].t_react == pytest.approx(1.1, abs=0.2)

    again = run_again(tmp_path / "redeployed", tmp_path / "again")
    assert again.record.faults == redeployed.record.faults


def test_a_fault_that_is_cured_brings_no_other(tmp_path: Path) -> None:
    left = fly(tmp_path / "left", CASCADE, "none")
    cured = fly(tmp_path / "cured", CASCADE, "baseline")

    assert [one.fault for one in left.timeline.injections] == ["cuda_out_of_memory", "gpu_failure"]
    assert left.timeline.injections[1].time == pytest.approx(3.5, abs=0.01)
    assert [one.fault for one in cured.timeline.injections] == ["cuda_out_of_memory"]
    assert left.valid
    assert cured.valid


def timing(seed: int, scenario: Scenario, **options: float) -> RunTiming:
    settings = Settings(timing=Timing(**options))
    return RunSpec(scenario=scenario, seed=seed, settings=settings).timing


def test_the_seed_draws_the_warm_up_and_the_scenario_says_the_duration() -> None:
    long = Scenario("long", (ScenarioFault("gpu_failure", at=30.0),), duration=40.0)
    drawn = [timing(seed, long).warm_up_s for seed in range(200)]

    assert 3.0 <= min(drawn) < 3.1
    assert 5.9 < max(drawn) <= 6.0
    assert sum(drawn) / len(drawn) == pytest.approx(4.5, abs=0.2)
    assert len({round(one % 0.1, 3) for one in drawn}) > 50  # not on the frames
    assert {timing(seed, long).frames for seed in range(20)} == {460}  # which tell nothing of it
    assert timing(1, long).duration_s == 40.0
    assert timing(1, long, duration_s=31.0).duration_s == 31.0
    assert timing(1, Scenario("plain")).duration_s == 20.0
    with pytest.raises(ScenarioError, match="gpu_failure comes at 30 s, and the run ends at 20 s"):
        timing(1, long, duration_s=20.0)


def test_a_fault_of_an_extension_grows_and_heals(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "extending.md").read_text(encoding="utf-8")
    extension = tmp_path / "altimeter.py"
    extension.write_text(page.split("```python\n")[1].split("```")[0], encoding="utf-8")
    fault = "{name: altimeter_drift, at: 0.5, until: 2.5, profile: {kind: ramp, rise: 1}}"
    text = f"name: drift\nduration: 4\nfaults:\n- {fault}\n"

    with extended_system([str(extension)]):
        drifted = fly(tmp_path / "run", text, "none")
        assert read_stored_run(tmp_path / "run").timeline.injections == drifted.timeline.injections

    (drift,) = drifted.timeline.injections
    (episode,) = drifted.episodes
    assert (drift.time, drift.healed) == pytest.approx((0.5, 2.5), abs=0.01)
    assert (episode.failure, episode.began, episode.adaptation) == ("F6", drift.time, None)
    assert 0.5 < episode.t_detect < 1.5
    assert episode.ended == pytest.approx(2.9, abs=0.3)


FLOOD = """
from sunset_ros.interfaces.rcl_interfaces.srv import SetParameters
from sunset.managing import ManagingSystem

class Flood(ManagingSystem):
    def on_start(self):
        self.asking = self.create_client(SetParameters, "/managed_subsystem/camera/set_parameters")
        self.sent = 0

    def adapt(self, symptoms):
        for _ in range(1100 if self.sent else 8000):
            self.asking.call_async(SetParameters.Request())
        self.sent += 1
"""


@pytest.mark.thorough
def test_no_flood_of_requests_keeps_a_fault_away(tmp_path: Path) -> None:
    (tmp_path / "flood.py").write_text(FLOOD, encoding="utf-8")
    scenario = "name: one\nduration: 2\nfaults: [{name: hardware_disconnect, at: 0.5}]"
    flooded = fly(tmp_path / "run", scenario, f"{tmp_path / 'flood.py'}:Flood")
    assert [one.fault for one in flooded.timeline.injections] == ["hardware_disconnect"]
    assert flooded.metrics.t_down_s > 1
