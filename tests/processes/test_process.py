"""A confined process is one that its user can rely on: it can work, it ends, and it is told how."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from sunset.errors import SunsetError
from sunset.files.sources import modules_beside
from sunset.processes.confinement.walls import View
from sunset.processes.process import Process
from sunset.processes.server import ForkServer

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="only Linux has the walls"),
    pytest.mark.xdist_group("confinement"),
]

_PATIENCE_S = 60.0
PREPARE = "sunset.processes.confinement.walls:prepare"


@pytest.fixture(scope="module")
def confinement() -> Iterator[ForkServer]:
    with ForkServer("programs:run", PREPARE, folder=Path(__file__).parent) as server:
        yield server


def answer(process: Process) -> str:
    assert process.wait(_PATIENCE_S)
    return process.socket.recv(1 << 16).decode().rstrip()


@pytest.mark.parametrize(
    ("task", "reason"),
    [
        ({"name": "leave", "arguments": {"code": 3}}, "ended its process with exit code 3"),
        ({"name": "leave_in_order"}, "ended its process with exit code 4"),
        ({"name": "fail"}, "ended its process with exit code 1"),
        ({"name": "die", "arguments": {"number": 11}}, "ended its process by SIGSEGV"),
        ({"name": "fill_memory"}, "ran out of memory: it may take 4 GiB"),
    ],
)
def test_it_is_told_how_it_ended(confinement: ForkServer, task: dict[str, object], reason: str) -> None:
    said: list[str] = []
    with confinement.start(task, View(), on_text=said.append) as process:
        assert process.wait(_PATIENCE_S), "the end of the stream can be received"
        assert process.socket.recv(1) == b""
        assert process.death().reason == reason
    assert ("ValueError: a mistake" in "".join(said)) == (task["name"] == "fail")


@pytest.mark.parametrize("name", ["hang", "refuse", "chatter"])
def test_one_that_hangs_says_where_if_it_can(confinement: ForkServer, name: str) -> None:
    said: list[str] = []
    with confinement.start({"name": name}, View(), on_text=said.append) as process:
        limit_s = time.monotonic() + _PATIENCE_S
        while not said and time.monotonic() < limit_s:
            assert not process.wait(0.1)
        assert not process.wait(0.3)
        death = process.death("did not return within 0.3 s")
        assert death.reason == "did not return within 0.3 s"
        known = [(Path(file).name, function) for file, _, function in death.frames]
        assert (("programs.py", name) in known) == (name != "refuse")
        with pytest.raises(ProcessLookupError):
            os.kill(process.pid, 0)


def test_what_it_prints_is_shown_up_to_a_mebibyte(confinement: ForkServer) -> None:
    said: list[str] = []
    text = "0123456789ab\x1b]\n"
    task = {"name": "say", "arguments": {"text": text, "times": 200_000}}
    with confinement.start(task, View(), on_text=said.append) as process:
        assert answer(process) == "said"
    shown = "".join(said)
    assert len(shown) < (1 << 20) + 100
    assert shown.startswith(text)
    assert shown.endswith("(what it prints beyond 1 MiB is left out)\n")


def test_nothing_that_it_prints_commands_a_terminal(
    confinement: ForkServer, capsys: pytest.CaptureFixture[str]
) -> None:
    task = {"name": "say", "arguments": {"text": "a\x1b[2J\tb\r\x9bé\n", "times": 1}}
    with confinement.start(task, View()) as process:
        assert answer(process) == "said"
    assert capsys.readouterr().err == "a[2J\tbé\n"


def test_its_folder_is_its_own_and_gone_with_it(confinement: ForkServer) -> None:
    with confinement.start({"name": "use_folder"}, View()) as process:
        assert answer(process) == "te ['c', 'd'] True"
        folder = process.folder
        assert folder is not None
        assert folder.is_dir()
    assert not folder.exists()
    with confinement.start({"name": "dig"}, View()) as process:
        assert answer(process) == "deep"
        folder = process.folder
    assert folder is not None
    assert not folder.exists()


def test_it_finds_modules_in_folders_that_it_cannot_list(confinement: ForkServer, tmp_path: Path) -> None:
    texts = {
        "beside.py": 1,
        "package/__init__.py": 2,
        "package/inner.py": 3,
        "package/deep/__init__.py": 4,
        "colorsys.py": 5,
    }
    for name, value in texts.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f"VALUE = {value}", "utf-8")
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "plan.py").write_text("VALUE = 6", "utf-8")
    names = ["beside", "package", "package.inner", "package.deep", "colorsys"]
    files = modules_beside(tmp_path)
    assert [str(file.relative_to(tmp_path)) for file in files] == sorted(texts)
    view = View(search=(tmp_path,), modules=files)
    with confinement.start({"name": "use_modules", "arguments": {"names": names}}, view) as process:
        assert answer(process) == "['1', '2', '3', '4', '5']"
    with confinement.start(
        {"name": "use_modules", "arguments": {"names": ["results.plan"]}}, view
    ) as process:
        answer(process)
        assert process.death().reason == "ended its process with exit code 1"


def test_it_reads_the_data_that_it_is_given(confinement: ForkServer, tmp_path: Path) -> None:
    (tmp_path / "weights").write_text("heavy", "utf-8")
    task = {"name": "use_file", "arguments": {"path": str(tmp_path / "weights")}}
    with confinement.start(task, View(readable=(tmp_path / "weights",))) as process:
        assert answer(process) == "heavy"


def test_it_finds_what_it_is_given_by_links_and_detours(confinement: ForkServer, tmp_path: Path) -> None:
    (tmp_path / "real/inner").mkdir(parents=True)
    (tmp_path / "real/file").write_text("found", "utf-8")
    (tmp_path / "link").symlink_to("real")
    (tmp_path / "real/alias").symlink_to(tmp_path / "link/file")
    for way in ("link/file", "link/alias", "real/inner/../file", "link/inner/../../link/alias"):
        path = tmp_path / way
        with confinement.start(
            {"name": "use_file", "arguments": {"path": str(path)}}, View(readable=(path,))
        ) as process:
            assert answer(process) == "found"
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["link", "real"]


def test_it_is_small(confinement: ForkServer) -> None:
    with confinement.start({"name": "nothing"}, View()) as process:
        assert answer(process) == "ready"
        rollup = Path(f"/proc/{process.pid}/smaps_rollup").read_text("ascii")
    sizes = {line.split()[0]: int(line.split()[1]) for line in rollup.splitlines()[1:]}
    assert sizes["Pss:"] < 40_000


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_everything_ends_with_its_user(number: int) -> None:
    """Also if its server was stopped, for it hears of the end all the same."""
    attacks = str(Path(__file__).parents[1] / "confinement")
    script = f"""
import os, signal, sys
from pathlib import Path
from sunset.processes.confinement.walls import View
from sunset.processes.server import ForkServer
server = ForkServer("attacks:attempt", {PREPARE!r}, folder=Path({attacks!r}))
process = server.start({{"name": "daemon"}}, View())
process.wait()
print(server.pid, process.socket.recv(4096).decode(), process.folder, sep="|", flush=True)
if {number} == signal.SIGSTOP:
    os.kill(server.pid, signal.SIGSTOP)
os.kill(os.getpid(), signal.SIGKILL)
"""
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, check=False, text=True)
    server, outcome, folder = told.stdout.rstrip().split("|")
    pids = [int(server), *map(int, outcome.partition("[")[2].partition("]")[0].split(","))]
    assert len(pids) == 5, told
    limit = time.monotonic() + _PATIENCE_S
    while any(Path(f"/proc/{pid}").exists() for pid in pids) and time.monotonic() < limit:
        time.sleep(0.01)  # noqa: TID251  processes' ends are waited for
    assert [pid for pid in pids if Path(f"/proc/{pid}").exists()] == []
    while Path(folder).exists() and time.monotonic() < limit:
        time.sleep(0.01)  # noqa: TID251  and that of what is left
    assert not Path(folder).exists()


def test_a_server_that_is_gone_is_one_sentence() -> None:
    with ForkServer("programs:run", PREPARE, folder=Path(__file__).parent) as server:
        os.kill(server.pid, signal.SIGKILL)
        while server.is_running:
            time.sleep(0.01)  # noqa: TID251  its end is waited for
        # at once, or at the first use where another process was forked while the server was started
        with (
            pytest.raises(SunsetError, match=r"has ended: it was killed"),
            server.start({"name": "nothing"}, View()) as process,
        ):
            process.wait(_PATIENCE_S)


def test_a_process_that_cannot_be_confined_runs_nothing(confinement: ForkServer) -> None:
    with confinement.start({"name": "nothing"}, View(readable=(Path("/a\0b"),))) as process:
        assert process.wait(_PATIENCE_S)
        assert process.socket.recv(1) == b""
        with pytest.raises(SunsetError, match=r"could not be confined: ValueError: .*embedded null"):
            process.death()


def test_a_process_that_is_forked_can_use_it(confinement: ForkServer) -> None:
    with confinement.start({"name": "hang"}, View()) as process:
        assert not process.wait(0.01)
        assert not process.ended
        pid = os.fork()
        if pid == 0:
            os._exit(process.death("did not return").reason != "did not return")
        assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0
        limit_s = time.monotonic() + _PATIENCE_S
        while not process.ended and time.monotonic() < limit_s:
            time.sleep(0.01)  # noqa: TID251  another process is waited for
        assert process.ended
