"""`sunset managers`: list the managing systems, and check one's own."""

import argparse
import json
import sys
import tempfile
from contextlib import redirect_stdout
from pathlib import Path

from sunset.cli._options import add_flight_options, flight_options
from sunset.cli._progress import rendering_progress
from sunset.experiments import DEFAULT_SCENARIO, RunSpec, prepare, run
from sunset.managing import MANAGERS, load_manager
from sunset.scenarios import load_scenario

__all__ = ["add_parser", "check", "list_managers"]


def add_parser(verbs: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb."""
    parser = verbs.add_parser("managers", help="list managing systems, check your own")
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)
    listing = actions.add_parser("list", help="list those that come with SUNSET")
    listing.add_argument("--json", action="store_true", help="print one JSON object")
    listing.set_defaults(execute=list_managers)
    checking = actions.add_parser(
        "check",
        help="load a managing system and fly it twice",
        description="Load a managing system, fly one scenario twice, and say whether it can be scored: it must not "
        "raise, hang, read the truth or set faults, and the same seed must give the same record.",
    )
    checking.add_argument("manager", help="NAME, FILE.py:CLASS or MODULE:CLASS")
    checking.add_argument("--scenario", default=DEFAULT_SCENARIO, help=f"default: {DEFAULT_SCENARIO}")
    checking.add_argument("--seed", type=int, default=1, metavar="N")
    add_flight_options(checking)
    checking.set_defaults(execute=check)


def list_managers(arguments: argparse.Namespace) -> int:
    """Print the registered managing systems."""
    described = {name: (manager.__doc__ or "").splitlines()[0] for name, manager in MANAGERS.items()}
    if arguments.json:
        managers = [{"name": name, "description": text} for name, text in described.items()]
        print(json.dumps({"managers": managers}, sort_keys=True))
        return 0
    for name, text in described.items():
        print(f"{name:10}{text}")
    return 0


def check(arguments: argparse.Namespace) -> int:
    """Fly twice and judge."""
    with redirect_stdout(sys.stderr):
        load_manager(arguments.manager)
    spec = RunSpec(
        scenario=load_scenario(arguments.scenario),
        manager=arguments.manager,
        seed=arguments.seed,
        **flight_options(arguments),
    )
    with rendering_progress() as progress:
        prepare(spec, progress=progress)
    with tempfile.TemporaryDirectory(prefix="sunset-") as folder, redirect_stdout(sys.stderr):
        first = run(spec, Path(folder) / "first", log=True)
        second = run(spec, Path(folder) / "second")
    print(f"loads            yes: {arguments.manager}")
    print(f"flies            yes: {first.score.adaptations} adaptations in {spec.scenario.name}")
    print(f"keeps the rules  {'yes' if first.valid else f'no: {first.reason}'}")
    same = first.digest == second.digest
    print(f"deterministic    {'yes' if same else 'no: the same seed gave two different records'}")
    return 0 if first.valid and same else 1
