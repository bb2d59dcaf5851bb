"""The entry point: choose the verb, run it, turn errors into a sentence and exit code 2."""

import os
import signal
import sys
import threading
from collections.abc import Sequence
from contextlib import ExitStack
from io import TextIOWrapper
from types import FrameType
from typing import Final, NoReturn

from sunset.cli.parser import EXIT_BAD_INPUT, VERBS, Verb, make_parser, split_extensions
from sunset.errors import complaint
from sunset.processes.forking import fill_standard_streams

EXIT_INTERRUPTED: Final = 130
_SIGNALLED: Final = 128
"""Added to a signal's number, as shells do."""

_NODES: Final = "sunset.harness.node_process:run_forked"
_NODES_PREPARATION: Final = "sunset.harness.node_process:prepare"
"""The server of `sunset.harness.node_process.node_server`, by name, since that module is slow to import."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: without the program's name; the process's own if None.

    Returns:
        The exit code: 0 done, 1 done with a negative answer (`managers check`, `ros`, `verify`, `leaderboard`), a
        managing system failed in each of its runs (`bench`), or `train --minutes` stopped before its end, 2 bad input
        (a sentence on stderr says why), 130 interrupted, 143 ended by SIGTERM.
    """
    fill_standard_streams()
    sys.stdout = sys.stdout or os.fdopen(1, "w", encoding="utf-8")
    sys.stderr = sys.stderr or os.fdopen(2, "w", encoding="utf-8")
    arguments = sys.argv[1:] if arguments is None else arguments
    verb = next(iter(arguments), "")
    if isinstance(sys.stdout, TextIOWrapper):  # some terminals lack arrows
        sys.stdout.reconfigure(errors="replace")
    if verb == "up":
        from sunset.processes.server import shared_server  # noqa: PLC0415  no other verb needs it here

        # ahead, so that it imports modules while this process does
        shared_server(_NODES, _NODES_PREPARATION, clean=False)
    return _execute(verb, arguments)


def _execute(verb: str, arguments: Sequence[str]) -> int:
    known = VERBS.get(verb, Verb(""))
    try:
        with ExitStack() as stack:
            extensions, rest = split_extensions(arguments) if known.is_extensible else ([], arguments)
            if extensions:
                from sunset.api.arguments import extended  # noqa: PLC0415  most command lines need none

                stack.enter_context(extended(extensions))
            parsed = make_parser().parse_args(rest)
            parsed.extension = extensions
            if known.is_long and threading.current_thread() is threading.main_thread():
                signal.signal(signal.SIGTERM, _interrupt)
            code = parsed.execute(parsed)
        print(end="", flush=True)
    except BrokenPipeError:
        # the reader of our output has ended; buffered output is discarded
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt as error:
        remedy = f"; {known.continuation}" if known.continuation else ""
        print(f"Interrupted{remedy}.", file=sys.stderr)
        return _SIGNALLED + int(*error.args) if error.args else EXIT_INTERRUPTED
    except Exception as error:
        sentence = complaint(error)
        if not sentence:
            raise
        print(f"sunset: {sentence}", file=sys.stderr)
        return EXIT_BAD_INPUT
    return code or 0


def _interrupt(number: int, _: FrameType | None) -> NoReturn:
    """Interrupt the main thread, so that it removes unfinished files; a second signal ends the process at once."""
    signal.signal(number, signal.SIG_DFL)
    raise KeyboardInterrupt(number)
