"""`sunset managers`: list the managing systems, and check one's own."""

import argparse
import json
import sys
from contextlib import redirect_stdout

from sunset.cli._options import add_run_options, run_spec
from sunset.cli._prepare import prepare_flight
from sunset.cli._progress import progress_bar
from sunset.experiments import CHECK_SCENARIO, check_manager, manager_checksum
from sunset.managing import MANAGERS
from sunset.tables import aligned


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    actions = parser.add_subparsers(title="actions", metavar="ACTION")
    listing = actions.add_parser("list", help="list those that come with SUNSET")
    listing.add_argument("--json", action="store_true", help="print one JSON object")
    listing.set_defaults(execute=list_managers)
    checking = actions.add_parser(
        "check",
        help="load a managing system and run it twice",
        description="Load a managing system, run one scenario twice, and say whether it can be scored: it must not "
        "raise, hang, end its process, read the truth or set faults, and the same seed must give the same record, even "
        "where sets have another order.",
    )
    checking.add_argument("manager", help="NAME, FILE.py:CLASS, MODULE:CLASS or exec:COMMAND")
    checking.add_argument("--scenario", default=CHECK_SCENARIO, help="what it is run in")
    checking.add_argument("--seed", type=int, default=1, metavar="N")
    add_run_options(checking)
    checking.set_defaults(execute=check)


def list_managers(arguments: argparse.Namespace) -> None:
    """Print the registered managing systems."""
    described = {name: (manager.__doc__ or "").splitlines()[0] for name, manager in MANAGERS.items()}
    if arguments.json:
        managers = [{"name": name, "description": text} for name, text in described.items()]
        print(json.dumps({"managers": managers}, sort_keys=True))
    else:
        print("\n".join(aligned(list(described.items()), left=range(2))))


def check(arguments: argparse.Namespace) -> int:
    """Run twice and judge."""
    spec = run_spec(arguments)
    # what is wrong with it is said at once
    manager_checksum(spec.manager, spec.settings)
    prepare_flight(spec)
    with progress_bar("Running twice") as progress, redirect_stdout(sys.stderr):
        verdict = check_manager(spec, progress=progress)
    print(verdict)
    return 0 if verdict.passed else 1
