"""The parser of the command line: a table of verbs, each of which is loaded when it is asked for."""

import argparse
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from importlib import import_module
from math import inf
from typing import Any, Final, NamedTuple, NoReturn, TypeAlias, TypeVar

import sunset
from sunset_ros.texts import sentence, suggestion

_N = TypeVar("_N", int, float)

EXIT_BAD_INPUT: Final = 2

_MEANT: Final = {"gpu": "cuda"}
"""Mistyped choice → the choice that is meant, although others are more like it."""

Actions: TypeAlias = "argparse._SubParsersAction[Parser]"  # noqa: SLF001  it lacks a public name


Container: TypeAlias = argparse._ActionsContainer  # noqa: SLF001  likewise
"""A parser, or a group of its arguments."""


class Verb(NamedTuple):  # not a dataclass, whose module is slow to import
    """The facts of a verb that are needed before its module is loaded.

    Attributes:
        help: its job, in a line.
        is_long: whether SIGTERM ends it in order.
        continuation: how interrupted work is continued, if finished work is kept.
        is_extensible: whether it takes extensions of the managed system.
        module: the module of its arguments; a module beside this one if empty.
    """

    help: str
    is_long: bool = False
    continuation: str = ""
    is_extensible: bool = False
    module: str = ""


_SAME_COMMAND: Final = "the same command continues it"

VERBS: Final[Mapping[str, Verb]] = {
    "run": Verb("run one scenario and measure the adaptation", is_long=True, is_extensible=True),
    "bench": Verb(
        "run managing systems over a suite and print how they score",
        True,
        _SAME_COMMAND,
        is_extensible=True,
    ),
    "agree": Verb("compare live runs with simulated ones", True, _SAME_COMMAND, is_extensible=True),
    "report": Verb("print the table of stored runs, or the time line of one", is_extensible=True),
    "bundle": Verb("pack a campaign into one file that others can check", is_long=True, is_extensible=True),
    "verify": Verb("check a bundle: compute its figures again, and run some of its runs again", is_long=True),
    "leaderboard": Verb("verify bundles, and write a page with their managing systems", is_long=True),
    "view": Verb("replay a stored run, or two side by side, in a page", is_long=True, is_extensible=True),
    "scenarios": Verb("the faults of a run: list, show, generate, check", is_extensible=True),
    "faults": Verb("the catalogue of faults: list, show, figure", is_extensible=True),
    "managers": Verb("managing systems: list, check (your own)", is_long=True, is_extensible=True),
    "data": Verb("flights: render, import, info", is_long=True),
    "models": Verb(
        "segmentation models: list, show, import, calibrate, curves, flights, iou",
        is_long=True,
        is_extensible=True,
    ),
    "train": Verb(
        "train a segmentation model on rendered towns",
        True,
        "the same command with --resume continues it",
        module="sunset_lab.verbs.train",
    ),
    "node": Verb("run one node as a process on ROS 2's network", is_extensible=True),
    "up": Verb("run the whole system as processes on ROS 2's network", is_extensible=True),
    "ros": Verb(
        "look at a running ROS 2 system and change it, without a ROS installation",
        module="sunset_ros.commands",
    ),
    "completion": Verb("print what a shell completes this command line with"),
}
"""By name. The module of a verb is imported when it is used, also from packages that import this one."""


_EXTENSION: Final[Mapping[str, Any]] = {
    "action": "append",
    "default": [],
    "metavar": "FILE.py|NAME",
    "help": "add nodes, signals, failures, faults and suites to the managed system; may be repeated",
}


def split_extensions(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the extensions in a command line, and the rest of it."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    parser.add_argument("--extension", **_EXTENSION)
    try:
        known, rest = parser.parse_known_args(arguments)
    except argparse.ArgumentError:  # nothing follows it, of which the verb's own parser complains
        return [], list(arguments)
    return known.extension, rest


class Parser(argparse.ArgumentParser):
    """An argument parser that adds its arguments when it is first used, and complains in a sentence.

    Args:
        add: adds the arguments.
        options: as in `argparse.ArgumentParser`.
    """

    def __init__(self, *, add: Callable[["Parser"], None] = lambda _: None, **options: Any) -> None:
        super().__init__(**options)
        self.register("type", int, partial(parse_number, kind=int, expected="a whole number"))
        self.register("type", float, partial(parse_number, kind=float, expected="a number"))
        self.set_defaults(execute=lambda _: self.print_help())
        self._add = add

    def complete(self) -> None:
        """Add the arguments, unless that was done before; add its default to the help of each option."""
        add, self._add = self._add, lambda _: None
        add(self)
        for action in self._actions:
            value, text = action.default, action.help
            has_default = type(value) in {str, int, float} and value not in {"", argparse.SUPPRESS}
            if has_default and text and "(default: " not in text:
                action.help = f"{text} (default: %(default)s)"

    def below(self) -> "list[Parser]":
        """Return the parsers of the actions."""
        groups = [action for action in self._actions if isinstance(action, argparse._SubParsersAction)]  # noqa: SLF001  see Actions
        return [parser for group in groups for parser in group.choices.values()]

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Complain of unknown arguments under the verb's name, and suggest a similar option; argparse does neither."""
        self.complete()
        parsed, unknown = super().parse_known_args(args, namespace)
        if unknown:
            option = unknown[0].partition("=")[0]
            # without the dashes, which would make all options alike
            options = [known.removeprefix("--") for known in self._option_string_actions]
            mistyped = option.startswith("--")
            hint = suggestion(option.removeprefix("--"), options, prefix="--") if mistyped else ""
            remedy = _joined_faults([getattr(parsed, "scenario", ""), *unknown]) or "leave it out"
            self.error(f"there is no argument {option!r} here: {hint}{remedy}")
        return parsed, unknown

    def _check_value(self, action: argparse.Action, value: object) -> None:
        """Suggest the choice that is most like a mistyped choice."""
        if action.choices is not None and value not in action.choices:
            choices = [str(choice) for choice in action.choices]
            hint = suggestion(_MEANT.get(str(value), value), choices)
            raise argparse.ArgumentError(
                action, f"there is no {value!r}: {hint}choose one of {', '.join(choices)}"
            )

    def error(self, message: str) -> NoReturn:
        """Print the complaint and exit with code 2."""
        text = sentence(message[:1].upper() + message[1:])
        self.exit(EXIT_BAD_INPUT, f"{self.prog}: {text}; '{self.prog} --help' lists what is expected.\n")


def _joined_faults(words: Sequence[str]) -> str:
    """Return how separate faults are joined as a scenario; empty if a word is not a fault."""
    known = {fault.name for fault in sunset.list_faults()}
    faults = [fault for word in words for fault in word.split("+") if fault or not word]
    are_known = all(fault.partition("=")[0] in known for fault in faults)
    return f"join faults by +: {'+'.join(faults)}" if are_known else ""


def parse_number(
    text: str, *, kind: Callable[[str], _N], expected: str, least: float | None = None, most: float = inf
) -> _N:
    """Parse a number of a kind, `int` or `float`, that is `expected` in words, in [least, most]."""
    with suppress(ValueError):
        value = kind(text)
        if least is None or least <= value <= most:
            return value
    raise argparse.ArgumentTypeError(f"expected {expected}, got {text!r}")


at_least_one: Final = partial(parse_number, kind=int, expected="a whole number of at least 1", least=1)
"""Parses a whole number of at least 1."""


def add_module(name: str, *, is_extensible: bool = False) -> Callable[[Parser], None]:
    """Return a function that completes the parser of a verb, or of an action, when it is used.

    It imports the module `name`, lets its `add_arguments` describe and add the arguments, and adds `--extension`. The
    module's `execute`, if any, does the verb's work with the parsed arguments, and may return the exit code.
    """

    def add(parser: Parser) -> None:
        module = import_module(name)
        if hasattr(module, "execute"):
            parser.set_defaults(execute=module.execute)
        module.add_arguments(parser)
        if is_extensible:
            # `main` has taken them out of the command line already
            for each in (parser, *parser.below()):
                each.add_argument("--extension", **_EXTENSION)

    return add


def make_parser() -> Parser:
    """Return the parser of the whole command line; a verb's module is loaded when its parser is used."""
    parser = Parser(
        prog="sunset",
        description="A ROS 2 exemplar for self-adaptation: inject faults into a perception pipeline, let a managing "
        "system repair it, and measure how well it does.",
        epilog="'sunset VERB --help' explains one verb.",
    )
    parser.add_argument("--version", action="version", version=f"sunset {sunset.__version__}")
    verbs = parser.add_subparsers(title="verbs", metavar="VERB")
    for name, verb in VERBS.items():
        module = add_module(verb.module or f"sunset.cli.{name}", is_extensible=verb.is_extensible)
        verbs.add_parser(name, help=verb.help, add=module)
    return parser
