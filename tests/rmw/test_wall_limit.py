import signal
import threading
from contextlib import suppress

import pytest

from sunset.errors import MiddlewareError
from sunset.rmw._wall_limit import LimitExceeded, run_limited


def loop_for_ever() -> None:
    while True:
        pass


def loop_for_ever_swallowing_exceptions() -> None:
    while True:
        with suppress(Exception):
            loop_for_ever()


def swallow_even_the_interrupt_once() -> None:
    with suppress(BaseException):
        loop_for_ever()
    loop_for_ever()


@pytest.mark.parametrize(
    "function", [loop_for_ever, loop_for_ever_swallowing_exceptions, swallow_even_the_interrupt_once]
)
def test_a_function_that_hangs_is_interrupted(function: object) -> None:
    with pytest.raises(LimitExceeded):
        run_limited(0.02, function)  # type: ignore[arg-type]


def test_a_function_that_returns_is_not_interrupted_and_the_signal_is_as_before() -> None:
    before = signal.getsignal(signal.SIGALRM)
    calls: list[int] = []
    run_limited(10.0, lambda: calls.append(1))
    assert calls == [1]
    assert signal.getsignal(signal.SIGALRM) is before
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_a_limit_within_a_limit_leaves_that_one_as_it_was() -> None:
    def outer() -> None:
        run_limited(10.0, lambda: None)
        loop_for_ever()

    with pytest.raises(LimitExceeded):
        run_limited(0.05, outer)


def test_another_thread_cannot_have_a_limit() -> None:
    errors: list[MiddlewareError] = []

    def attempt() -> None:
        try:
            run_limited(1.0, lambda: None)
        except MiddlewareError as error:
            errors.append(error)

    thread = threading.Thread(target=attempt)
    thread.start()
    thread.join()
    assert "main thread" in str(errors[0])
