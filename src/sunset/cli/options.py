"""Options that several verbs share."""

import argparse
import sys
from collections.abc import Callable, Collection, Sequence
from dataclasses import Field
from inspect import signature
from pathlib import Path
from types import NoneType
from typing import Any, Final, TypeVar

import sunset
from sunset.cli.parser import Container, at_least_one

_T = TypeVar("_T")

MODEL: Final = ("model", "bag", "device")
FLIGHT: Final = (*MODEL, "loop", "duration", "cache")
LIVE: Final = ("middleware", "rate", "viewers")


def add_settings(
    parser: argparse.ArgumentParser, *names: str, without: Collection[str] = (), **helps: str
) -> None:
    """Add options of runs by their names in `sunset.Options`, or all but some; `helps` replaces the help of some."""
    from sunset.experiments.settings import OPTIONS  # noqa: PLC0415  slow, and rarely needed

    for name in names or [name for name in OPTIONS if name not in without]:
        setting = OPTIONS[name]
        words = {"help": setting.metadata["help"], **setting.metadata["words"]}
        flag = words.pop("flag", f"--{name.replace('_', '-')}")
        if name in helps:
            words["help"] = helps[name]
        parser.add_argument(flag, dest=name, **_typed(setting), **words)


def _typed(setting: Field[Any]) -> dict[str, Any]:
    """Return the arguments of `add_argument` that follow from the type of an option's default."""
    default = setting.default
    if isinstance(default, bool):
        return {"action": "store_false" if default else "store_true"}
    if isinstance(default, tuple):
        return {"action": "append", "default": []}
    if isinstance(default, float):
        return {"type": float, "default": f"{default:g}"}
    return {} if isinstance(default, NoneType) else {"default": default}


def call(function: Callable[..., _T], arguments: argparse.Namespace, **others: object) -> _T:
    """Call a function with `others`, and with the arguments of a command line that have the names of its own."""
    names = {*signature(function).parameters}
    if "options" in names:
        names |= sunset.CampaignOptions.__annotations__.keys()
    return function(**{name: value for name, value in vars(arguments).items() if name in names} | others)


def add_campaign_options(
    parser: argparse.ArgumentParser,
    *,
    suite: str,
    managers: str,
    repetitions: int,
    runs: str = "runs",
    more: str = "",
) -> None:
    """Add the options of campaigns, with these defaults; `more` ends the help on managing systems."""
    parser.add_argument(
        "--suite",
        default=suite,
        metavar="NAME|DIR",
        help=f"one of {', '.join(sunset.list_suites())}, or a folder of scenario files",
    )
    parser.add_argument(
        "--scenarios",
        default=(),
        metavar="A,B,…",
        help="names of some scenarios of the suite ('sunset scenarios list --suite NAME'; default: all)",
    )
    parser.add_argument(
        "--managers",
        default=managers,
        metavar="A,B,…",
        help="managing systems, separated by commas that are not in quotes, each as LABEL=… under a name of your own"
        f"{more}",
    )
    parser.add_argument(
        "--flights",
        default=(),
        metavar="A,B,…",
        help="run every scenario on each of these: panel (eight flights), one of the panel, default, or a bag's path, "
        "also as LABEL=PATH",
    )
    parser.add_argument(
        "--repetitions", type=int, default=repetitions, metavar="N", help=f"{runs} a scenario"
    )
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="seed of the first repetition")


def add_format_options(
    parser: argparse.ArgumentParser, formats: Sequence[str], text: str, default: str | None = "table"
) -> None:
    """Add the options for the format of a result."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--format", default=default, choices=formats, help=text)
    group.add_argument(
        "--json", action="store_const", dest="format", const="json", help="same as --format json"
    )


def add_flag(parser: Container, name: str, text: str) -> None:
    """Add an option without a value."""
    parser.add_argument(name, action="store_true", help=text)


def add_path(parser: Container, name: str, metavar: str, text: str, **words: Any) -> None:
    """Add an argument that is a path."""
    parser.add_argument(name, type=Path, metavar=metavar, help=text, **words)


def add_json_option(parser: argparse.ArgumentParser) -> None:
    """Add the option for JSON in place of text."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def add_count_option(parser: argparse.ArgumentParser, name: str, text: str) -> None:
    """Add an option that takes a whole number of at least 1."""
    parser.add_argument(name, type=at_least_one, metavar="N", help=text)


def print_next_steps(steps: Sequence[tuple[str, str]]) -> None:
    """Print suggested command lines, each with its purpose, on stderr."""
    width = max(len(command) for command, _ in steps)
    print("Next:", *(f"  {command:{width}}  {text}" for command, text in steps), sep="\n", file=sys.stderr)
