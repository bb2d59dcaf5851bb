import signal
import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from sunset_ros.signals import SignalHandlerOptions, install_signal_handlers

if TYPE_CHECKING:
    from .conftest import World


@pytest.fixture(autouse=True)
def _as_before() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_shuts_the_context_down_and_the_next_acts_as_before(
    world: "World", number: signal.Signals
) -> None:
    before = signal.getsignal(number)
    context = world.context()
    install_signal_handlers(context=context)
    assert signal.getsignal(number) is not before
    signal.raise_signal(number)
    assert not context.ok()
    assert signal.getsignal(number) is before


def test_only_the_signals_asked_for_are_handled(world: "World") -> None:
    before = signal.getsignal(signal.SIGTERM)
    install_signal_handlers(SignalHandlerOptions.SIGINT, context=world.context())
    assert signal.getsignal(signal.SIGTERM) is before
    install_signal_handlers(SignalHandlerOptions.NO, context=world.context())
    assert signal.getsignal(signal.SIGTERM) is before


def test_a_thread_leaves_the_signals_alone(world: "World") -> None:
    before = signal.getsignal(signal.SIGTERM)
    thread = threading.Thread(target=install_signal_handlers, kwargs={"context": world.context()})
    thread.start()
    thread.join()
    assert signal.getsignal(signal.SIGTERM) is before
