"""`sunset managers`: list the managing systems, and check one's own."""

import argparse
import json
import os
import sys
import tempfile
from contextlib import redirect_stdout
from pathlib import Path
from typing import Final

from sunset.cli._options import add_flight_options, flight_settings
from sunset.cli._progress import progress_bar, rendering_progress
from sunset.experiments import DEFAULT_SCENARIO, RunSpec, manager_checksum, prepare, run
from sunset.managing import MANAGERS
from sunset.scenarios import load_scenario
from sunset.workers import worker_pool

__all__ = ["add_arguments", "check", "list_managers"]

_HASH_SEED: Final = "PYTHONHASHSEED"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    parser.set_defaults(execute=lambda _: parser.print_help())
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
    """Run twice and judge."""
    spec = RunSpec(
        scenario=load_scenario(arguments.scenario),
        manager=arguments.manager,
        seed=arguments.seed,
        settings=flight_settings(arguments),
    )
    manager_checksum(
        spec.manager, limit_s=spec.settings.manager_limit_s
    )  # what is wrong with it is said at once
    with rendering_progress() as progress:
        prepare(spec, progress=progress)
    with (
        progress_bar("Flying twice") as progress,
        tempfile.TemporaryDirectory(prefix="sunset-") as folder,
        redirect_stdout(sys.stderr),
    ):
        progress(0, 2)
        first = _flown(spec, Path(folder) / "first", hash_seed="1", log=True)
        progress(1, 2)
        second = _flown(spec, Path(folder) / "second", hash_seed="2", log=False)
        progress(2, 2)
    adaptations, _, reason = first
    print(f"loads            yes: {arguments.manager}")
    print(f"flies            yes: {adaptations} adaptations in {spec.scenario.name}")
    print(f"keeps the rules  {f'no: {reason}' if reason else 'yes'}")
    same = first == second
    print(f"deterministic    {'yes' if same else 'no: the same seed gave different records'}")
    return 1 if reason or not same else 0


def _flown(spec: RunSpec, folder: Path, *, hash_seed: str, log: bool) -> tuple[int, str, str]:
    """Fly with an interpreter in which sets of texts have an order of its own; return what is judged."""
    own = os.environ.get(_HASH_SEED)
    os.environ[_HASH_SEED] = hash_seed
    try:
        with worker_pool(1) as pool:
            return pool.submit(_fly, spec, folder, log=log).result()
    finally:
        del os.environ[_HASH_SEED]
        if own is not None:
            os.environ[_HASH_SEED] = own


def _fly(spec: RunSpec, folder: Path, *, log: bool) -> tuple[int, str, str]:
    """Return how many adaptations there were, the record's digest, and why the run does not count, if so."""
    result = run(spec, folder, log=log)
    return result.score.adaptations, result.digest, result.reason
