"""Programs as managing systems: what they answer, and what is said of those that answer badly."""

import shlex
import sys
from pathlib import Path

import pytest

from sunset.errors import ManagerError
from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.recording import StoredRun
from sunset.scenarios import load_scenario

pytestmark = pytest.mark.usefixtures("flight")

ECHO = "import sys\nfor line in sys.stdin: pass\n"
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


def fly(folder: Path, source: str, scenario: str = "nofault", **settings: object) -> StoredRun:
    program = folder / "program.py"
    program.write_text(source, encoding="utf-8")
    given = {"timing": Timing(duration_s=2.0, warm_up_s=0.5)} | settings
    manager = f"exec:{shlex.join([sys.executable, '-S', str(program)])}"
    spec = RunSpec(
        scenario=load_scenario(scenario),
        manager=manager,
        settings=Settings(**given),  # type: ignore[arg-type]
    )
    return run(spec, folder / "run")


BAD = {
    "silence": (answering("pass"), "did not return within 0.6 s"),
    "death": ("import sys; sys.exit(3)", "line 1 of its output is missing: it ended with exit code 3"),
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


@pytest.mark.parametrize("name", BAD)
def test_a_bad_program_is_told_in_one_sentence(name: str, tmp_path: Path) -> None:
    source, expected = BAD[name]
    limit_s = 0.6 if name == "silence" else 30.0

    with pytest.raises(ManagerError, match=expected) as failure:
        fly(tmp_path, source, manager_limit_s=limit_s)

    text = str(failure.value)
    assert text.startswith("The managing system exec:")
    assert text.count(" failed in nofault, seed 1: it") == 1
    assert "\n" not in text
    assert len(text) < 1200
