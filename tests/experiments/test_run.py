"""Whole experiments: what comes out, that it comes out again, and that nobody can flatter themselves."""

import os
import re
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sunset.data import read_bag, write_bag
from sunset.errors import DataError, ManagerError, SunsetError
from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.metrics import score
from sunset.perception import Segmenter
from sunset.recording import StoredRun, read_messages, read_run, read_stored_run, read_timeline
from sunset.scenarios import load_scenario, suite
from sunset.system import current_system, extended_system
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterEvent
from sunset_ros.parameter import scalar_of
from sunset_ros.seeding import drawn_seed

FAULTS = current_system().faults

SHORT = Timing(duration_s=4.0, warm_up_s=1.0)
REDEPLOYED = Timing(duration_s=8.0, warm_up_s=1.0)
"""Long enough for the longest redeploy, of 4 s."""
OUTAGES = [fault.name for fault in FAULTS.values() if fault.failure in {"F1", "F2", "F3"}]
CENSUS = Path(__file__).with_name("census.py")
RULE_BREAKERS = Path(__file__).with_name("rule_breakers.py")

pytestmark = pytest.mark.usefixtures("flight")


def fly(
    folder: Path, scenario: str, manager: str = "baseline", *, seed: int = 1, **settings: Any
) -> StoredRun:
    used = Settings(**{"timing": SHORT} | settings)
    return run(RunSpec(scenario=load_scenario(scenario), manager=manager, seed=seed, settings=used), folder)


def content(folder: Path) -> dict[str, bytes]:
    """Return every file below a folder."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_without_a_fault_nothing_happens(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", "nofault", "none")

    assert result.metrics.episodes == 0
    assert result.metrics.t_down_s == 0
    assert result.metrics.iou is not None
    assert result.metrics.iou == pytest.approx(result.metrics.iou_all)
    assert len(result.timeline.frames.times) >= 40


def test_the_metrics_are_those_of_the_stored_record(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", "hardware_disconnect+autofocus_needed")

    assert read_run(tmp_path / "run").metrics == score(read_timeline(tmp_path / "run")).to_json()
    stored = read_stored_run(tmp_path / "run")
    assert (result.folder, result.record, result.metrics, result.log, result.differing) == (
        stored.folder,
        stored.record,
        stored.metrics,
        stored.log,
        (),
    )


def test_the_baseline_redeploys_what_is_silent_and_recalibrates_what_is_unsure(tmp_path: Path) -> None:
    timing = Timing(duration_s=12.0, warm_up_s=1.0)
    result = fly(tmp_path / "run", "hardware_disconnect+depth_degradation", timing=timing)

    assert sorted(str(adaptation) for adaptation in result.metrics.executed) == [
        "redeploy camera",
        "redeploy segmentation",
        "redeploy sensor_fusion",
        "set sensor_fusion.do_recalibration to true",
    ]
    assert result.metrics.redeploys_unnecessary == 2
    assert result.metrics.episodes_resolved == 3


@pytest.mark.thorough
@pytest.mark.parametrize("fault", OUTAGES)
def test_never_repairing_is_worst(fault: str, tmp_path: Path) -> None:
    idle = fly(tmp_path / "idle", fault, "none", timing=REDEPLOYED).metrics
    baseline = fly(tmp_path / "baseline", fault, "baseline", timing=REDEPLOYED).metrics

    assert idle.t_down_s == pytest.approx(REDEPLOYED.duration_s, abs=0.2)
    assert idle.t_down_s > baseline.t_down_s + 1
    assert idle.episodes_unresolved == idle.episodes
    assert baseline.episodes_unresolved == 0


def test_false_claims_of_success_change_no_metric(tmp_path: Path) -> None:
    scenario = "camera_driver_issue+image_shift"
    silent = fly(tmp_path / "silent", scenario, "none")
    claiming = fly(tmp_path / "claiming", scenario, f"{RULE_BREAKERS}:Claimer")

    assert claiming.valid
    assert claiming.metrics == silent.metrics


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("manager", "word"),
    [
        ("Bypass", "sensor_fusion subscribes to /rgb_raw, which only /managed_subsystem/camera may"),
        ("Forger", "publishes on /managed_subsystem/segmentation"),
        ("Eavesdropper", "subscribes to /gt_segmentation"),
        ("Peeper", "reads the fault parameter hardware_disconnect"),
        ("Wizard", "sets the fault parameter hardware_disconnect"),
        ("Seer", "reads the seed of /managed_subsystem/depth, which belongs to the experiment"),
        ("Spy", "/spy subscribes to /gt_segmentation"),
        ("Impostor", "has a node /launcher"),
        ("Stand", "offers /managed_subsystem/camera/set_parameters"),
        ("Feeder", "sensor_fusion subscribes to /mine/rgb, on which the managed system does not publish"),
        ("Impatient", "/managing_system sets use_sim_time of /managed_subsystem/camera"),
        ("Ventriloquist", "publishes on /parameter_events in the name of another node"),
        ("Conductor", "calls /scenario_executor/inject"),
    ],
)
def test_whoever_breaks_the_rules_is_not_scored(manager: str, word: str, tmp_path: Path) -> None:
    result = fly(tmp_path / "run", "hardware_disconnect", f"{RULE_BREAKERS}:{manager}")

    assert not result.valid
    assert word in result.reason
    assert read_run(tmp_path / "run").valid is False


def test_of_thousands_of_violations_the_first_are_named_and_all_are_counted(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", "nofault", f"{RULE_BREAKERS}:Trespasser")

    assert result.reason.count("which belongs to the experiment") == 20
    assert result.reason.endswith("; and 1980 more violations")


@pytest.mark.thorough
def test_until_the_injection_the_graph_is_the_same_in_every_scenario(tmp_path: Path) -> None:
    before = []
    scenarios = [suite(name)[0].name for name in ("nofault", "paper", "degraded")]
    for number, scenario in enumerate(scenarios):
        result = fly(
            tmp_path / str(number),
            scenario,
            f"{CENSUS}:Census",
            timing=Timing(duration_s=1.0, warm_up_s=0.5),
        )
        seen = [line for line in result.log if line.logger == "managing_system" and line.time < 0]
        before.append([(line.time, line.text) for line in seen])

    assert len(before[0]) > 20
    assert int(before[0][-1][1].split()[1]) > 5000
    assert "('scenario_executor', '/')" in before[0][-1][1]
    assert before[1:] == before[:1] * 2


@pytest.mark.parametrize("middleware", ["sim", "cyclonedds"])
def test_a_managing_system_with_the_name_of_a_node_of_the_system_is_refused(
    middleware: str, tmp_path: Path
) -> None:
    with pytest.raises(ManagerError, match="has the name /experiment, which is a node of the system"):
        fly(tmp_path / "run", "nofault", f"{RULE_BREAKERS}:Namesake", middleware=middleware)


def test_a_forged_segmentation_does_not_end_the_downtime(tmp_path: Path) -> None:
    silent = fly(tmp_path / "silent", "gpu_failure", "none")
    forged = fly(tmp_path / "forged", "gpu_failure", f"{RULE_BREAKERS}:Forger")

    assert forged.metrics.t_down_s == silent.metrics.t_down_s


@pytest.mark.thorough
@pytest.mark.parametrize("fault", FAULTS)
def test_the_same_seed_gives_the_same_bytes(fault: str, tmp_path: Path) -> None:
    timing = Timing(duration_s=2.0, warm_up_s=1.0)
    fly(tmp_path / "cached", fault, timing=timing, seed=7)
    fly(tmp_path / "computed", fault, timing=timing, seed=7, cache=False)

    assert content(tmp_path / "cached") == content(tmp_path / "computed")


def test_another_seed_gives_another_record(tmp_path: Path) -> None:
    timing = Timing(duration_s=2.0, warm_up_s=1.0)

    one, other = (fly(tmp_path / f"{seed}", "nofault", timing=timing, seed=seed) for seed in (1, 2))

    assert one.digest != other.digest


def test_no_node_tells_the_seed_of_the_run(tmp_path: Path) -> None:
    fly(tmp_path / "run", "nofault", timing=Timing(duration_s=2.0, warm_up_s=1.0), seed=70_707)

    events = [recorded.message for recorded in read_messages(tmp_path / "run", ["/parameter_events"])]
    declared = [
        (parameter.name, scalar_of(parameter.value))
        for event in events
        if isinstance(event, ParameterEvent)
        for parameter in event.new_parameters
    ]
    assert [value for name, value in declared if name == "seed"] == [drawn_seed(70_707, "depth")]
    assert 70_707 not in {value for _, value in declared}


EVERY_FAULT = (
    "image_degradation+image_shift+autofocus_needed+depth_degradation+hardware_disconnect",
    "unneeded_enhancement+camera_driver_issue+sync_issue+memory_leakage+cuda_out_of_memory+gpu_failure",
)


@pytest.mark.parametrize("scenario", EVERY_FAULT)
def test_injections_do_not_show_on_parameter_events(scenario: str, tmp_path: Path) -> None:
    result = fly(tmp_path / "run", scenario, f"{RULE_BREAKERS}:Listener", timing=Timing(duration_s=2.0))
    shown, injected = (
        list(read_messages(tmp_path / "run", [topic]))
        for topic in ("/parameter_events", "/experiment/parameter_events")
    )
    changed = {
        parameter.name
        for recorded in injected
        if isinstance(recorded.message, ParameterEvent)
        for parameter in recorded.message.changed_parameters
    }

    assert result.valid, result.reason
    assert shown
    start_ns = result.record.start_ns
    assert isinstance(start_ns, int)
    assert all(recorded.time_ns < start_ns for recorded in shown)
    assert changed - {"fault_access"} == {FAULTS[name].parameter for name in scenario.split("+")}


@pytest.mark.thorough
def test_another_process_another_hash_seed_and_a_busy_machine_give_the_same_bytes(tmp_path: Path) -> None:
    scenario = "paper/sync_issue+image_degradation+depth_degradation"
    fly(tmp_path / "here", scenario, timing=Timing(duration_s=3.0), seed=5)
    busy = [
        subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2 * (os.cpu_count() or 1))
    ]
    try:
        command = [
            sys.executable,
            "-m",
            "sunset",
            "run",
            scenario,
            "--seed",
            "5",
            "--duration",
            "3",
            "--out",
            str(tmp_path / "there"),
        ]
        environment = os.environ | {"PYTHONHASHSEED": "4711"}
        subprocess.run(command, check=True, capture_output=True, env=environment)
    finally:
        for process in busy:
            process.kill()
            process.wait()

    assert content(tmp_path / "here") == content(tmp_path / "there")


@pytest.mark.thorough
def test_a_slower_computer_changes_no_byte(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    timing = Timing(duration_s=3.0, warm_up_s=1.0)
    fly(tmp_path / "fast", "cuda_out_of_memory+image_shift", timing=timing, cache=False)
    infer = Segmenter._run

    def slowly(*arguments: Any) -> Any:
        started = time.perf_counter()
        result = infer(*arguments)
        threading.Event().wait(9 * (time.perf_counter() - started))
        return result

    monkeypatch.setattr(Segmenter, "_run", slowly)
    fly(tmp_path / "slow", "cuda_out_of_memory+image_shift", timing=timing, cache=False)

    assert content(tmp_path / "fast") == content(tmp_path / "slow")


EAGER = """\
from sunset.managing import ManagingSystem

NODE_OF = {"rgb_camera": "camera", "sensors_fused": "sensor_fusion", "segmentation": "segmentation"}

class Mine(ManagingSystem):
    def adapt(self, symptoms):
        for topic, node in NODE_OF.items():
            if symptoms.frequency(topic) == 0 or symptoms.state(node) != "active":
                self.redeploy(node)
        if symptoms.get("segmentation_entropy") is None or symptoms.entropy > 1:
            self.restart("sensor_fusion")
"""


def test_a_first_manager_that_cures_at_once_does_not_keep_the_system_from_coming_up(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(EAGER, encoding="utf-8")

    result = fly(tmp_path / "run", "nofault", f"{tmp_path / 'mine.py'}:Mine")

    assert result.valid
    assert "redeploy" not in {command.kind for command in result.timeline.commands}


@pytest.fixture
def short_bag(tmp_path: Path, flight: Path) -> Path:
    with read_bag(flight) as reader:
        write_bag(tmp_path / "short", map(reader.frame, range(20)), reader.stamps_ns[:20])
    return tmp_path / "short"


def test_a_bag_that_is_too_short_is_looped_where_that_is_asked_for(short_bag: Path, tmp_path: Path) -> None:
    timing = Timing(duration_s=3.0, warm_up_s=1.0)
    with pytest.raises(DataError, match=r"holds 20 frames; an experiment needs 40 .* or --loop\."):
        fly(tmp_path / "short run", "nofault", bag=short_bag, timing=timing)

    first = fly(tmp_path / "1", "depth_degradation", bag=short_bag, loop=True, timing=timing, seed=2)
    fly(tmp_path / "2", "depth_degradation", bag=short_bag, loop=True, timing=timing, seed=2)

    assert content(tmp_path / "1") == content(tmp_path / "2")
    assert read_run(tmp_path / "1").bag_looped is True
    assert first.metrics.t_down_s == 0
    truths: list[Any] = [one.message for one in read_messages(tmp_path / "1", ["/gt_segmentation"])]
    stamps = [truth.header.stamp.sec * 10**9 + truth.header.stamp.nanosec for truth in truths]
    assert np.diff(stamps).tolist() == [10**8] * 39
    assert [bytes(truth.digest) for truth in truths[20:]] == [bytes(truth.digest) for truth in truths[:20]]


def test_looping_changes_nothing_where_the_bag_is_long_enough(tmp_path: Path) -> None:
    timing = Timing(duration_s=2.0, warm_up_s=1.0)
    once = fly(tmp_path / "once", "nofault", timing=timing)
    looped = fly(tmp_path / "looped", "nofault", timing=timing, loop=True)

    topics = ["/gt_segmentation", "/managed_subsystem/segmentation", "/seg_metrics"]
    assert read_messages(tmp_path / "once", topics) == read_messages(tmp_path / "looped", topics)
    assert once.metrics == looped.metrics


def test_a_managing_system_that_ends_a_node_for_good_averts_its_fault_and_pays_for_it(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", "gpu_failure", f"{RULE_BREAKERS}:Saboteur")

    assert result.valid
    assert result.timeline.injections == ()
    assert result.metrics.t_down_s == result.record.duration_s
    assert result.metrics.iou_all == 0


def test_a_class_in_place_of_the_segmentations_runs_in_the_simulation(tmp_path: Path) -> None:
    file = tmp_path / "thoughtful.py"
    file.write_text(
        "from sunset.nodes import SegmentationNode\nfrom sunset.system import Extension\n\n\n"
        "class Thoughtful(SegmentationNode):\n"
        "    def set_up(self):\n        super().set_up()\n        self.get_logger().info('thoughtful')\n\n\n"
        "EXTENSION = Extension(node_classes={'segmentation': Thoughtful})\n"
    )
    with extended_system([file]):
        result = fly(tmp_path / "run", "nofault", "none", timing=Timing(duration_s=1.0, warm_up_s=1.0))

    assert "thoughtful" in [line.text for line in result.log]


METER = """
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import String
from sunset.nodes import AdaptiveNode
from sunset.system import Extension, NodeDescription, Topic


class Meter(AdaptiveNode):
    node_name = "meter"

    def set_up(self) -> None:
        self.create_active_subscription(Image, "/managed_subsystem/rgb_camera", lambda message: None)
        self.create_lifecycle_publisher(String, "light", 10)


EXTENSION = Extension(nodes=(NodeDescription("meter", Meter, {inputs}, {outputs}),), topics=({topics}))
"""


@pytest.mark.parametrize(
    ("inputs", "outputs", "topics", "words"),
    [
        (("rgb_camera",), ("light",), "", ""),
        (("rgb_camera",), ("light",), "Topic('light', 'std_msgs/msg/String'),", ""),
        (
            ("rgb_camera",),
            ("light",),
            "Topic('light'),",
            "publishes std_msgs/msg/String on /managed_subsystem/light, described as sensor_msgs/msg/Image",
        ),
        (("rgb_camera",), ("dark",), "", "does not publish on /managed_subsystem/dark"),
        (
            ("depth_camera",),
            (),
            "",
            "subscribes to /managed_subsystem/rgb_camera, which is not among its inputs",
        ),
        (
            ("rgb_camera", "depth_camera"),
            (),
            "",
            "does not subscribe to /managed_subsystem/depth_camera, which is among its inputs",
        ),
    ],
)
def test_a_node_that_is_wired_otherwise_than_described_does_not_come_up(
    inputs: tuple[str, ...], outputs: tuple[str, ...], topics: str, words: str, tmp_path: Path
) -> None:
    file = tmp_path / "meter.py"
    file.write_text(METER.format(inputs=inputs, outputs=outputs, topics=topics))
    timing = Timing(duration_s=1.0, warm_up_s=1.0, bring_up_limit_s=6.0)
    with extended_system([file]):
        if not words:
            assert fly(tmp_path / "run", "nofault", "none", timing=timing).valid
            return
        with pytest.raises(SunsetError, match=re.escape(f"meter is active, but {words}")):
            fly(tmp_path / "run", "nofault", "none", timing=timing)


def test_a_node_that_publishes_a_truth_of_its_own_makes_a_run_invalid(tmp_path: Path) -> None:
    file = tmp_path / "meter.py"
    text = METER.format(inputs=("rgb_camera",), outputs=("light",), topics="")
    forging = "self.create_publisher(Image, '/gt_segmentation', 10).publish"
    file.write_text(text.replace("lambda message: None", forging))
    with extended_system([file]):
        result = fly(tmp_path / "run", "nofault", "none", timing=Timing(duration_s=1.0, warm_up_s=1.0))

    assert not result.valid
    assert result.reason == (
        "/managed_subsystem/meter publishes on /gt_segmentation, which is not among the outputs of its description"
    )


def test_a_signal_that_nothing_reports_makes_a_run_invalid(tmp_path: Path) -> None:
    file = tmp_path / "meter.py"
    file.write_text(
        "from sunset.system import Extension, Failure, Signal\n"
        "EXTENSION = Extension(signals=(Signal('depth', 'brightnes', threshold=1.0),),\n"
        "    failures=(Failure('F6', 'dark', symptom='dark', gone='light', signal='depth_brightnes'),))\n"
    )
    with extended_system([file]):
        result = fly(tmp_path / "run", "nofault", "none", timing=Timing(duration_s=1.0, warm_up_s=1.0))

    assert result.reason == "depth never reported brightnes, so that F6 could not be seen"
    assert not result.valid
