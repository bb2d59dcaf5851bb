"""Live runs: a record as of the simulation, whatever happens to a process; nothing is left running."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from tests.live.systems import (
    MANAGED,
    PATIENCE_S,
    Flow,
    Tool,
    benching,
    children,
    commanding,
    domain_of,
    eventually,
    exists,
    flying,
    fork_server,
)

from sunset.errors import MiddlewareError
from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.recording import read_messages, read_run, read_timeline
from sunset.scenarios import load_scenario
from sunset.system_interfaces.msg import ExperimentLogging
from sunset.system_interfaces.srv import Redeploy
from sunset.texts.names import base_name
from sunset_ros import Context, Node
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterEvent
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.rmw.dds import CycloneDDS, CycloneTap
from sunset_ros.rmw.dds.domains import free_domain_id

pytestmark = pytest.mark.xdist_group("live")

PROGRAMS = Path(__file__).parents[2] / "docs" / "programs"


def test_a_managing_system_of_another_process_redeploys_a_node_that_was_killed(tmp_path: Path) -> None:
    out = tmp_path / "run"
    with free_domain_id() as domain_id, flying("nofault", "external", 20.0, out, domain_id) as process:
        tool = Tool(domain_id)
        flow = Flow(tool)
        log: list[ExperimentLogging] = []
        tool.node.create_subscription(ExperimentLogging, "/experiment/log", log.append, 10)
        with subprocess.Popen(
            [sys.executable, "-m", "sunset", "node", "managing_system", "--manager", "baseline"],
            env=os.environ | {"ROS_DOMAIN_ID": str(domain_id)},
        ) as manager:
            try:
                assert tool.spin(lambda: any(one.rule_name == "start" for one in log))
                assert flow.lasts()
                killed = children(process.pid)["segmentation"]
                os.kill(killed, signal.SIGKILL)
                assert eventually(lambda: children(process.pid).get("segmentation", killed) != killed)
                assert flow.lasts()
                told, complaint = process.communicate(timeout=PATIENCE_S)
            finally:
                manager.terminate()
                tool.node.context.try_shutdown()
    assert process.returncode == 0, complaint
    summary = json.loads(told)
    assert (summary["middleware"], summary["manager"]) == ("cyclonedds", "external")
    (redeploy, *_) = read_timeline(out).commands
    assert redeploy.kind == "redeploy"
    assert redeploy.node == "/managed_subsystem/segmentation"
    assert redeploy.successful


@pytest.mark.thorough
def test_a_viewer_reads_the_truth_and_another_node_publishes_diagnostics(tmp_path: Path) -> None:
    out = tmp_path / "run"
    words = ("run", "nofault", "--middleware", "cyclonedds", "--manager", "none", "--duration", "5")
    with commanding(*words, "--viewer", "/recorder", "--json", "--out", str(out)) as process:
        tool = Tool(domain_of(process.pid))
        recorder = Node("recorder", context=tool.node.context)
        battery = Node("battery", context=tool.node.context)
        truths: list[Image] = []
        for node, topic in ((recorder, "/rgb_raw"), (recorder, "/gt_segmentation")):
            node.create_subscription(Image, topic, truths.append, 10)
        battery.create_subscription(ParameterEvent, "/parameter_events", lambda _: None, 10)
        levels = battery.create_publisher(DiagnosticArray, "/diagnostics", 10)
        for node in (recorder, battery):
            tool.executor.add_node(node)
        assert tool.spin(lambda: len(truths) > 20)
        levels.publish(
            DiagnosticArray(status=[DiagnosticStatus(name="battery: level", hardware_id="battery")])
        )
        told, complaint = process.communicate(timeout=PATIENCE_S)
        tool.node.context.try_shutdown()
    assert process.returncode == 0, complaint
    record = read_run(out)
    assert record.viewers == ["/recorder"]
    assert not any(word in record.reason for word in ("recorder", "battery", "truth", "/diagnostics")), told
    statuses = [message.message for message in read_messages(out, ["/diagnostics"])]
    assert any(one.status[0].hardware_id == "battery" for one in statuses if isinstance(one, DiagnosticArray))


@pytest.mark.thorough
def test_what_is_done_to_the_system_before_it_is_up_is_held_against_nobody(tmp_path: Path) -> None:
    out = tmp_path / "run"
    with free_domain_id() as domain_id, flying("gpu_failure", "external", 2.0, out, domain_id) as process:
        tool = Tool(domain_id)
        first = children(process.pid)["camera"]
        shutdown = ChangeState.Request(transition=Transition(label="shutdown"))
        assert tool.call(ChangeState, "/managed_subsystem/camera/change_state", shutdown).success
        assert eventually(lambda: not exists(first))
        assert tool.call(Redeploy, "/launcher/redeploy", Redeploy.Request(node="camera")).success
        with subprocess.Popen(
            [sys.executable, "-m", "sunset", "node", "managing_system", "--manager", "none"],
            env=os.environ | {"ROS_DOMAIN_ID": str(domain_id)},
        ) as manager:
            try:
                _, complaint = process.communicate(timeout=PATIENCE_S)
            finally:
                manager.terminate()
                tool.node.context.try_shutdown()
    assert process.returncode == 0, complaint
    timeline = read_timeline(out)
    assert [injection.fault for injection in timeline.injections] == ["gpu_failure"]
    assert timeline.commands == ()


@pytest.mark.thorough
def test_a_managing_system_that_keeps_the_system_from_coming_up_does_not_end_its_campaign(
    tmp_path: Path,
) -> None:
    with (
        free_domain_id() as domain_id,
        benching(tmp_path / "out", "external", bring_up_limit_s=15.0, domain_id=domain_id) as process,
    ):
        tool = Tool(domain_id)
        shutdown = ChangeState.Request(transition=Transition(label="shutdown"))
        assert tool.call(ChangeState, "/managed_subsystem/camera/change_state", shutdown).success
        runs = tmp_path / "out/runs/nofault/external/nofault"
        assert eventually(lambda: (runs / "seed-1/run.json").is_file() or process.poll() is not None)
        assert process.poll() is None, process.communicate()
        with subprocess.Popen(
            [sys.executable, "-m", "sunset", "node", "managing_system", "--manager", "none"],
            env=os.environ | {"ROS_DOMAIN_ID": str(domain_id)},
        ) as manager:
            try:
                _, complaint = process.communicate(timeout=PATIENCE_S)
            finally:
                manager.terminate()
                tool.node.context.try_shutdown()
    assert process.returncode == 0, complaint
    failed, flown = (read_run(runs / f"seed-{seed}") for seed in (1, 2))
    reason = "The managed system did not come up within 15 s in nofault, seed 1: camera is "
    assert (failed.manager_failed or "").startswith(reason)
    assert (failed.valid, flown.manager_failed) == (False, None)


@pytest.mark.thorough
@pytest.mark.parametrize("ends", [False, True])
def test_a_program_manages_a_live_run(ends: bool, tmp_path: Path) -> None:
    command = "exec:sh -c 'exit 3'" if ends else f"exec:python3 {PROGRAMS}/baseline.py"
    timing = Timing(duration_s=1.0 if ends else 3.0, warm_up_s=1.0)
    settings = Settings(timing=timing, thinking_s=0.5, middleware="cyclonedds")
    spec = RunSpec(scenario=load_scenario("gpu_failure"), manager=command, settings=settings)

    result = run(spec, tmp_path / "run")

    if ends:
        failed = f"The managing system {command} failed in gpu_failure, seed 1: it broke the protocol: line 1 of its "
        assert (result.record.manager_failed or "").startswith(failed)
        assert result.timeline.commands == ()
    else:
        assert result.record.manager_failed is None
        (redeploy,) = result.timeline.commands
        assert redeploy.time > 1.0 + settings.thinking_s - 0.2


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("outage", "node"), [("cuda_out_of_memory", "segmentation"), ("short_buffer", "sensor_fusion")]
)
def test_the_oracle_is_told_live_too(outage: str, node: str, tmp_path: Path) -> None:
    timing = Timing(duration_s=3.0, warm_up_s=1.0)
    settings = Settings(timing=timing, middleware="cyclonedds")
    scenario = load_scenario(f"{outage}+autofocus_needed")

    result = run(RunSpec(scenario=scenario, manager="oracle", settings=settings), tmp_path / "run")

    assert result.record.manager_failed is None
    assert {(command.kind, base_name(command.node)) for command in result.timeline.commands} == {
        ("deactivate", node),
        ("activate", node),
        ("set_parameters", "camera"),
    }
    assert all(command.time < 1.0 for command in result.timeline.commands)  # before a symptom can show
    assert result.metrics.faults_cured == 2
    assert "the truth" not in result.record.reason


@pytest.mark.thorough
def test_a_run_of_which_nothing_can_be_seen_any_more_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pids: dict[str, int] = {}

    def check(_: CycloneTap) -> None:
        pids.update(children(os.getpid()))
        if set(pids) >= set(MANAGED):
            raise MiddlewareError("Nothing is heard any more.")

    monkeypatch.setattr(CycloneTap, "check", check)
    spec = RunSpec(
        scenario=load_scenario("nofault"),
        manager="none",
        settings=Settings(middleware="cyclonedds", cache=False),
    )
    with pytest.raises(MiddlewareError, match="Nothing is heard any more"):
        run(spec, tmp_path / "run")
    assert eventually(lambda: not any(exists(pid) for pid in pids.values()))
    assert list(tmp_path.iterdir()) == []


def test_a_node_that_a_run_before_has_left_keeps_the_next_from_starting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with free_domain_id() as domain_id:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain_id))
        context = Context()
        context.init([], middleware=CycloneDDS(domain_id=domain_id), log_to_stderr=False)
        Node("camera", namespace="/managed_subsystem", context=context)
        try:
            spec = RunSpec(
                scenario=load_scenario("nofault"),
                manager="external",
                settings=Settings(middleware="cyclonedds"),
            )
            with pytest.raises(
                MiddlewareError, match=f"Domain {domain_id} already has /managed_subsystem/camera: "
            ):
                run(spec, tmp_path / "run")
        finally:
            context.try_shutdown()
    assert list(tmp_path.iterdir()) == []


RUN = ("run", "nofault", "--out", "out/run")
BENCH = ("bench", "--suite", "nofault", "--managers", "none", "--repetitions", "1", "--out", "out")


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "number"), [(RUN, signal.SIGINT), (RUN, signal.SIGTERM), (BENCH, signal.SIGTERM)]
)
def test_what_is_interrupted_leaves_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], number: int
) -> None:
    monkeypatch.chdir(tmp_path)
    for variable in ("TMPDIR", "XDG_RUNTIME_DIR"):
        (tmp_path / variable).mkdir()
        monkeypatch.setenv(variable, str(tmp_path / variable))
    with commanding(*words, "--middleware", "cyclonedds") as process:
        pids = [*children(process.pid).values(), fork_server(process.pid)]
        process.send_signal(number)
        process.send_signal(number)
        _, complaint = process.communicate(timeout=PATIENCE_S)
        assert [pid for pid in pids if exists(pid)] == []
    assert process.returncode == 128 + number
    remedy = "; the same command continues it" if words is BENCH else ""
    assert complaint.splitlines()[-1] == f"Interrupted{remedy}."
    assert "Traceback" not in complaint
    left = {path.name for path in tmp_path.rglob("*") if path.is_file()}
    assert left == ({"bench.json", ".lock"} if words is BENCH else set())
    assert list((tmp_path / "TMPDIR").iterdir()) == []


@pytest.mark.thorough
def test_no_process_outlives_a_run_that_is_killed_even_one_that_is_stopped(tmp_path: Path) -> None:
    with flying("nofault", "none", 20.0, tmp_path / "run") as process:
        nodes = children(process.pid)
        pids = [*nodes.values(), fork_server(process.pid)]
        for stopped in (nodes["depth"], pids[-1]):
            os.kill(stopped, signal.SIGSTOP)
        process.kill()
        assert eventually(lambda: not any(exists(pid) for pid in pids))
