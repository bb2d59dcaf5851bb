"""The line in which things wait for the thread that handles them."""

import threading
import time
from queue import Empty

import pytest

from sunset_ros.rmw.dds._link import WaitingLine


def test_what_came_first_is_taken_first() -> None:
    line: WaitingLine[int] = WaitingLine()
    assert not line
    for item in range(3):
        line.put(item)
    assert line
    assert [line.get() for _ in range(3)] == [0, 1, 2]
    assert not line


@pytest.mark.parametrize("timeout_s", [-1.0, 0.0, 1e-9, 0.02])
def test_nothing_comes_in_time(timeout_s: float) -> None:
    line: WaitingLine[int] = WaitingLine()
    began = time.monotonic()
    with pytest.raises(Empty):
        line.get(timeout_s)
    assert time.monotonic() - began >= timeout_s


def test_a_wait_ends_though_its_time_is_over_before_it_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    line: WaitingLine[int] = WaitingLine()
    line.put(1)
    line.get()  # there was news, so that the next wait begins by looking again
    moments = iter([0.0, 5.0, 10.0])
    monkeypatch.setattr("sunset_ros.rmw.dds._link.time.monotonic", lambda: next(moments))
    with pytest.raises(Empty):
        line.get(7.0)


@pytest.mark.parametrize("timeout_s", [None, 60.0])
def test_a_waiting_thread_is_woken(timeout_s: float | None) -> None:
    line: WaitingLine[int] = WaitingLine()
    helper = threading.Timer(0.05, line.put, [7])
    helper.start()
    assert line.get(timeout_s) == 7
    helper.join()


def test_nothing_is_lost_between_threads() -> None:
    line: WaitingLine[tuple[int, int]] = WaitingLine()
    count = 2000

    def fill(name: int) -> None:
        for number in range(count):
            line.put((name, number))

    threads = [threading.Thread(target=fill, args=[name]) for name in range(3)]
    for thread in threads:
        thread.start()
    taken = [line.get(60.0) for _ in range(3 * count)]
    for thread in threads:
        thread.join()
    for name in range(3):
        assert [number for one, number in taken if one == name] == list(range(count))
    assert not line
