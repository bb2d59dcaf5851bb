import ctypes
import os
import re
import signal
import stat
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from sunset.errors import ModelError
from sunset.processes import forking
from sunset.processes.calls import UnexpectedError, Watch, call_isolated
from sunset.processes.process import ProcessDeath


class _UnknownError(ModelError):
    """An error that only the process knows."""


def _raise(error: BaseException) -> None:
    raise error


def _hang(_: Watch) -> None:
    while True:
        with suppress(BaseException):
            while True:
                pass


def _refuse_to_end(watch: Watch) -> None:
    for number in (signal.SIGABRT, signal.SIGTERM, signal.SIGALRM):
        signal.signal(number, signal.SIG_IGN)
    _hang(watch)


def _hold_the_interpreter(_: Watch) -> None:
    re.match(r"(a+)+$", "a" * 64 + "b")


def _die_of_its_own_timer(_: Watch) -> None:
    signal.setitimer(signal.ITIMER_REAL, 0.01)
    signal.pause()


def _start_a_thread(_: Watch) -> str:
    threading.Thread(target=threading.Event().wait, daemon=False).start()
    return "left a thread"


def test_what_a_call_returns_comes_back() -> None:
    here = os.getpid()

    assert call_isolated(lambda _: {"other": os.getpid() != here}, limit_s=30) == {"other": True}


def test_nothing_that_a_call_does_to_the_interpreter_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    call_isolated(lambda _: monkeypatch.setattr(os, "sep", "broken"), limit_s=30)

    assert os.sep == "/"


def test_an_error_of_ours_comes_back_as_the_class_that_both_sides_know() -> None:
    with pytest.raises(ModelError, match=r"^No network\.$") as caught:
        call_isolated(lambda _: _raise(_UnknownError("No network.")), limit_s=30)

    assert type(caught.value) is ModelError


def test_any_other_exception_comes_back_with_its_traceback() -> None:
    with pytest.raises(UnexpectedError, match=r"in _raise\n(.*\n)*KeyError: 'what'"):
        call_isolated(lambda _: _raise(KeyError("what")), limit_s=30)


def test_a_long_error_comes_back_shortened() -> None:
    with pytest.raises(ModelError, match=r"^😀{1333}…😀{666}$"):
        call_isolated(lambda _: _raise(ModelError("😀" * 100_000)), limit_s=30)


@pytest.mark.parametrize(
    ("function", "reason"),
    [
        (lambda _: os._exit(0), "ended its process with exit code 0"),
        (lambda _: os._exit(3), "ended its process with exit code 3"),
        (lambda _: os.closerange(3, 1000), "ended its process with exit code 1"),
        (lambda _: object(), "ended its process with exit code 1"),
        (lambda _: os.kill(os.getpid(), 40), "ended its process by signal 40"),
        (lambda _: ctypes.string_at(0), "ended its process by SIGSEGV"),
        (_die_of_its_own_timer, "ended its process by SIGALRM"),
    ],
)
def test_a_process_that_dies_is_told_of(function: Callable[[Watch], object], reason: str) -> None:
    with pytest.raises(ProcessDeath, match=f"^{reason}$"):
        call_isolated(function, limit_s=30)


@pytest.mark.parametrize("function", [_hang, _hold_the_interpreter])
def test_a_call_that_hangs_is_ended_and_says_where(function: Callable[[Watch], object]) -> None:
    with pytest.raises(ProcessDeath, match=r"^did not return within (1 s of processor time|10 s)$") as caught:
        call_isolated(function, limit_s=1)  # by then it runs, however busy the computer is

    assert function.__name__ in [name for file, _, name in caught.value.frames if file == __file__]


@pytest.mark.thorough
def test_a_call_that_refuses_every_signal_is_ended_too() -> None:
    with pytest.raises(ProcessDeath, match=r"^did not return within (0.5 s of processor time|5 s)$"):
        call_isolated(_refuse_to_end, limit_s=0.5)


def test_the_limit_is_one_of_the_time_without_a_sign_of_life() -> None:
    def sleep_thrice(watch: Watch) -> str:
        for _ in range(3):
            time.sleep(0.7)  # noqa: TID251
            watch.tick()
        return "done"

    assert call_isolated(sleep_thrice, limit_s=0.2) == "done"


def test_a_call_that_returns_while_it_is_ended_has_passed_its_limit() -> None:
    def be_late(_: Watch) -> str:
        signal.signal(signal.SIGABRT, signal.SIG_IGN)
        time.sleep(0.3)  # noqa: TID251
        return "done"

    with pytest.raises(ProcessDeath, match=r"^did not return within 0.1 s$"):
        call_isolated(be_late, limit_s=0.01)


def test_a_call_that_waits_takes_no_processor_time() -> None:
    def wait(_: Watch) -> str:
        time.sleep(2)  # noqa: TID251
        return "done"

    assert call_isolated(wait, limit_s=0.5) == "done"


def test_an_answer_may_be_long() -> None:
    assert call_isolated(lambda _: "a" * 10**6, limit_s=30) == "a" * 10**6


def _reap_all(*_: object) -> None:
    with suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


@pytest.mark.parametrize("handler", [signal.SIG_IGN, _reap_all])
def test_a_caller_that_loses_the_ends_of_its_processes_gets_what_they_return(
    handler: signal.Handlers | Callable[..., None],
) -> None:
    before = signal.signal(signal.SIGCHLD, handler)
    try:
        assert call_isolated(lambda _: "done", limit_s=30) == "done"
        with pytest.raises(ProcessDeath, match=r"^ended its process with exit code 3$"):
            call_isolated(lambda _: os._exit(3), limit_s=30)
    finally:
        signal.signal(signal.SIGCHLD, before)


@pytest.mark.parametrize("stream", [None, object()])
def test_a_caller_without_streams_gets_what_a_call_returns(
    stream: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdout", stream)
    monkeypatch.setattr(sys, "stderr", stream)

    assert call_isolated(lambda _: "done", limit_s=30) == "done"


def test_it_is_told_whose_code_ended_the_process() -> None:
    def end(watch: Watch) -> None:
        watch.running = "a node"
        os._exit(3)

    with pytest.raises(ProcessDeath) as caught:
        call_isolated(end, limit_s=30)

    assert caught.value.running == "a node"


def test_closed_streams_are_no_failure() -> None:
    assert call_isolated(lambda _: [sys.stdout.close(), sys.stderr.close()], limit_s=30) == [None, None]


def test_what_is_written_to_stdout_goes_to_stderr(capfd: pytest.CaptureFixture[str]) -> None:
    call_isolated(lambda _: os.system("echo said"), limit_s=30)  # noqa: S605, S607

    assert capfd.readouterr() == ("", "said\n")


def test_pipes_of_the_caller_are_closed() -> None:
    ours, theirs = os.pipe()

    def write(_: Watch) -> str:
        try:
            os.write(theirs, b"x")
        except OSError as error:
            return str(error.strerror)
        return "written"

    assert call_isolated(write, limit_s=30) == "Bad file descriptor"
    os.close(ours)
    os.close(theirs)


def test_what_a_call_has_started_ends_with_it() -> None:
    pid = call_isolated(lambda _: subprocess.Popen(["/bin/sleep", "60"]).pid, limit_s=30)

    deadline = time.monotonic() + 30
    while _is_running(pid) and time.monotonic() < deadline:
        time.sleep(0.01)  # noqa: TID251  another process's end is waited for
    assert not _is_running(pid)


def test_an_answer_that_cannot_be_read_is_told_of() -> None:
    def tamper(_: Watch) -> None:
        for number in range(3, 1000):
            with suppress(OSError):
                if stat.S_ISSOCK(os.fstat(number).st_mode):
                    os.write(number, b"x")

    with pytest.raises(ProcessDeath, match=r"^ended its process without an answer that can be read$"):
        call_isolated(tamper, limit_s=30)


def test_threads_do_not_keep_a_process_from_ending() -> None:
    assert call_isolated(_start_a_thread, limit_s=30) == "left a thread"


def test_a_process_that_a_call_forks_ends_with_it(tmp_path: Path) -> None:
    def fork(_: Watch) -> None:
        if not os.fork():
            (tmp_path / str(os.getpid())).touch()
            time.sleep(60)  # noqa: TID251
        while not list(tmp_path.iterdir()):
            pass

    call_isolated(fork, limit_s=30)
    (file,) = tmp_path.iterdir()
    deadline = time.monotonic() + 30
    while _is_running(int(file.name)) and time.monotonic() < deadline:
        time.sleep(0.01)  # noqa: TID251  another process's end is waited for
    assert not _is_running(int(file.name))


def _is_running(pid: int) -> bool:
    status = Path("/proc", str(pid), "stat")
    return status.exists() and status.read_text().rpartition(")")[2].split()[0] != "Z"


def test_memory_is_limited() -> None:
    with pytest.raises(ProcessDeath, match=r"^ran out of memory: it may take 4 GiB$"):
        call_isolated(lambda _: len(bytearray(20 << 30)), limit_s=30)


def _children() -> set[str]:
    """Return the ids of this process's children."""
    return {pid for file in Path("/proc/self/task").glob("*/children") for pid in file.read_text().split()}


def test_an_interrupted_caller_leaves_no_process_behind(tmp_path: Path) -> None:
    caller = os.getpid()

    def interrupt(_: Watch) -> None:
        (tmp_path / str(os.getpid())).touch()
        os.kill(caller, signal.SIGINT)
        time.sleep(60)  # noqa: TID251

    before = _children()
    for _ in range(20):  # at different moments
        with pytest.raises(KeyboardInterrupt):
            call_isolated(interrupt, limit_s=30)

    assert len(list(tmp_path.iterdir())) == 20
    for file in tmp_path.iterdir():
        with pytest.raises(ProcessLookupError):
            os.kill(int(file.name), 0)
    assert _children() == before


def test_an_interrupt_before_the_number_of_the_new_process_is_known_leaves_none_behind(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    caller, forked, fork = os.getpid(), list[int](), os.fork

    @contextmanager
    def interrupted() -> Iterator[list[int]]:
        yield []
        if os.getpid() == caller:
            raise KeyboardInterrupt

    def noted_fork() -> int:
        forked.append(fork())
        return forked[-1]

    monkeypatch.setattr(forking, "noted_signals", interrupted)
    monkeypatch.setattr(os, "fork", noted_fork)
    with pytest.raises(KeyboardInterrupt):
        call_isolated(lambda _: time.sleep(60), limit_s=90)  # noqa: TID251

    (pid,) = forked
    with pytest.raises(ChildProcessError):
        os.waitpid(pid, os.WNOHANG)


INTERRUPTED = """
import os, signal, threading, time
from sunset.processes.calls import call_isolated

forked = threading.Event()

def kill():
    forked.wait()
    os.kill(os.getpid(), signal.SIGINT)

thread = threading.Thread(target=kill)  # which has the signal not blocked
thread.start()

def interrupt():
    forked.set()
    thread.join()

os.register_at_fork(after_in_parent=interrupt)
try:
    call_isolated(lambda _: time.sleep(60), limit_s=90)
except KeyboardInterrupt:
    print("interrupted")
"""


def test_an_interrupt_that_another_thread_takes_during_a_fork_is_not_lost() -> None:
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=True, timeout=30
    )

    assert (done.stdout, done.stderr) == ("interrupted\n", "")
