"""Whatever a user gets wrong ends with one sentence and exit code 2, and loses nothing that was finished."""

import gc
import json
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from sunset.cli import main
from sunset.data import read_bag, write_bag
from sunset.perception import load_model


def written(path: Path, content: str | bytes) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


SCENARIOS: dict[str, tuple[str | bytes, str]] = {
    "empty": ("", "empty"),
    "a list of numbers": ("[1, 2]", "mapping"),
    "unclosed": ("name: x\nfaults: [{name: gpu_failure", "YAML"),
    "tabs": ("name: x\n\tfaults: []", "YAML"),
    "python object": ("name: !!python/object/apply:os.system ['true']\nfaults: []", "expected for 'name'"),
    "binary": (bytes(range(256)), "text"),
    "unknown fault": ("name: x\nfaults: [{name: rotor_failure}]", "rotor_failure"),
    "unknown key": ("name: x\nfailures: []", "failures"),
    "no name of a fault": ("name: x\nfaults: [{value: 1}]", "name"),
    "out of range": ("name: x\nfaults: [{name: image_degradation, value: 99}]", "99"),
    "negative": ("name: x\nfaults: [{name: depth_degradation, value: -1}]", "-1"),
    "text for a number": ("name: x\nfaults: [{name: image_shift, value: wide}]", "wide"),
    "a value that its tag does not fit": (
        "name: x\nfaults: [{name: image_shift, value: !!bool x}]",
        "is not a value",
    ),
    "a published infinity": (
        "- {name: image_shift, target_node: /x/sensor_fusion, type: parameter_adaptation, value: .inf}",
        "got inf",
    ),
    "a strength beyond all": (
        f"name: x\nfaults: [{{name: image_shift, value: 1{'0' * 400}}}]",
        "at most 1920",
    ),
    "not a number": ("name: x\nfaults: [{name: depth_degradation, value: .nan}]", "nan"),
    "twice": ("name: x\nfaults: [{name: gpu_failure}, {name: gpu_failure}]", "twice"),
    "a number for a name": ("name: 3\nfaults: []", "line 1: The name must be a text, got 3."),
    "a text for a time": (
        "name: x\nfaults:\n- {name: gpu_failure, at: 3, until: late, profile: step}",
        "mine.yaml, line 3: The end (until) of a fault [s] must be a number from 0 to 3600, got 'late'.",
    ),
    "a list for a name": ("name: x\nfaults: [{name: [1]}]", "expected for 'name'"),
    "exclusive": ("name: x\nfaults: [{name: image_degradation}, {name: unneeded_enhancement}]", "cures"),
}

MANAGERS: dict[str, tuple[str, str]] = {
    "no Python": ("def adapt(:", "line 1"),
    "raises on import": ("raise RuntimeError('no licence')", "no licence"),
    "no such class": ("x = 1", "Mine"),
    "no managing system": ("class Mine: pass", "subclass"),
    "no adapt": ("from sunset.managing import ManagingSystem\nclass Mine(ManagingSystem): pass", "adapt"),
    "repairs what was never there": (
        (
            "from sunset.managing import ManagingSystem\nclass Mine(ManagingSystem):\n"
            "    def on_start(self): self.create_timer(0.2, lambda: self.redeploy('camera'))\n"
            "    def adapt(self, symptoms): pass"
        ),
        "until the system is up, which adapt waits for",
    ),
    "no text": ("x = 1\0", "mine.py: this is not valid Python"),
    "exits on import": ("raise SystemExit('bye')", "bye"),
    "name of a node of the system": (
        (
            "from sunset.managing import ManagingSystem\nclass Mine(ManagingSystem):\n"
            "    node_name = 'launcher'\n    def adapt(self, symptoms): pass"
        ),
        "launcher",
    ),
}

FAILING: dict[str, tuple[str, str]] = {
    "raises at its start": (
        (
            "from sunset.managing import ManagingSystem\nclass Mine(ManagingSystem):\n"
            "    def on_start(self): raise ValueError('no plan')\n    def adapt(self, symptoms): pass"
        ),
        "no plan",
    ),
    "raises in adapt": (
        (
            "from sunset.managing import ManagingSystem\nclass Mine(ManagingSystem):\n"
            "    def adapt(self, symptoms): return symptoms['nothing like it']"
        ),
        "nothing like it",
    ),
    "does not make the node": (
        (
            "from sunset.managing import ManagingSystem\nclass Mine(ManagingSystem):\n"
            "    def __init__(self, **_): pass\n    def adapt(self, symptoms): pass"
        ),
        "could not be constructed: it raised AttributeError",
    ),
    "raises what is no exception": (
        (
            "from sunset.managing import ManagingSystem\nclass Mine(ManagingSystem):\n"
            "    def adapt(self, symptoms): raise BaseException('hm')"
        ),
        "it raised BaseException: hm (mine.py, line 3, in adapt)",
    ),
    "raises what has no text": (
        (
            "from sunset.managing import ManagingSystem\nclass Bad(Exception):\n    def __str__(self): return 1 / 0\n"
            "class Mine(ManagingSystem):\n    def adapt(self, symptoms): raise Bad"
        ),
        "it raised Bad (mine.py, line 5, in adapt)",
    ),
    "publishes what does not fit": (
        (
            "from sunset_ros.interfaces.std_msgs.msg import Int32\nfrom sunset.managing import ManagingSystem\n"
            "class Mine(ManagingSystem):\n"
            "    def on_start(self): self.out = self.create_publisher(Int32, 'number', 1)\n"
            "    def adapt(self, symptoms): self.out.publish(Int32(data='a'))"
        ),
        "The managing system mine.py:Mine failed",
    ),
    "asks what does not fit": (
        (
            "from sunset_ros.interfaces.std_srvs.srv import SetBool\nfrom sunset.managing import ManagingSystem\n"
            "class Mine(ManagingSystem):\n"
            "    def on_start(self): self.ask = self.create_client(SetBool, 'question')\n"
            "    def adapt(self, symptoms): self.ask.call_async(SetBool.Request(data='a'))"
        ),
        "mine.py, line 5, in adapt",
    ),
    "exits in adapt": (
        (
            "import sys\nfrom sunset.managing import ManagingSystem\nclass Mine(ManagingSystem):\n"
            "    def adapt(self, symptoms): sys.exit(0)"
        ),
        "mine.py, line 4, in adapt",
    ),
    "hangs at its start": (
        (
            "from sunset.managing import ManagingSystem\nclass Mine(ManagingSystem):\n"
            "    def on_start(self):\n        while True: pass\n    def adapt(self, symptoms): pass"
        ),
        " (mine.py, line 4, in on_start)",
    ),
    "hangs": (
        (
            "from sunset.managing import ManagingSystem\nclass Mine(ManagingSystem):\n"
            "    def adapt(self, symptoms):\n        while True: pass"
        ),
        "it did not return within 1",
    ),
}

ARGUMENTS: dict[str, tuple[Sequence[str], str]] = {
    "unknown scenario": (["run", "paper/everything"], "paper/everything"),
    "suite for a scenario": (["run", "paper"], "is a suite"),
    "missing file": (["run", "nowhere.yaml"], "There is no scenario file nowhere.yaml."),
    "folder for a scenario": (
        ["run", "my rain"],
        "a folder, and so a suite: name one of its files, or run all of its scenarios with 'sunset bench --suite ",
    ),
    "scenario file for a suite": (
        ["bench", "--suite", "my rain/wet.yaml", "--out", "o"],
        "is a file, and a suite is a folder of scenario files: name its folder, or run the scenario with ",
    ),
    "unknown suite": (["bench", "--suite", "rainy", "--out", "o"], "rainy"),
    "suite of an extension": (
        ["bench", "--suite", "dusk", "--out", "o"],
        "If an extension adds it, pass --extension.",
    ),
    "scenario of an extension": (["run", "dusk"], "If an extension adds it, pass --extension."),
    "unknown fault": (["faults", "show", "rotor_failure"], "rotor_failure"),
    "unknown manager": (["run", "--manager", "magic"], "magic"),
    "missing manager file": (["run", "--manager", "nowhere.py:Mine"], "nowhere.py"),
    "missing manager module": (["run", "--manager", "nowhere.at_all:Mine"], "nowhere"),
    "manager twice": (["bench", "--managers", "none,none", "--out", "o"], "once"),
    "label twice": (["bench", "--managers", "a=none,a=baseline", "--out", "o"], "once, got a, a"),
    "label of a shipped one": (["run", "--manager", "none=mine.py:Mine"], "comes with SUNSET"),
    "no label": (["run", "--manager", "my own=mine.py:Mine"], "got 'my own'"),
    "no duration": (["run", "--duration", "0"], "of 0.1 s, in which a frame comes, got 0 s"),
    "duration of half a frame": (["run", "--duration", "2.55"], "got 2.55 s"),
    "duration that is no number": (
        ["bench", "--duration", "nan", "--out", "o"],
        "from 1 to 3600 s and a multiple",
    ),
    "scenario of another suite": (["bench", "--scenarios", "rain", "--out", "o"], "no scenario 'rain'"),
    "scenario of the suite, misspelt": (
        ["bench", "--suite", "degraded", "--scenarios", "image_degradation+image_shft", "--out", "o"],
        "did you mean",
    ),
    "no scenario": (["bench", "--scenarios", ",", "--out", "o"], "leave them out for all"),
    "empty suite": (["bench", "--suite", "", "--out", "o"], "There is no suite ''"),
    "scenarios of an empty suite": (["scenarios", "list", "--suite", ""], "There is no suite ''"),
    "no manager": (["bench", "--managers", ",", "--out", "o"], "none at all"),
    "negative seed": (["run", "--seed", "-1"], "-1"),
    "seed too large": (["run", "--seed", "4294967296"], "4294967296"),
    "seed no number": (
        ["run", "--seed", "one"],
        "Argument --seed: expected a whole number, got 'one';",
    ),
    "duration with a unit": (
        ["run", "--duration", "20s"],
        "Argument --duration: expected a number, got '20s';",
    ),
    "a height that is no number": (
        ["data", "render", "--height", "low", "--out", "o"],
        "expected a number, got 'low'",
    ),
    "a number of runs that is none": (
        ["verify", "x.zip", "--run-again", "x"],
        "expected a whole number, got 'x'",
    ),
    "no repetition": (["bench", "--repetitions", "0", "--out", "o"], "0"),
    "no job": (["bench", "--jobs", "0", "--out", "o"], "0"),
    "no time": (["run", "--manager-limit", "0"], "0"),
    "a rate in the simulation": (["run", "--rate", "2"], "live runs"),
    "a viewer that is not a node": (
        ["run", "--middleware", "cyclonedds", "--viewer", "rviz"],
        "/rosbag2_recorder",
    ),
    "a file without a name": (["scenarios", "generate", "gpu_failure", "--out", ""], "exists"),
    "a file that is there": (
        ["scenarios", "generate", "gpu_failure", "--out", "/dev/null"],
        "/dev/null exists",
    ),
    "time without end": (
        ["run", "--manager-limit", "inf"],
        "must be a number above 0 and at most 1e+06, got inf",
    ),
    "a record nowhere": (["run", "nofault", "--out", "/"], "a folder of its own"),
    "a strength that is no YAML": (["scenarios", "show", "image_shift=!!int ''"], "image_shift"),
    "unknown model": (["run", "--model", "huge"], "huge"),
    "unknown device": (["run", "--device", "tpu"], "tpu"),
    "a GPU": (["run", "--device", "gpu"], "did you mean 'cuda', or choose one of cpu, cuda, auto"),
    "unknown middleware": (["run", "--middleware", "telepathy"], "telepathy"),
    "missing bag": (["run", "--bag", "nowhere.mcap"], "nowhere.mcap"),
    "unknown verb": (["fly"], "fly"),
    "unknown option": (["run", "--quickly"], "--quickly"),
    "a mistyped option": (
        ["run", "--manger", "none"],
        "sunset run: There is no argument '--manger' here: did you mean '--manager', or leave it out; 'sunset run ",
    ),
    "an option that is like none": (
        ["run", "--fault", "gpu_failure"],
        "There is no argument '--fault' here: leave it out;",
    ),
    "a second fault that is not joined": (
        ["run", "gpu_failure", "image_shift"],
        "There is no argument 'image_shift' here: join faults by +: gpu_failure+image_shift;",
    ),
    "faults with blanks between them": (
        ["scenarios", "show", "gpu_failure", "+", "image_shift=3", "+sync_issue"],
        "There is no argument '+' here: join faults by +: gpu_failure+image_shift=3+sync_issue;",
    ),
    "a second scenario": (
        ["run", "gpu_failure", "nofault"],
        "There is no argument 'nofault' here: leave it out;",
    ),
    "a word too many": (
        ["scenarios", "list", "paper"],
        "sunset scenarios list: There is no argument 'paper' here: leave it out;",
    ),
    "unknown format": (["report", ".", "--format", "clay"], "clay"),
    "list of runs as a table": (
        ["report", ".", "--runs", "--format", "table"],
        "must be csv or json, got 'table'",
    ),
    "report of nothing": (["report", "nowhere"], "nowhere"),
    "report of a file": (
        ["report", "my rain/wet.yaml"],
        "wet.yaml is a file, not a folder of runs: check a bundle with 'sunset verify', or unpack it and ",
    ),
    "report of an empty folder": (["report", "."], "no finished run"),
    "unknown town": (["data", "render", "--town", "99", "--out", "o"], "99"),
    "a frame without a figure": (["faults", "show", "gpu_failure", "--frame", "3"], "add --figure FILE"),
    "a flight without a figure": (["faults", "show", "gpu_failure", "--bag", "."], "add --figure FILE"),
    "a device without a figure": (["faults", "show", "gpu_failure", "--device", "auto"], "add --figure FILE"),
    "a task of no managing system": (
        ["faults", "figure", "--out", "figure.png", "--task", "diagnose"],
        "There is no argument '--task' here",
    ),
    "a seed of no choice": (["verify", "x.zip", "--run-again", "0", "--seed", "3"], "leave out --seed"),
    "figure of no known kind": (["faults", "figure", "--out", "figure.txt"], ".txt"),
}


@pytest.mark.parametrize("case", SCENARIOS)
def test_a_bad_scenario_file(case: str, tmp_path: Path, complaint: Callable[[Sequence[str]], str]) -> None:
    content, word = SCENARIOS[case]
    written(tmp_path / "mine.yaml", content)

    sentence = complaint(["run", "mine.yaml"])

    assert word in sentence
    assert sentence.count("mine.yaml") == 1


@pytest.mark.parametrize("case", MANAGERS)
def test_a_bad_managing_system(
    case: str, tmp_path: Path, flight: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    del flight
    source, word = MANAGERS[case]
    written(tmp_path / "mine.py", source)

    sentence = complaint(["run", "--manager", "mine.py:Mine", "--manager-limit", "1", "--out", "record"])

    assert word in sentence
    assert not (tmp_path / "record").exists()


@pytest.mark.parametrize("case", FAILING)
def test_a_managing_system_that_fails_leaves_the_run_without_one(
    case: str,
    tmp_path: Path,
    flight: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    del flight
    source, word = FAILING[case]
    written(tmp_path / "mine.py", source)
    monkeypatch.chdir(tmp_path)

    command = ["run", "nofault", "--duration", "1", "--json", "--manager-limit", "1"]
    assert main([*command, "--manager", "mine.py:Mine"]) == 0

    out, err = capfd.readouterr()
    run = json.loads(out)
    assert run["manager_failed"].startswith("The managing system mine.py:Mine ")
    assert word in run["manager_failed"]
    assert f"{run['manager_failed']} The run went on without it." in err.splitlines()
    assert run["valid"]
    assert run["metrics"]["iou_all"] > 0


@pytest.mark.parametrize("case", ARGUMENTS)
def test_a_bad_argument(
    case: str, flight: Path, tmp_path: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    del flight
    arguments, word = ARGUMENTS[case]
    written(tmp_path / "my rain/wet.yaml", "name: wet\nfaults: [gpu_failure]\n")

    assert word in complaint(arguments)


@pytest.mark.parametrize("verb", ["run", "up"])
def test_processes_that_cannot_find_each_other(
    verb: str, flight: Path, monkeypatch: pytest.MonkeyPatch, complaint: Callable[[Sequence[str]], str]
) -> None:
    del flight
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    live = ["run", "nofault", "--middleware", "cyclonedds"] if verb == "run" else ["up"]

    assert "no two processes find each other" in complaint(live)


def _missing(folder: Path, name: str) -> None:
    (folder / name).unlink()


def _truncated(folder: Path, name: str) -> None:
    content = (folder / name).read_bytes()
    (folder / name).write_bytes(content[: len(content) // 2])


@pytest.mark.parametrize("damage", [_missing, _truncated])
@pytest.mark.parametrize("name", ["card.json", "fusion.onnx"])
def test_damaged_weights(
    name: str,
    damage: Callable[[Path, str], None],
    tmp_path: Path,
    flight: Path,
    complaint: Callable[[Sequence[str]], str],
) -> None:
    del flight
    model = tmp_path / "model"
    shutil.copytree(load_model("lite").folder, model)
    damage(model, name)

    assert name in complaint(["run", "--model", "model"])


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # rosbags leaves the file open
def test_a_truncated_bag(tmp_path: Path, flight: Path, complaint: Callable[[Sequence[str]], str]) -> None:
    bag = tmp_path / "bag"
    shutil.copytree(flight, bag)
    (mcap,) = bag.glob("*.mcap")
    _truncated(bag, mcap.name)

    assert "bag" in complaint(["run", "--bag", "bag"])
    gc.collect()


def test_a_model_that_was_never_calibrated(
    tmp_path: Path, flight: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    del flight
    shipped = load_model("lite")
    shutil.copytree(shipped.folder, tmp_path / "raw")
    replace(shipped.card, entropy_threshold=1.0, sharpness_threshold=0.0).write(tmp_path / "raw")

    assert "'sunset models calibrate raw'" in complaint(["run", "--model", "raw"])


def test_a_bag_that_is_too_short(
    tmp_path: Path, flight: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    reader = read_bag(flight)
    write_bag(tmp_path / "bag", [reader.frame(index) for index in range(3)], list(reader.stamps_ns[:3]))

    sentence = complaint(["run", "--bag", "bag"])

    assert "3 frames" in sentence
    assert "260" in sentence


@pytest.mark.parametrize("where", ["/dev/null/record", "file/record"])
def test_a_folder_that_cannot_be_made(
    where: str, tmp_path: Path, flight: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    del flight
    written(tmp_path / "file", "")

    assert where in complaint(["run", "--out", where])


def test_a_folder_that_holds_something(
    tmp_path: Path, flight: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    del flight
    kept = written(tmp_path / "record" / "thesis.tex", "dear reader")

    assert "record" in complaint(["run", "--out", "record"])
    assert kept.read_text() == "dear reader"


SHORT_CAMPAIGN = [
    "bench",
    "--no-references",
    "--no-score",
    "--managers",
    "none",
    "--repetitions",
    "1",
    "--duration",
    "1",
    "--out",
    "results",
    "--suite",
]


@pytest.mark.thorough
def test_a_folder_of_another_campaign(
    tmp_path: Path,
    flight: Path,
    complaint: Callable[[Sequence[str]], str],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    del flight
    monkeypatch.chdir(tmp_path)
    assert main([*SHORT_CAMPAIGN, "nofault"]) == 0
    capfd.readouterr()

    sentence = complaint([*SHORT_CAMPAIGN, "degraded"])

    assert "holds another campaign: its suite is 'nofault', this one's is 'degraded'" in sentence


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"plan_version": 7}, "is of version 7, expected 1"),
        ({"seed": "1"}, "The seed in results/bench.json must be a whole number, got '1'"),
        ({"managers": "none"}, "The managers in results/bench.json must be a list, got 'none'"),
    ],
)
def test_a_plan_that_was_edited(
    tmp_path: Path,
    flight: Path,
    complaint: Callable[[Sequence[str]], str],
    change: dict[str, object],
    words: str,
) -> None:
    del flight
    plan: dict[str, object] = {
        "bag": None,
        "bag_checksum": "",
        "device": "cpu",
        "manager_checksums": {},
        "managers": ["none"],
        "model": "lite",
        "model_checksum": "",
        "plan_version": 1,
        "repetitions": 1,
        "runs": 1,
        "scenarios_checksum": "",
        "seed": 1,
        "suite": "nofault",
        "timing": {},
        "versions": {},
    }
    written(tmp_path / "results" / "bench.json", json.dumps(plan | change))

    assert words in complaint([*SHORT_CAMPAIGN, "nofault"])


def test_a_damaged_run(tmp_path: Path, complaint: Callable[[Sequence[str]], str]) -> None:
    written(tmp_path / "results" / "run.json", "{")

    assert "run.json" in complaint(["report", "results"])


def test_a_cache_folder_that_cannot_be_made(
    monkeypatch: pytest.MonkeyPatch, complaint: Callable[[Sequence[str]], str]
) -> None:
    monkeypatch.setenv("SUNSET_CACHE_DIR", "/dev/null/cache")

    assert "/dev/null/cache" in complaint(["run"])


@pytest.mark.thorough
def test_a_full_disk_costs_the_run_that_did_not_fit_and_no_other(tmp_path: Path, flight: Path) -> None:
    del flight
    command = ["run", "nofault", "--manager", "none", "--duration", "2"]
    assert main([*command, "--out", str(tmp_path / "finished")]) == 0
    finished = tmp_path / "finished" / "run.json"
    before = finished.read_bytes()

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    full = subprocess.run(
        [sys.executable, "-m", "sunset", *command, "--no-cache", "--out", str(tmp_path / "full")],
        preexec_fn=limit,
        capture_output=True,
        text=True,
        check=False,
    )

    assert full.returncode == 2
    assert "Traceback" not in full.stderr
    assert str(tmp_path / "full") in full.stderr
    assert not (tmp_path / "full").exists()
    assert finished.read_bytes() == before


LONG = "x" * 100_000


@pytest.mark.parametrize(
    "arguments",
    [
        [LONG],
        ["run", LONG],
        ["run", "--extension", LONG],
        ["run", "--manager", f"exec:{LONG}"],
        ["run", "--out", LONG],
        ["run", "--seed", LONG],
        ["run", f"--{LONG}"],
        ["bench", "--scenarios", LONG, "--out", "folder"],
        ["report", LONG],
    ],
    ids=lambda arguments: " ".join(arguments).partition(LONG)[0] or "a verb",
)
def test_no_argument_makes_a_complaint_long(
    arguments: Sequence[str], flight: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    del flight
    assert len(complaint(arguments)) < 2200


def test_a_scenario_of_too_many_faults_is_refused_at_once(
    tmp_path: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    written(tmp_path / "many.yaml", f"name: many\nfaults: [{'gpu_failure, ' * 5000}]")
    sentence = complaint(["run", "many.yaml"])
    assert "many.yaml, line 2: A scenario has at most 1000 faults, got 5000: leave some out." in sentence
