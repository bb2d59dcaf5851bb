"""Programs as managing systems: what they answer, and what is said of those that answer badly."""

import contextlib
import json
import re
import shlex
import shutil
import socket
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.managing.answer import Answer
from sunset.perception import load_model
from sunset.recording import StoredRun, read_messages, read_run
from sunset.recording.reader import read_stored_run
from sunset.scenarios import load_scenario
from sunset.system import COMMANDS_TOPIC, current_system
from sunset.system_interfaces.msg import Diagnosis

pytestmark = pytest.mark.usefixtures("flight")

PROGRAMS = Path(__file__).parents[2] / "docs" / "programs"
TWINS = Path(__file__).with_name("twins.py")
SHORT = Timing(duration_s=2.0, warm_up_s=0.5)
ANSWERING = """
import json, sys
first = sys.stdin.readline()
for line in sys.stdin:
    {answer}
    sys.stdout.flush()
"""


def answering(answer: str) -> str:
    """Return a program that does this for every line that it gets but the first."""
    return ANSWERING.format(answer=answer)


def command(folder: Path, source: str) -> str:
    """Return how a program in Python is named that has this source."""
    (folder / "program.py").write_text(source, encoding="utf-8")
    return f"exec:{shlex.join(['python3', '-S', str(folder / 'program.py')])}"


def fly(folder: Path, manager: str, scenario: str = "nofault", **settings: object) -> StoredRun:
    given: dict[str, Any] = {"timing": SHORT} | settings
    spec = RunSpec(scenario=load_scenario(scenario), manager=manager, settings=Settings(**given))
    return run(spec, folder)


@pytest.mark.parametrize(
    ("program", "twin", "scenario"),
    [
        (f"exec:python3 {PROGRAMS}/baseline.py", "baseline", "gpu_failure+image_shift"),
        (f"exec:{PROGRAMS}/focus.sh", f"{TWINS}:Focus", "autofocus_needed"),
        pytest.param(
            "exec:{folder}/upstream", f"{TWINS}:Upstream", "gpu_failure", marks=pytest.mark.thorough
        ),
    ],
    ids=["Python", "sh", "C++"],
)
def test_a_program_flies_as_its_twin_does(program: str, twin: str, scenario: str, tmp_path: Path) -> None:
    if "upstream" in program:
        compiler = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
        if compiler is None:
            pytest.skip("there is no compiler for C++")
        source = [str(PROGRAMS / "upstream.cpp"), "-o", str(tmp_path / "upstream")]
        subprocess.run([compiler, "-std=c++17", *source], check=True)

    flown = fly(tmp_path / "program", program.format(folder=tmp_path), scenario)

    assert flown.metrics.adaptations
    assert flown.digest == fly(tmp_path / "twin", twin, scenario).digest


def test_a_program_flies_that_is_named_by_a_shim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shim = tmp_path / "shims" / "python3"
    shim.parent.mkdir()
    shim.write_text(f'#!/bin/sh\nexec {sys.executable} "$@"\n')
    shim.chmod(0o755)
    monkeypatch.setenv("PATH", f"{shim.parent}:/usr/bin:/bin")

    assert not fly(tmp_path / "run", f"exec:python3 {PROGRAMS}/baseline.py").record.manager_failed


BAD = {
    "silence": (
        answering("pass"),
        "did not return within 3 s; its program must answer each line, and flush its output",
    ),
    "death": ("import sys; sys.exit(3)", "line 1 of its output is missing: it ended with exit code 3"),
    "death while a child of it goes on": (
        "import os, sys, time\nif not os.fork():\n    time.sleep(60)\nsys.exit(3)",
        "line 1 of its output is missing: it ended with exit code 3",
    ),
    "death by a signal": (
        answering("import os; os.kill(os.getpid(), 9)"),
        "line 1 of its output is missing: it was ended by signal 9",
    ),
    "closed output": (
        "import os, time; os.close(1); time.sleep(60)",
        "line 1 of its output is missing: it closed its output",
    ),
    "partial line": (
        answering("sys.stdout.write('{\"adapt'); sys.stdout.flush(); sys.exit()"),
        "line 1 of its output is missing: it ended with exit code 0 in the middle of '{\"adapt'",
    ),
    "a flood": (
        "import sys\nwhile True: sys.stdout.write('a' * 10**6)",
        r"line 1 of its output (is longer than 1048576 bytes: 'aaaa|came before it was asked for, 'aaaa)",
    ),
    "noise": (
        answering(r"sys.stdout.buffer.write(bytes(range(128, 256)) + b'\n')"),
        r"line 1 of its output is '\\\\x80.*, which is not an answer \(.*\): expected one JSON object such as ",
    ),
    "no JSON": (
        answering("print('camera: redeploy')"),
        r"line 1 of its output is 'camera: redeploy', which is not an answer \(JSON is malformed",
    ),
    "another type": (
        answering("print('[1]')"),
        r"is not an answer \(Expected `object`, got `array`\)",
    ),
    "an adaptation of another type": (
        answering("""print('{"adaptations": ["redeploy"]}')"""),
        r"\(Expected `object`, got `str` - at `\$.adaptations\[0\]`\)",
    ),
    "an unknown key": (
        answering("""print('{"adaptation": []}')"""),
        "Object contains unknown field `adaptation`",
    ),
    "an unknown kind": (
        answering("""print('{"adaptations": [{"kind": "reboot", "node": "camera"}]}')"""),
        r"Invalid value 'reboot' - at `\$.adaptations\[0\].kind`.*; a kind is one of restart, redeploy, set_parameter",
    ),
    "an unknown node": (
        answering("""print('{"adaptations": [{"kind": "redeploy", "node": "camra"}]}')"""),
        "line 1 of its output names the node 'camra': did you mean 'camera', or name one of camera, depth, ",
    ),
    "a value that is missing": (
        answering("""print('{"adaptations": [{"kind": "set_parameter", "node": "camera", "name": "x"}]}')"""),
        "Object missing required field `value`",
    ),
    "no probability": (answering("""print('{"diagnosis": {"gpu_failure": 1.5}}')"""), "<= 1.0"),
    "a negative time": (answering("""print('{"think_s": -1}')"""), ">= 0.0 - at"),
    "NaN": (answering("""print('{"think_s": NaN}')"""), "malformed"),
    "a number without bounds": (answering("""print('{"think_s": 1e999}')"""), "out of range"),
    "a number that no parameter holds": (
        answering(
            """print(json.dumps({"adaptations": [
        {"kind": "set_parameter", "node": "camera", "name": "x", "value": 2**70}]}))"""
        ),
        "which is not an answer .Expected `int` <= 9223372036854775807",
    ),
    "101 adaptations": (
        answering("""print(json.dumps({"adaptations": [{"kind": "redeploy", "node": "camera"}] * 101}))"""),
        "which is not an answer .Expected `array` of length <= 100",
    ),
    "deep nesting": (answering("""print('{"adaptations": ' + '[' * 100000)"""), "is not an answer"),
    "two answers": (
        answering("""print('{}\\n{}')"""),
        r"line 1 of its output is followed by more, '\{\}\\n', before that was asked for",
    ),
    "no questions": (
        "import time\nwhile True: print('{}', flush=True); time.sleep(0.02)",
        r"line \d+ of its output came before it (had read the line|was asked for)",
    ),
}


FIRST = {"silence", "death", "a flood", "noise", "no JSON", "an unknown node", "two answers"}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in FIRST else pytest.mark.thorough) for name in BAD]
)
def test_a_bad_program_is_told_in_one_sentence(name: str, tmp_path: Path) -> None:
    source, expected = BAD[name]
    limit_s = 0.3 if name == "silence" else 30.0

    timing = Timing(duration_s=1.0, warm_up_s=0.3)
    flown = fly(tmp_path / "run", command(tmp_path, source), manager_limit_s=limit_s, timing=timing)

    text = flown.record.manager_failed or ""
    assert re.search(expected, text)
    assert text.startswith("The managing system exec:python3 ")
    assert text.count(" failed in nofault, seed 1: it ") == 1
    assert (flown.valid, flown.metrics.t_down_s) == (True, 0.0)  # the run goes on without it
    assert "\n" not in text
    assert len(text) < 1200


LATE = """
import json, sys
first = json.loads(sys.stdin.readline())
(redeploy,) = [one for one in first["system"]["adaptations"] if one["id"] == "redeploy segmentation"]
done = False
for line in sys.stdin:
    if json.loads(line)["symptoms"].get("managed_subsystem_segmentation_freq") == 0 and not done:
        done = True
        print(json.dumps({"think_s": 0.25, "diagnosis": {"gpu_failure": 0.75}, "adaptations": [redeploy]}))
    else:
        print("{}")
    sys.stdout.flush()
"""


def test_a_program_thinks_and_says_what_is_wrong_as_its_twin_does(tmp_path: Path) -> None:
    flown = fly(tmp_path / "program", command(tmp_path, LATE), "gpu_failure")

    (diagnosis,) = read_messages(tmp_path / "program", ["/managing_system/diagnosis"])
    (redeploy,) = read_messages(tmp_path / "program", [COMMANDS_TOPIC])
    assert isinstance(diagnosis.message, Diagnosis)
    assert diagnosis.message.faults == ["gpu_failure"]
    assert 0.25 < (redeploy.time_ns - diagnosis.time_ns) / 1e9 < 0.26
    assert flown.digest == fly(tmp_path / "twin", f"{TWINS}:Late", "gpu_failure").digest


def test_a_diagnosis_in_a_curing_answer_counts(tmp_path: Path) -> None:
    flown = fly(tmp_path / "run", command(tmp_path, LATE.replace("0.25", "0")), "gpu_failure")
    figures = read_stored_run(tmp_path / "run").metrics
    assert flown.record.valid
    assert (figures.faults_cured, figures.faults_identified, figures.faults_top1) == (1, 1, 1)


def test_a_program_that_is_to_diagnose_cannot_adapt(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    told = LATE.replace("done = False\n", "done = False\nprint(first['task'], file=sys.stderr)\n", 1)
    fly(tmp_path / "run", command(tmp_path, told), "gpu_failure", task="diagnose")
    assert "diagnose" in capfd.readouterr().err
    run = read_stored_run(tmp_path / "run")
    assert (run.record.task, run.record.valid, run.adaptations) == ("diagnose", True, ())
    assert (run.metrics.faults_identified, run.metrics.faults_cured) == (1, 0)


def test_every_decision_can_be_charged(tmp_path: Path) -> None:
    def decided(folder: str, **settings: object) -> int:
        fly(tmp_path / folder, "baseline", "gpu_failure", **settings)
        (redeploy,) = read_messages(tmp_path / folder, [COMMANDS_TOPIC])
        return redeploy.time_ns

    at_once, later = decided("at_once"), decided("later", thinking_s=0.3)

    assert (later - at_once) / 1e9 == pytest.approx(0.3, abs=0.001)
    assert "thinking_s" not in json.loads((tmp_path / "at_once" / "run.json").read_text())
    assert read_run(tmp_path / "later").thinking_s == 0.3


GREETED = """
import json
from sunset.managing import ManagingSystem

class Greeted(ManagingSystem):
    def on_start(self):
        self.declare_parameter("manager_seed", 0)
        print(json.dumps(self.greeting))

    def adapt(self, symptoms):
        pass
"""


def test_a_class_has_the_greeting_of_a_program(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "greeted.py").write_text(GREETED, encoding="utf-8")
    fly(tmp_path / "class", f"{tmp_path / 'greeted.py'}:Greeted")
    of_class = json.loads(capfd.readouterr().err)
    fly(tmp_path / "program", command(tmp_path, TELLING))

    assert of_class == json.loads(capfd.readouterr().err.splitlines()[0])


TELLING = """
import sys
for number, line in enumerate(sys.stdin):
    print(line, end="", file=sys.stderr, flush=True)
    if number == 1:
        print('{"adaptations": [{"kind": "activate", "node": "image_enhancement"}, '
              '{"id": "mine", "kind": "set_parameter", "node": "sensor_fusion", "name": "modality", "value": 9}]}')
    elif number:
        print("{}")
    sys.stdout.flush()
"""


def shape(value: object) -> object:
    """Return the keys of a JSON value, those of a list's first item for all."""
    if isinstance(value, dict):
        return {key: shape(item) for key, item in value.items()}
    return [shape(item) for item in value[:1]] if isinstance(value, list) else None


def test_a_program_is_told_what_it_can_do_and_what_came_of_it(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    fly(tmp_path / "run", command(tmp_path, TELLING))

    first, *lines = [json.loads(line) for line in capfd.readouterr().err.splitlines()]
    assert (first["protocol"], first["period"], type(first["seed"])) == (1, 0.2, int)
    system = first["system"]
    assert [node["name"] for node in system["nodes"]] == [*current_system().nodes]
    signals = {signal["name"]: signal for signal in system["signals"]}
    card = load_model("lite").card
    assert signals["segmentation_entropy"]["threshold"] == card.entropy_threshold
    assert signals["camera_sharpness"]["threshold"] == card.sharpness_threshold
    assert {"id": "restart camera", "kind": "restart", "node": "camera"} in system["adaptations"]
    names = [one["id"] for one in system["adaptations"]]
    assert names == sorted(names)
    assert not any(fault in json.dumps(first) for fault in current_system().faults)
    assert lines[0]["symptoms"]["managed_subsystem_segmentation_freq"] > 0
    assert [result for line in lines for result in line["results"]] == [
        {"id": 1, "accepted": True},
        {"id": "mine", "accepted": False},
    ]
    page = (PROGRAMS.parent / "programs.md").read_text(encoding="utf-8")
    shown_first, shown_line, shown_answer = map(
        json.loads, re.findall(r"^```json\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    )
    assert shape(shown_first) == shape(first)
    assert shown_line.keys() == lines[0].keys()
    assert len(msgspec.convert(shown_answer, Answer).adaptations) == 2
    times = [line["time"] for line in lines]
    assert times == pytest.approx([times[0] + 0.2 * number for number in range(len(lines))], abs=0.001)


FAKE_MODEL = """
import sys
prompt = sys.stdin.read()
silent = '"managed_subsystem_segmentation_freq": 0.0' in prompt
print("redeploy camera" if silent else "nothing")
"""


@pytest.mark.thorough
def test_recorded_answers_take_the_place_of_a_language_model(tmp_path: Path) -> None:
    answers, program = tmp_path / "answers.jsonl", f"exec:python3 {PROGRAMS}/language_model.py"
    with socket.create_server(("localhost", 0)) as free:
        port = free.getsockname()[1]
    recording = [
        str(PROGRAMS / "recorder.py"),
        str(answers),
        str(port),
        sys.executable,
        "-S",
        "-c",
        FAKE_MODEL,
    ]
    recorder = subprocess.Popen([sys.executable, *recording], stderr=subprocess.DEVNULL)
    long = Timing(duration_s=10.0, warm_up_s=0.5)
    try:
        _await_door(port)
        asked = fly(tmp_path / "asked", f"{program} http://localhost:{port}", "gpu_failure", timing=long)
    finally:
        recorder.kill()
        recorder.wait()

    # a model that is wrong each time is not asked again before the camera has booted and would be seen
    times = [adaptation.time for adaptation in asked.metrics.executed]
    assert {str(one) for one in asked.metrics.executed} == {"redeploy camera"}
    assert len(times) == 2
    assert times[1] - times[0] >= 5.0
    recorded = [json.loads(line) for line in answers.read_text().splitlines()]
    assert all(answer["seconds"] > 0 for answer in recorded)
    first, *_, last = [answer["prompt"] for answer in recorded]
    assert "- camera: /rgb_raw -> rgb_camera; 4 s after a redeploy" in first
    assert f"- segmentation_entropy: above {load_model('lite').card.entropy_threshold:g}" in first
    assert " Done: nothing. " in first
    assert re.search(r"Time: [0-9.]+ s. Done: [0-9.]+ s redeploy camera, accepted. ", last)
    replayed = fly(tmp_path / "replayed", f"{program} {answers}", "gpu_failure", timing=long)
    assert replayed.digest == asked.digest
    assert replayed.record.manager_checksum != asked.record.manager_checksum


def _await_door(port: int) -> None:
    for _ in range(1000):
        with contextlib.suppress(OSError), socket.create_connection(("localhost", port)):
            return
        threading.Event().wait(0.05)
    raise AssertionError("nobody listens")
