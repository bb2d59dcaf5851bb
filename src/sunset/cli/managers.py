"""`sunset managers`: list the managing systems, and check a user's own."""

import argparse
import json

import sunset
from sunset.cli.options import LIVE, add_json_option, add_settings, call
from sunset.cli.parser import Parser
from sunset.cli.progress import run_progress
from sunset.texts.tables import aligned


def add_arguments(parser: Parser) -> None:
    actions = parser.add_subparsers(title="actions", metavar="ACTION")
    listing = actions.add_parser("list", help="list those that come with SUNSET")
    add_json_option(listing)
    listing.set_defaults(execute=list_managers)
    actions.add_parser(
        "check",
        help="load a managing system and run it twice",
        description="Load a managing system, run one scenario twice, and say whether it can be scored: it must not "
        "raise, hang, end its process, read the truth or set faults, and the same seed must give the same record, even "
        "where sets have another order.",
        add=_add_check,
    )


def _add_check(parser: Parser) -> None:
    from sunset.api.running import CHECK_SCENARIO  # noqa: PLC0415  slow, and not needed for the list

    parser.add_argument("manager", help="NAME, FILE.py:CLASS, MODULE:CLASS or exec:COMMAND")
    parser.add_argument("--scenario", default=CHECK_SCENARIO, help="what it is run in")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    add_settings(parser, without=(*LIVE, "images"))
    parser.set_defaults(execute=check)


def list_managers(arguments: argparse.Namespace) -> None:
    managers = sunset.list_managers().items()
    described = {name: (manager.__doc__ or "").splitlines()[0] for name, manager in managers}
    if arguments.json:
        listed = [{"name": name, "description": text} for name, text in described.items()]
        print(json.dumps({"managers": listed}, sort_keys=True))
    else:
        print("\n".join(aligned(list(described.items()), left=range(2))))


def check(arguments: argparse.Namespace) -> int:
    with run_progress("Running twice") as (preparing, progress):
        verdict = call(sunset.check_manager, arguments, progress=progress, preparing=preparing)
    print(verdict)
    return 0 if verdict.passed else 1
