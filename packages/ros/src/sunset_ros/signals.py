"""SIGINT and SIGTERM, as in `rclpy.signals`: they shut the context down, and `spin` returns."""

import signal
import threading
from enum import IntFlag
from types import FrameType

from sunset_ros.context import Context, get_default_context


class SignalHandlerOptions(IntFlag):
    """Which signals shut a context down."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3


_SIGNALS = {SignalHandlerOptions.SIGINT: signal.SIGINT, SignalHandlerOptions.SIGTERM: signal.SIGTERM}


def install_signal_handlers(
    options: SignalHandlerOptions = SignalHandlerOptions.ALL, *, context: Context | None = None
) -> None:
    """Let the next SIGINT or SIGTERM shut a context down, after the callback that runs; a second signal acts as before.

    None is the default context. Only the main thread can; others leave the signals alone.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    shut_down = (context or get_default_context()).try_shutdown
    for option, number in _SIGNALS.items():
        if option in options:
            previous = signal.getsignal(number)

            def handle(number: int, _: FrameType | None, previous: object = previous) -> None:
                signal.signal(number, previous)  # type: ignore[arg-type]  # the result of `getsignal`
                shut_down()

            signal.signal(number, handle)
