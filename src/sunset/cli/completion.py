"""`sunset completion`: completion of this command line by a shell."""

import argparse
from importlib.util import find_spec
from pathlib import Path
from typing import Final

import sunset
from sunset.api.catalogue import scenario_names
from sunset.cli.parser import Parser, make_parser
from sunset.errors import MissingExtraError

_SHELLS: Final = ("bash", "zsh", "fish", "tcsh")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Print a script for a shell, which completes verbs, actions, options, names and files. "
        "Completing runs nothing of SUNSET. Needs the extra 'completion'."
    )
    parser.add_argument("shell", choices=_SHELLS, help=f"one of {', '.join(_SHELLS)}")


def execute(arguments: argparse.Namespace) -> None:
    if find_spec("shtab") is None:
        raise MissingExtraError(
            "Completion needs shtab, which is not installed; run: pip install 'sunset-exemplar[completion]'."
        )
    import shtab  # noqa: PLC0415  an optional extra

    parser = make_parser()
    _complete(parser, shtab.FILE)
    script = shtab.complete(parser, shell=arguments.shell)
    # an option that takes a name or a file: where no name fits, bash itself completes files
    print(script.replace("complete -o bashdefault", "complete -o bashdefault -o default"))


def _complete(parser: Parser, files: object) -> None:
    """Set the names and files that complete each argument of a parser, and of those below it."""
    parser.complete()
    faults = [fault.name for fault in sunset.list_faults()]
    managers, models = sunset.list_managers(), sunset.list_models()
    names = {
        "fault": faults,
        "manager": managers,
        "managers": managers,
        "model": models,
        "models": models,
        "scenario": (*scenario_names(), *faults),
        "suite": sunset.list_suites(),
    }
    for action in parser._actions:  # noqa: SLF001  shtab goes through them as well
        if isinstance(action, argparse._SubParsersAction):  # noqa: SLF001  likewise
            for below in action.choices.values():
                _complete(below, files)
        elif action.choices is None:
            action.choices = names.get(action.dest)
            if action.type is Path:
                vars(action)["complete"] = files  # where shtab looks for it
