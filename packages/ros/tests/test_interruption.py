"""Signals are held back until it is safe."""

import signal

import pytest

from sunset_ros.interruption import held_signals, noted_signals

pytestmark = pytest.mark.thorough


def get_signals(*numbers: int, look: bool = True, error: Exception | None = None) -> None:
    """Get signals, then look whether there were some, or raise an error."""
    with held_signals() as check:
        check()
        for number in numbers:
            signal.raise_signal(number)
        if look:
            check()
        if error is not None:
            raise error


@pytest.mark.parametrize("look", [True, False])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_waits_until_somebody_looks_or_all_is_over(number: signal.Signals, look: bool) -> None:
    handler = signal.default_int_handler
    before = signal.signal(number, handler)  # whoever runs the tests may ignore it, as nohup does
    try:
        with pytest.raises(KeyboardInterrupt) as raised:
            get_signals(number, signal.SIGINT, look=look)
        assert raised.value.args == (number,)
        assert signal.getsignal(number) is handler
    finally:
        signal.signal(number, before)


def test_a_signal_does_not_replace_an_error() -> None:
    with pytest.raises(LookupError):
        get_signals(signal.SIGTERM, look=False, error=LookupError())


def test_a_signal_that_is_ignored_stays_so() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        get_signals(signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_signal_that_is_held_back_is_answered_at_once(capfd: pytest.CaptureFixture[str]) -> None:
    with noted_signals("Ending after this step.") as came:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        assert capfd.readouterr().err == "Ending after this step.\n"
    assert len(came) == 2
