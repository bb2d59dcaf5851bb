"""The walls hold on older kernels and other processors, as far as they reach there; what is missing is said."""

import multiprocessing
import os
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import mkdtemp

import pytest

from sunset.processes.confinement import landlock, walls
from sunset.processes.confinement.seccomp import can_filter_calls, filter_program
from sunset.processes.confinement.walls import View, confinement_report

pytestmark = [
    pytest.mark.skipif(not landlock.landlock_version(), reason="this system has no Landlock"),
    pytest.mark.xdist_group("confinement"),
]

_MACHINES = {"x86_64": (0xC000003E, 0), "aarch64": (0xC00000B7, 1)}
_ALLOWED, _DENIED, _UNKNOWN = 0x7FFF0000, 0x00050001, 0x00050026


def verdict(program: bytes, number: int, *arguments: int, architecture: int) -> int:
    """Return what a filter says of a call: an interpreter of the kernel's packet filter."""
    data = struct.pack("<iIQ6Q", number, architecture, 0, *arguments, *[0] * (6 - len(arguments)))
    code = list(struct.iter_unpack("=HBBI", program))
    value, at = 0, 0
    while True:
        kind, if_true, if_false, constant = code[at]
        at += 1
        if kind == 0x20:
            (value,) = struct.unpack_from("<I", data, constant)
        elif kind == 0x54:
            value &= constant
        elif kind == 0x06:
            return int(constant)
        else:
            tests = {0x15: value == constant, 0x35: value >= constant, 0x45: bool(value & constant)}
            at += if_true if tests[kind] else if_false


@pytest.fixture(params=_MACHINES)
def judge(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., int]]:
    """Gives what the filter of a machine says of a call, of which there are the numbers on both."""
    architecture, column = _MACHINES[request.param]
    monkeypatch.setattr("platform.machine", lambda: request.param)
    filter_program.cache_clear()

    def judged(numbers: tuple[int, int], *arguments: int, signals: bool = True) -> int:
        return verdict(
            filter_program(signals=signals), numbers[column], *arguments, architecture=architecture
        )

    yield judged
    filter_program.cache_clear()


def test_the_filter_refuses_what_it_should_on_both_machines(judge: Callable[..., int]) -> None:
    setsid, getpid, openat, clone, clone3 = (112, 157), (39, 172), (257, 56), (56, 220), (435, 435)
    assert judge(setsid) == _DENIED
    assert judge(getpid) == judge(openat) == _ALLOWED
    assert judge(clone, 0x11) == judge(clone, 0x3D0F00) == _ALLOWED, "a process, and a thread"
    for namespace in (0x20000, 0x2000000, 0x4000000, 0x8000000, 0x10000000, 0x20000000, 0x40000000):
        assert judge(clone, namespace | 0x11) == _DENIED
    assert judge(clone3) == _UNKNOWN
    to_socket, pair = (41, 198), (53, 199)
    for family in (socket.AF_INET, socket.AF_INET6, 16):
        assert judge(to_socket, family, 1) == _ALLOWED
    assert judge(to_socket, socket.AF_UNIX, 1) == judge(to_socket, 40, 1) == _DENIED
    assert judge(pair, 1, 1 | 0o2000000) == judge(pair, 1, 5) == _ALLOWED
    assert judge(pair, 1, 2 | 0o2000000) == _DENIED


def test_the_filter_guards_signals_where_landlock_does_not(judge: Callable[..., int]) -> None:
    kill, tgkill, tkill, own = (62, 129), (234, 131), (200, 130), os.getpid()
    assert judge(kill, 1, 9) == _ALLOWED
    for target in (0, own, -own & 0xFFFFFFFFFFFFFFFF):
        assert judge(kill, target, 9, signals=False) == _ALLOWED
    for target in (1, own + 1, -1 & 0xFFFFFFFFFFFFFFFF):
        assert judge(kill, target, 9, signals=False) == _DENIED
    assert judge(tgkill, own, own, 6, signals=False) == _ALLOWED
    assert judge(tgkill, 1, 1, 6, signals=False) == judge(tkill, own, 9, signals=False) == _DENIED


def test_no_other_architecture_gets_past_the_filter() -> None:
    program = filter_program(signals=True)
    assert verdict(program, 20, architecture=0x40000003) == _DENIED, "that of 32 bits"
    if os.uname().machine == "x86_64":
        assert verdict(program, 0x40000000 | 39, architecture=0xC000003E) == _DENIED, "x32"


@pytest.mark.skipif(not can_filter_calls(), reason="this system has no filter of system calls")
@pytest.mark.parametrize("version", [0, 1, 2, 3, 4, 5, 6, 7])
def test_older_versions_of_landlock_keep_what_they_can(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, version: int
) -> None:
    for module in (landlock, walls):
        monkeypatch.setattr(module, "landlock_version", lambda: version)
    monkeypatch.setattr(walls, "enclosing", lambda: False)
    (tmp_path / "file").write_text("text", "utf-8")
    folder = Path(mkdtemp(dir=tmp_path))
    answers = multiprocessing.get_context("fork").SimpleQueue()
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as bystander:

        def run() -> None:
            os.setsid()
            walls.put_up(View(), folder)
            answers.put([
                refused(lambda: (tmp_path / "file").read_text("utf-8")),
                refused(lambda: (tmp_path / "new").write_text("text", "utf-8")),
                refused(lambda: os.truncate(tmp_path / "file", 0)),
                refused(lambda: os.kill(bystander.pid, signal.SIGWINCH)),
                refused(lambda: os.kill(os.getpid(), signal.SIGWINCH)),
                refused(lambda: (folder / "mine").write_text("text", "utf-8")),
            ])  # fmt: skip

        process = multiprocessing.get_context("fork").Process(target=run)
        process.start()
        process.join()
        bystander.kill()
    reading, writing, cutting, signalling, itself, mine = answers.get()
    assert reading == (version > 0)
    assert (writing, cutting, signalling) == (version > 0 or os.geteuid() == 0, True, True)
    assert (itself, mine) == (False, False)


def refused(function: Callable[[], object]) -> bool:
    try:
        function()
    except PermissionError:
        return True
    return False


def test_the_report_says_what_is_open(monkeypatch: pytest.MonkeyPatch) -> None:
    assert confinement_report().startswith(
        f"Landlock {landlock.landlock_version()}, seccomp, limits of memory"
    )
    monkeypatch.setattr(walls, "landlock_version", lambda: 0)
    monkeypatch.setattr(walls, "can_filter_calls", lambda: False)
    monkeypatch.setattr(walls, "enclosing", lambda: False)
    assert confinement_report().startswith(
        "no Landlock: the user's files can be read and written, no seccomp: what it starts may outlive its run, limits "
        "of memory, files and processes, no namespaces: it may ask by stat"
    )


def test_all_that_is_beside_a_hidden_folder_stays_readable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (hidden := tmp_path / "lib" / "packages" / "sunset" / "wild").mkdir(parents=True)
    (module := hidden.parent / "names.py").touch()
    (other := tmp_path / "lib" / "packages" / "numpy").mkdir()
    (tmp_path / "lib64").symlink_to("lib")
    (tmp_path / "lib" / "up").symlink_to(tmp_path)
    monkeypatch.setattr(walls, "_HIDDEN", hidden)
    for place in (tmp_path / "lib", tmp_path / "lib64"):
        readable, listed = walls._without_hidden(place)
        assert set(readable) == {module, other}
        assert set(listed) == {tmp_path / "lib", tmp_path / "lib" / "packages", hidden.parent}
    assert walls._without_hidden(hidden / "causes.py") == ((), ())
    assert walls._without_hidden(other) == ((other,), ())
