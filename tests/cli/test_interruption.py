"""What a command says, and leaves, when it is interrupted."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import NoReturn

import pytest

from sunset.cli import main


def interrupted(*_: object, **__: object) -> NoReturn:
    raise KeyboardInterrupt


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("arguments", "work", "said"),
    [
        (["run"], "sunset.cli.run.prepare_flight", "Interrupted.\n"),
        (
            ["bench", "--out", "results"],
            "sunset.cli.bench.plan",
            "Interrupted; the same command continues it.\n",
        ),
        (
            ["train", "--out", "model"],
            "sunset_lab.verbs.train.train_model",
            "Interrupted; the same command with --resume continues it.\n",
        ),
    ],
)
def test_it_says_how_to_go_on_where_something_is_kept(
    arguments: list[str],
    work: str,
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(work, interrupted)

    assert main(arguments) == 130

    assert capsys.readouterr().err.endswith(said)


@pytest.mark.thorough
@pytest.mark.usefixtures("flight")
def test_a_check_that_is_ended_leaves_no_folder(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sunset", "managers", "check", "baseline"]
    with subprocess.Popen(
        command, env={**os.environ, "TMPDIR": str(tmp_path)}, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        for line in process.stderr:
            if line.startswith("Running twice"):
                break
        process.send_signal(signal.SIGTERM)
        assert process.stderr.read().splitlines()[-1] == "Interrupted."
    assert process.returncode == 143
    assert list(tmp_path.glob("sunset-*")) == []
