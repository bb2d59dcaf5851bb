"""`sunset managers`: list the managing systems, and check one's own."""

import argparse
import json
import os
import sys
import tempfile
from contextlib import redirect_stdout
from pathlib import Path
from typing import Final

from sunset.cli._options import add_flight_options, flight_options
from sunset.cli._progress import rendering_progress
from sunset.experiments import DEFAULT_SCENARIO, RunSpec, prepare, run
from sunset.managing import MANAGERS, load_manager
from sunset.scenarios import load_scenario
from sunset.workers import worker_pool

__all__ = ["add_parser", "check", "list_managers"]

_HASH_SEED: Final = "PYTHONHASHSEED"


def add_parser(verbs: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb."""
    parser = verbs.add_parser("managers", help="list managing systems, check your own")
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)
    listing = actions.add_parser("list", help="list those that come with SUNSET")
    listing.add_argument("--json", action="store_true", help="print one JSON object")
    listing.set_defaults(execute=list_managers)
    checking = actions.add_parser(
        "check",
        help="load a managing system and fly it three times, in two processes",
        description="Load a managing system, fly one scenario three times, and say whether it can be scored: it must "
        "not raise, hang, read the truth or set faults, and the same seed must give the same record, in another "
        "process and a second time in the same one.",
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
    """Fly three times and judge."""
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
        (first,) = _flown(spec, Path(folder), 1, hash_seed="1", log=True)
        others = _flown(spec, Path(folder), 2, hash_seed="2", log=False)
    adaptations, _, reason = first
    print(f"loads            yes: {arguments.manager}")
    print(f"flies            yes: {adaptations} adaptations in {spec.scenario.name}")
    print(f"keeps the rules  {f'no: {reason}' if reason else 'yes'}")
    same = set(others) == {first}
    print(f"deterministic    {'yes' if same else 'no: the same seed gave different records'}")
    return 1 if reason or not same else 0


def _flown(
    spec: RunSpec, folder: Path, times: int, *, hash_seed: str, log: bool
) -> list[tuple[int, str, str]]:
    """Fly in a process of its own, in which sets of texts have another order; return what is judged, each time."""
    own = os.environ.get(_HASH_SEED)
    os.environ[_HASH_SEED] = hash_seed
    try:
        with worker_pool(1) as pool:
            places = [folder / f"{hash_seed}-{number}" for number in range(times)]
            return [pool.submit(_fly, spec, place, log=log).result() for place in places]
    finally:
        del os.environ[_HASH_SEED]
        if own is not None:
            os.environ[_HASH_SEED] = own


def _fly(spec: RunSpec, folder: Path, *, log: bool) -> tuple[int, str, str]:
    """Return how many adaptations there were, the record's digest, and why the run does not count, if so."""
    result = run(spec, folder, log=log)
    return result.score.adaptations, result.digest, result.reason
