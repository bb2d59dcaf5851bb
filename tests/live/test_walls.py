"""A managing system of a live run is behind walls, and whatever becomes of it, the run goes on."""

import json
import runpy
from pathlib import Path

import pytest
from tests.live.systems import PATIENCE_S, children, domain_of, eventually, exists, flying

from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.harness.deployment import deployed_scenario
from sunset.processes.confinement.landlock import landlock_version
from sunset.scenarios import load_scenario

pytestmark = [pytest.mark.xdist_group("live"), pytest.mark.thorough]

SPY = """
import os
from pathlib import Path
from sunset.managing import ManagingSystem

def look():
    got = []
    for place in PLACES:
        try:
            got.append(Path(place).read_text()[:9] if Path(place).suffix else os.listdir(place)[:1])
        except OSError:
            pass
    try:
        Path(PLACES[-1], "written").write_text("")
        got.append("written")
    except OSError:
        pass
    return got

class Spy(ManagingSystem):
    def adapt(self, symptoms):
        print("no end", end="", flush=True)
        raise ValueError(f"got {look()}")
"""

HANGING = """
from sunset.managing import ManagingSystem

class Hangs(ManagingSystem):
    def adapt(self, symptoms):
        self.redeploy("camera")
        while True:
            pass
"""


@pytest.mark.skipif(not landlock_version(), reason="this system has not all of the walls")
def test_it_sees_neither_the_scenario_nor_other_runs_and_the_run_outlives_it(tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    (runs / "other").mkdir(parents=True)
    file = tmp_path / "mine" / "spy.py"
    file.parent.mkdir()
    scenarios = [
        str(deployed_scenario(number)) for number in range(102)
    ]  # it is there in the run's own domain
    file.write_text(f"PLACES = {[*scenarios, str(runs)]!r}\n{SPY}")
    with flying("gpu_failure", f"{file}:Spy", 2.0, runs / "run") as process:
        assert deployed_scenario(domain_of(process.pid)).is_file()
        unconfined = runpy.run_path(str(file))["look"]()
        (runs / "written").unlink()
        nodes = children(process.pid)
        told, complaint = process.communicate(timeout=PATIENCE_S)
    assert len(unconfined) >= 3, "the attack does not work"
    assert process.returncode == 0, complaint
    summary = json.loads(told)
    failed = f"The managing system {file}:Spy failed in gpu_failure, seed 1: it raised ValueError: got [] (spy.py, "
    assert summary["manager_failed"].startswith(failed)
    assert summary["metrics"]["t_down_s"] > 1.0
    assert sorted(path.name for path in runs.iterdir()) == ["other", "run"]
    assert eventually(lambda: not any(exists(pid) for pid in nodes.values()))


def test_one_that_hangs_is_ended_and_the_run_goes_on(tmp_path: Path) -> None:
    file = tmp_path / "hanging.py"
    file.write_text(HANGING)
    spec = RunSpec(
        scenario=load_scenario("nofault"),
        manager=f"{file}:Hangs",
        settings=Settings(
            timing=Timing(duration_s=6.0, warm_up_s=1.0), middleware="cyclonedds", manager_limit_s=1.0
        ),
    )
    result = run(spec, tmp_path / "run")
    failed = f"The managing system {file}:Hangs failed in nofault, seed 1: it did not return within 1 s (hanging.py, "
    assert (result.record.manager_failed or "").startswith(failed)
    # a slow computer is the only reason for which it may not count
    assert result.valid or result.record.reason.startswith("the computer was too slow"), result.record.reason
    assert result.metrics.iou_all is not None
    assert result.timeline.commands == ()
