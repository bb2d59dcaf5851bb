"""Files of a stranger that name code: nothing of it runs until it is trusted."""

import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

import sunset
from sunset.cli import main
from sunset.errors import RecordError
from sunset.experiments import run_again

EVIL = """\
import socket

socket.create_connection(("127.0.0.1", {port}), 5).close()

from sunset.managing import ManagingSystem


class Evil(ManagingSystem):
    def adapt(self, symptoms):
        self.set_parameter("camera", "perform_autofocus", True)
"""


class Stranger(NamedTuple):
    """A campaign and its bundle, and what their code connects to."""

    listener: socket.socket
    campaign: Path
    packed: Path

    @property
    def record(self) -> Path:
        return next(self.campaign.glob("runs/*/evil/*/seed-1"))

    def connections(self) -> int:
        """Return how many connections were made since the last call."""
        count = 0
        while True:
            try:
                self.listener.accept()[0].close()
            except BlockingIOError:
                return count
            count += 1


@pytest.fixture(scope="module")
def stranger(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stranger]:
    assert flight.exists()
    folder = tmp_path_factory.mktemp("stranger")
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.setblocking(False)
        text = EVIL.format(port=listener.getsockname()[1])
        (folder / "evil.py").write_text(text)
        (folder / "program.py").write_text(
            text.partition("from")[0] + "import sys\ninput()\nfor _ in sys.stdin: print({}, flush=True)\n"
        )
        managers = f"none,evil={folder}/evil.py:Evil,program=exec:python3 {folder}/program.py"
        made = Stranger(listener, folder / "campaign", folder / "campaign.zip")
        command = (
            "bench --suite single --scenarios autofocus_needed --repetitions 1 --no-references --no-score"
        )
        assert (
            main(
                [
                    *command.split(),
                    "--jobs",
                    "1",
                    "--duration",
                    "1",
                    "--managers",
                    managers,
                    "--out",
                    str(made.campaign),
                ]
            )
            == 0
        )
        assert made.connections() >= 2
        assert main(["bundle", str(made.campaign), "--out", str(made.packed)]) == 0
        assert made.connections() == 0
        yield made


def refused_again(stranger: Stranger, out: Path) -> None:
    with pytest.raises(RecordError, match="which is code that the record names"):
        run_again(stranger.record, out)


USES: dict[str, Callable[[Stranger, Path], object]] = {
    "view": lambda one, out: main(["view", str(one.record), "--no-open", "--out", str(out)]),
    "view of a program": lambda one, out: main(
        ["view", str(next(one.campaign.glob("runs/*/program/*/seed-1"))), "--no-open", "--out", str(out)]
    ),
    "report": lambda one, _: main(["report", str(one.campaign), "--recompute"]),
    "report of a run": lambda one, _: main(["report", str(one.record)]),
    "site": lambda one, out: main(["report", str(one.campaign), "--site", str(out)]),
    "page": lambda one, _: main(["report", str(one.campaign), "--format", "html"]),
    "verify": lambda one, _: main(["verify", str(one.packed), "--run-again", "99"]),
    "leaderboard": lambda one, out: main(
        ["leaderboard", str(one.packed), "--out", str(out), "--run-again", "99"]
    ),
    "load from Python": lambda one, _: [repr(sunset.load(path)) for path in (one.campaign, one.record)],
    "view from Python": lambda one, out: sunset.view(one.record, out=out, show=False),
    "run again": refused_again,
    "verify from Python": lambda one, _: sunset.verify(one.packed, run_again=99),
}


@pytest.mark.parametrize("use", USES)
def test_what_only_reads_runs_no_code_that_a_file_names(use: str, stranger: Stranger, tmp_path: Path) -> None:
    assert not USES[use](stranger, tmp_path / "out.html") or use.endswith("Python")

    assert stranger.connections() == 0


def test_what_is_trusted_runs(stranger: Stranger, tmp_path: Path) -> None:
    run_again(stranger.record, tmp_path / "again", trust=True)

    assert stranger.connections() > 0
