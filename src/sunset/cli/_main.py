"""The entry point: choose the verb, run it, turn errors into one sentence and exit code 2."""

import argparse
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from io import TextIOWrapper
from types import FrameType
from typing import Final, NoReturn

from sunset.cli._parser import EXIT_BAD_INPUT, VERBS, Verb, make_parser
from sunset.errors import SunsetError
from sunset.forks import node_server
from sunset.shortage import shortage

__all__ = ["EXIT_INTERRUPTED", "main"]

EXIT_INTERRUPTED: Final = 130
_SIGNALLED: Final = 128
"""Added to a signal's number, as shells do."""

_QUICK_S: Final = 0.4

_NODE: Final = "node"
_UP: Final = "up"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: without the program's name; the process's own if None.

    Returns:
        The exit code: 0 done, 1 done and the answer is no (`managers check`, `ros`), 2 bad input (one sentence stands
        on stderr), 130 interrupted, 143 ended by SIGTERM.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    verb = next(iter(arguments), "")
    if verb != _NODE and isinstance(sys.stdout, TextIOWrapper):
        # some terminals have no arrows; a forked node's output is not what it was opened as
        sys.stdout.reconfigure(errors="replace")
    if verb != _UP:
        return _execute(verb, arguments, argparse.Namespace())
    with ExitStack() as stack:
        server = node_server()  # which imports what it needs while this process does
        if server is not None:
            stack.callback(server.close)
        return _execute(verb, arguments, argparse.Namespace(server=server))


def _execute(verb: str, arguments: Sequence[str], given: argparse.Namespace) -> int:
    known = VERBS.get(verb, Verb(""))
    try:
        with _loading() if known.is_long else nullcontext():
            parsed = make_parser().parse_args(arguments, given)
        if known.is_long and threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, _interrupt)
        code = parsed.execute(parsed)
        print(end="", flush=True)
    except SunsetError as error:
        return _complain(str(error))
    except BrokenPipeError:
        # the reader of our output has seen enough; what is still buffered has nowhere to go
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt as error:
        remedy = f"; {known.continuation}" if known.continuation else ""
        print(f"Interrupted{remedy}.", file=sys.stderr)
        return _SIGNALLED + int(*error.args) if error.args else EXIT_INTERRUPTED
    except Exception as error:
        if lacking := shortage(error):
            return _complain(f"The computer could not go on: {lacking}.")
        if isinstance(error, OSError):
            where = error.filename or "the output"
            return _complain(f"The operating system refused to use {where}: {error.strerror or error}.")
        raise
    return code or 0


@contextmanager
def _loading() -> Iterator[None]:
    """Say on stderr that the program is being loaded, where that takes longer than `_QUICK_S`."""
    end = "\r" if sys.stderr.isatty() else "\n"  # on a terminal, what comes next takes its place
    timer = threading.Timer(_QUICK_S, print, ["Loading …"], {"end": end, "file": sys.stderr, "flush": True})
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _interrupt(number: int, _: FrameType | None) -> NoReturn:
    """End in order, so that nothing is left behind that is not finished; a second signal ends at once."""
    signal.signal(number, signal.SIG_DFL)
    raise KeyboardInterrupt(number)


def _complain(sentence: str) -> int:
    print(f"sunset: {' '.join(sentence.split()).rstrip('.')}.", file=sys.stderr)
    return EXIT_BAD_INPUT
