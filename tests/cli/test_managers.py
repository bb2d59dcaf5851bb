"""`sunset managers check`, and what managing systems do to campaigns."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from sunset.cli import main
from sunset.processes.confinement.walls import confinement_report

pytestmark = pytest.mark.usefixtures("flight")

HEAD = "from sunset.managing import ManagingSystem\n\n\nclass Mine(ManagingSystem):\n    def adapt(self, symptoms):\n"
STEADY = HEAD + "        self.set_parameter('camera', 'perform_autofocus', True)\n"
UNORDERED = (
    HEAD
    + "        for node in {'depth', 'camera', 'sensor_fusion', 'segmentation'}:\n"
    + ("            self.activate(node)\n")
)
REFUSED = (
    HEAD
    + "        self.set_parameter('camera', 'autofocus', True)\n"
    + "        self.set_parameter('sensor_fusion', 'modality', 9)\n"
)
ENDING = "import os\n" + HEAD + "        os._exit(0)\n"


@pytest.fixture
def mine(tmp_path: Path) -> Callable[[str], str]:
    """Return a function that writes a managing system and returns how it is called."""

    def write(source: str) -> str:
        (tmp_path / "mine.py").write_text(source, encoding="latin-1")
        return f"{tmp_path / 'mine.py'}:Mine"

    return write


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("source", "code", "answer"),
    [
        (STEADY, 0, "yes"),
        (UNORDERED, 1, r"no: the same seed gave different records, first at -?\d+\.\d\d s on /\S+"),
    ],
)
def test_the_order_of_sets_must_not_matter(
    source: str, code: int, answer: str, mine: Callable[[str], str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["managers", "check", mine(source), "--scenario", "nofault", "--duration", "2"]) == code
    (line,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("deterministic")]
    assert re.fullmatch(f"deterministic +{answer}", line)


@pytest.mark.thorough
def test_refused_requests_are_counted_and_told_once(
    mine: Callable[[str], str], capfd: pytest.CaptureFixture[str]
) -> None:
    assert main(["managers", "check", mine(REFUSED), "--scenario", "nofault", "--duration", "2"]) == 0
    out, err = capfd.readouterr()  # the run has a process of its own
    lines = [" ".join(line.split()) for line in out.splitlines()]
    assert lines[1] == "runs yes: 0 adaptations in nofault"
    # twice every 0.2 s
    (number,) = re.findall(r"^refused (\d+) requests: ", lines[2])
    each = int(number) // 2
    assert each > 2 / 0.2
    assert "Parameter 'autofocus' of /managed_subsystem/camera is not declared: did you mean" in lines[2]
    assert lines[2].count(f" ({each} times)") == 2
    assert (
        err.count("camera refused autofocus = True") == err.count("sensor_fusion refused modality = 9") == 1
    )


@pytest.mark.thorough
def test_a_managing_system_that_ends_its_process_is_not_passed_over(
    mine: Callable[[str], str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    manager = mine(ENDING)
    reason = "it ended its process with exit code 0."

    assert main(["managers", "check", manager, "--scenario", "nofault"]) == 1
    out, _ = capsys.readouterr()
    runs = next(line for line in out.splitlines() if line.startswith("runs"))
    assert runs.startswith("runs             no: The managing system ")
    assert runs.endswith(f"mine.py:Mine failed in nofault, seed 1: {reason}")
    assert "deterministic    yes" in out
    assert f"walls            {confinement_report()}" in out

    bench = [
        "bench",
        "--suite",
        "nofault",
        "--no-references",
        "--no-score",
        "--repetitions",
        "1",
        "--managers",
        manager,
    ]
    assert main([*bench, "--out", str(tmp_path / "out")]) == 1
    out, _ = capsys.readouterr()
    told = " ".join(out.split())
    assert "1 of 1 run failed: The managing system" in told
    assert reason.rstrip(".") in told
    assert "Every run counts, also one that failed." in told


@pytest.mark.thorough
def test_a_source_in_another_encoding_is_run(mine: Callable[[str], str], tmp_path: Path) -> None:
    source = "# -*- coding: latin-1 -*-\n# für alle\n" + STEADY
    command = [
        "bench",
        "--suite",
        "nofault",
        "--no-references",
        "--no-score",
        "--repetitions",
        "1",
        "--duration",
        "4",
    ]
    assert main([*command, "--managers", mine(source), "--out", str(tmp_path / "out")]) == 0


@pytest.mark.thorough
def test_a_campaign_says_what_it_consists_of_and_a_report_that_it_is_not_finished(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sunset.cli.progress._QUICK_S", 0.0)
    out = tmp_path / "out"
    command = ["bench", "--suite", "nofault", "--managers", "none", "--repetitions", "1", "--duration", "1"]
    assert main([*command, "--out", str(out)]) == 0
    errors = capsys.readouterr().err
    assert (
        "Running the campaign with 1 run of oracle, for the score, and 9 runs of the paper's reference rows: 11 of 11"
        in errors
    )
    assert f"Next:\n  sunset report {out} --site site" in errors
    assert main(["report", str(out)]) == 0
    assert "is not finished" not in capsys.readouterr().out

    (next(out.glob("runs/nofault/none/*/seed-1")) / "run.json").unlink()

    assert main(["report", str(out)]) == 0
    planned = 2 + 9  # that of oracle, and both reference suites
    assert f"is not finished: {planned - 1} of {planned} runs are there." in capsys.readouterr().out

    (out / "bench.json").write_text("{")

    assert main(["report", str(out)]) == 0
    assert "may not be finished, since its plan cannot be read: " in capsys.readouterr().out
    assert main(["report", str(out), "--format", "json"]) == 0
    assert json.loads(capsys.readouterr().out)
