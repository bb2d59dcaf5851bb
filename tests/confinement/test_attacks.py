"""A confined process gets nothing of what it must not, where the same code gets it without walls."""

import json
import multiprocessing
import os
import secrets
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import pytest
from tests.confinement import attacks

import sunset.metrics  # of which it could know
from sunset.processes.confinement import walls
from sunset.processes.confinement.landlock import landlock_version
from sunset.processes.confinement.seccomp import can_filter_calls
from sunset.processes.confinement.walls import View, missing_walls
from sunset.processes.server import ForkServer
from sunset.system import unlisted

pytestmark = [
    pytest.mark.skipif(
        not landlock_version() or not can_filter_calls(), reason="this system has not all of the walls"
    ),
    pytest.mark.xdist_group("confinement"),
]

SECRET: Final = f"scenario-{secrets.token_hex(16)}"
_PATIENCE_S: Final = 60.0
PREPARE: Final = "sunset.processes.confinement.walls:prepare"


@pytest.fixture(scope="module")
def confinement() -> Iterator[ForkServer]:
    os.environ["SUNSET_SECRET"] = SECRET
    with ForkServer("attacks:attempt", PREPARE, folder=Path(__file__).parent) as server:
        yield server
    del os.environ["SUNSET_SECRET"]


@pytest.fixture
def bystander() -> Iterator[int]:
    """A process of the same user that has nothing to do with anything, in a group of its own."""
    with subprocess.Popen(
        [sys.executable, "-c", "input()"], stdin=subprocess.PIPE, start_new_session=True
    ) as process:
        yield process.pid
        process.kill()


def confined(
    confinement: ForkServer, name: str, view: View | None = None, **arguments: object
) -> dict[str, Any]:
    """Return the outcome of an attack by a confined process."""
    with confinement.start({"name": name, **arguments}, view or View()) as process:
        assert process.wait(_PATIENCE_S), process.death()
        told = process.socket.recv(1 << 16)
        assert told, process.death()
        outcome: dict[str, Any] = json.loads(told)
        return outcome


def unconfined(name: str, **arguments: object) -> object:
    """Return what the same attack gets in a fork of this process, as managing systems once were."""
    context = multiprocessing.get_context("fork")
    answers, answering = context.Pipe(duplex=False)

    def run(folder: str) -> None:
        os.chdir(folder)
        answering.send(attacks.outcome(name, **arguments)["got"])

    with TemporaryDirectory() as folder, answers:
        process = context.Process(target=run, args=(folder,))
        process.start()
        answering.close()  # so that the end of a process that does not answer is seen
        got: object = answers.recv()
        process.kill()  # it may have started threads that never end
        process.join()
    return got


@pytest.mark.parametrize(
    "name", ["objects", "frames", "memory", "environment", "arguments", "open_files", "modules"]
)
def test_it_holds_nothing_of_its_user(
    confinement: ForkServer, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setattr(sys, "argv", ["sunset", "run", SECRET])
    held = [f"{SECRET[:9]}{SECRET[9:]}" for _ in range(1000)]  # on the heap, many times
    assert unconfined(name), f"the attack does not work; {len(held)}"
    assert not confined(confinement, name)["got"]


def test_it_sees_no_process(confinement: ForkServer, bystander: int) -> None:
    for pid in ("self", str(bystander), str(os.getpid())):
        assert unconfined("proc", pid=pid)
        assert confined(confinement, "proc", pid=pid)["got"] == []
    assert unconfined("links", pid=bystander)
    for other in (bystander, os.getpid()):
        assert confined(confinement, "links", pid=other)["got"] == []
    assert all(unconfined("proc_parent"))  # type: ignore[arg-type]
    assert confined(confinement, "proc_parent")["got"] == [[], []]
    for folder in ("/proc", "/sys", "/dev", "/dev/shm", "/dev/fd", "/tmp", "/"):  # noqa: S108  looked at only
        assert unconfined("listing", folder=folder)
        assert confined(confinement, "listing", folder=folder)["got"] == []


@pytest.mark.parametrize("place", ["results", "cache", "beside"])
def test_it_reads_no_file_of_its_user(confinement: ForkServer, tmp_path: Path, place: str) -> None:
    folder = tmp_path / place
    folder.mkdir()
    (folder / "secret.py").write_text(f"x = '{SECRET}'", "utf-8")
    (folder / "mine.py").write_text("", "utf-8")
    view = View(search=(folder,), modules=(folder / "mine.py",))
    for name in ("listing", "noticing"):
        assert unconfined(name, folder=str(folder))
        assert confined(confinement, name, view, folder=str(folder))["got"] == []
    assert len(unconfined("reading", file=str(folder / "secret.py"))) > 5  # type: ignore[arg-type]
    assert confined(confinement, "reading", view, file=str(folder / "secret.py"))["got"] == []


def test_it_reads_of_no_fault_that_the_catalogue_leaves_out(confinement: ForkServer) -> None:
    package, words = Path(sunset.__file__).parent, [fault.name for fault in unlisted().faults]
    view = View(readable=(package.parent,))  # of a user whose data lie beside the package
    assert "causes.py" in unconfined("grepping", folder=str(package), words=words)  # type: ignore[operator]
    assert confined(confinement, "grepping", view, folder=str(package), words=words)["got"] == []
    assert confined(confinement, "grepping", view, folder=str(package), words=["gpu_failure"])["got"]
    assert unconfined("asking", words=words)
    assert confined(confinement, "asking", words=[*words, "gpu_failure"])["got"] == ["gpu_failure"]
    for module in ("sunset.wild.causes", "sunset.wild.nodes"):
        assert unconfined("importing", module=module, attribute="__doc__")
        assert not confined(confinement, "importing", module=module, attribute="__doc__")["got"]


@pytest.mark.skipif(not walls.enclosing(), reason="this system lets this user have no file system of its own")
def test_what_it_does_not_see_is_not_there(confinement: ForkServer, tmp_path: Path) -> None:
    for path in (tmp_path, Path(__file__)):
        assert len(unconfined("guessing", file=str(path))) > 3  # type: ignore[arg-type]
        assert confined(confinement, "guessing", file=str(path))["got"] == []
    for path in (Path("/proc/1/comm"), Path("/sys/kernel")):
        assert unconfined("guessing", file=str(path))
        assert confined(confinement, "guessing", file=str(path))["got"] in ([], None)
    assert 100 < confined(confinement, "many_files")["got"] < 300


@pytest.mark.thorough
def test_a_disk_without_walls_holds_more_files_than_it_may_make() -> None:
    assert unconfined("many_files") == 600


def test_it_writes_nothing_outside_of_its_folder(confinement: ForkServer, tmp_path: Path) -> None:
    mine, theirs = tmp_path / "mine", tmp_path / "theirs"
    for folder in (mine, theirs):
        folder.mkdir()
        (folder / "file").write_text("kept", "utf-8")
    before = (mine / "file").stat()
    view = View(readable=(mine / "file",))
    for file in (mine / "file", Path(sunset.__file__), Path(sys.executable), Path.home() / "x"):
        assert confined(confinement, "writing", view, file=str(file))["got"] == []
    assert (mine / "file").stat() == before
    assert [path.name for path in mine.iterdir()] == ["file"]
    assert (mine / "file").read_text("utf-8") == "kept"
    assert len(unconfined("writing", file=str(theirs / "file"))) > 8  # type: ignore[arg-type]


@pytest.mark.skipif(
    not walls.enclosing() and os.geteuid() != 0,
    reason="this user owns the files, and has no file system of its own",
)
def test_it_does_not_change_the_attributes_of_files(confinement: ForkServer, tmp_path: Path) -> None:
    (tmp_path / "mine").touch()
    (tmp_path / "theirs").touch()
    before = (tmp_path / "mine").stat()
    view = View(readable=(tmp_path / "mine",))
    assert confined(confinement, "marking", view, file=str(tmp_path / "mine"))["got"] == []
    assert (tmp_path / "mine").stat() == before
    assert len(unconfined("marking", file=str(tmp_path / "theirs"))) > 2  # type: ignore[arg-type]


def test_it_fills_neither_the_disk_with_one_file_nor_makes_devices(confinement: ForkServer) -> None:
    assert confined(confinement, "large_file", size=1 << 20)["got"] == (1 << 20) + 1
    assert unconfined("large_file", size=1 << 29) == (1 << 29) + 1
    assert not confined(confinement, "large_file", size=1 << 29)["got"]
    assert unconfined("making_devices")
    assert confined(confinement, "making_devices")["got"] == []


@pytest.mark.parametrize("name", ["tracing", "signalling"])
def test_it_does_nothing_to_other_processes(confinement: ForkServer, bystander: int, name: str) -> None:
    assert confined(confinement, name, pid=bystander)["got"] == []
    assert confined(confinement, name, pid=os.getpid())["got"] == []
    assert len(unconfined(name, pid=bystander)) > 3  # type: ignore[arg-type]


def test_it_gains_no_privileges(confinement: ForkServer) -> None:
    assert confined(confinement, "root")["got"] == []
    if len(unconfined("root")) <= 2:  # type: ignore[arg-type]
        pytest.skip("this user gains no privileges without walls either: needs root, or namespaces of users")


def test_it_leaves_nothing_for_later_processes(confinement: ForkServer) -> None:
    key = secrets.randbelow(1 << 30) + 1
    try:
        assert len(unconfined("shared_memory", key=key)) > 3  # type: ignore[arg-type]
    finally:
        attacks.remove_shared_memory(key)
    assert confined(confinement, "shared_memory", key=key)["got"] == []
    assert unconfined("patching_twice") == ["patched"]
    assert confined(confinement, "patching")["got"] == []
    assert confined(confinement, "patching")["got"] == []


def test_it_reaches_no_socket_but_those_of_the_internet(confinement: ForkServer, tmp_path: Path) -> None:
    path, abstract = str(tmp_path / "door"), secrets.token_hex(8)
    with (
        socket.socket(socket.AF_UNIX) as named,
        socket.socket(socket.AF_UNIX) as nameless,
        socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as datagrams,
        socket.create_server(("127.0.0.1", 0)) as internet,
    ):
        named.bind(path)
        nameless.bind(f"\0{abstract}")
        datagrams.bind(f"{path}.datagrams")
        named.listen()
        nameless.listen()
        assert len(unconfined("sockets", path=path, abstract=abstract)) > 2  # type: ignore[arg-type]
        assert confined(confinement, "sockets", path=path, abstract=abstract)["got"] == []
        port = internet.getsockname()[1]
        assert confined(confinement, "internet", port=port)["got"]


def test_what_it_starts_ends_with_it(confinement: ForkServer) -> None:
    assert unconfined("escaping")
    assert confined(confinement, "escaping")["got"] == []
    free = unconfined("daemon")
    assert isinstance(free, list)
    for pid in free[:-1]:  # the last one is the attack's own process
        os.kill(pid, signal.SIGKILL)  # it is still there
    left = confined(confinement, "daemon")["got"]
    assert len(left) == 4
    for pid in left:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, signal.SIGWINCH)


def test_it_starts_a_few_hundred_processes_at_most(confinement: ForkServer) -> None:
    if os.geteuid() == 0 and "namespaces" in missing_walls():
        pytest.skip("Linux counts root's processes in a namespace of users only, which this system refuses")
    assert 10 < confined(confinement, "bomb")["got"] < 1000
