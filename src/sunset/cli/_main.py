"""The entry point: choose the verb, run it, turn errors into one sentence and exit code 2."""

import argparse
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from importlib import import_module
from io import TextIOWrapper
from types import FrameType
from typing import Any, Final, NoReturn

from sunset import __version__
from sunset.errors import SunsetError
from sunset.forks import node_server
from sunset.shortage import shortage
from sunset.texts import suggestion

__all__ = ["EXIT_BAD_INPUT", "EXIT_INTERRUPTED", "main", "make_parser"]

EXIT_BAD_INPUT: Final = 2
EXIT_INTERRUPTED: Final = 130
_SIGNALLED: Final = 128
"""Added to a signal's number, as shells do."""

_QUICK_S: Final = 0.4

_NODE: Final = "node"
_UP: Final = "up"
_FLYING: Final = ("run", "bench", "agree")
_WRITING: Final = (*_FLYING, "managers", "data", "models", "train")
"""Those that take their time: they tidy up when they are asked to end, and show what they do from the first second."""
_CONTINUED: Final = {
    "bench": "the same command continues it",
    "agree": "the same command continues it",
    "train": "the same command with --resume goes on",
}
"""How work goes on that keeps what was finished when it was interrupted."""
_VERBS: Final = (
    *(*_FLYING, "report", "scenarios", "faults", "managers"),
    *("data", "models", "train", _NODE, _UP, "ros", "completion"),
)
"""Each is a module beside this one."""


class _Parser(argparse.ArgumentParser):
    """An argument parser whose complaint is one sentence."""

    def _check_value(self, action: argparse.Action, value: object) -> None:
        """Suggest a choice to who mistyped it."""
        if action.choices is not None and value not in action.choices:
            choices = [str(choice) for choice in action.choices]
            hint = suggestion(str(value), choices)
            raise argparse.ArgumentError(
                action, f"there is no {value!r}: {hint}choose one of {', '.join(choices)}"
            )

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Suggest an option to who mistyped it, in the name of the verb; argparse complains in that of the program."""
        parsed, unknown = super().parse_known_args(args, namespace)
        if unknown:
            option = unknown[0].partition("=")[0]
            hint = suggestion(option, self._option_string_actions)
            self.error(f"there is no argument {option!r} here: {hint}leave it out")
        return parsed, unknown

    def error(self, message: str) -> NoReturn:
        """Print one sentence and exit with code 2."""
        text = message[:1].upper() + message[1:]
        self.exit(EXIT_BAD_INPUT, f"{self.prog}: {text}; '{self.prog} --help' lists what is expected.\n")


def make_parser(verb: str = "") -> argparse.ArgumentParser:
    """Return the parser for a command line that begins with `verb`: of all verbs, unless that is one.

    A process of one node must start quickly, so what the other verbs need is not imported.
    """
    parser = _Parser(
        prog="sunset",
        description="A ROS 2 exemplar for self-adaptation: fly a faulted mission, let a managing system repair it, "
        "and measure how well it did.",
        epilog="'sunset VERB --help' explains one verb.",
    )
    parser.add_argument("--version", action="version", version=f"sunset {__version__}")
    parser.set_defaults(execute=lambda _: parser.print_help())
    verbs = parser.add_subparsers(title="verbs", metavar="VERB", parser_class=_Parser)
    for name in (verb,) if verb in _VERBS else _VERBS:
        import_module(f"sunset.cli.{name}").add_parser(verbs)
    return parser


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
    try:
        with _loading() if verb in _WRITING else nullcontext():
            parser = make_parser(verb)
        parsed = parser.parse_args(arguments, given)
        if verb in _WRITING and threading.current_thread() is threading.main_thread():
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
        remedy = f"; {_CONTINUED[verb]}" if verb in _CONTINUED else ""
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
