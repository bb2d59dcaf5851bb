"""Second runs of a bundle's runs: their choice, and the fields of the record that differ."""

import shlex
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from msgspec import UNSET
from msgspec.structs import asdict

from sunset.api.bundling.checks import Findings
from sunset.api.bundling.sources import ManagerSources, OpenedBundle, manager_folder
from sunset.errors import InvalidInputError, ManagerError
from sunset.experiments import campaign_managers, model_checksum, run_again
from sunset.files.sources import import_from
from sunset.managing import MANAGERS, PREFIX
from sunset.perception import list_models, load_model
from sunset.recording import RunRecord
from sunset.texts.sentences import counted
from sunset_ros.rmw.backends import SIMULATED
from sunset_ros.seeding import generator

_OF_THIS_COMPUTER: Final = {"versions", "manager_versions", "missing_walls", "manager_spec", "flight"}
"""Fields of a record that may differ in a second run: places, names, and versions."""


@dataclass(frozen=True)
class Rerun:
    """The greatest number of second runs, the seed of their choice, and the arguments of `sunset.verify` for them."""

    number: int
    seed: int
    trust: bool = False
    model: str | None = None
    bag: Path | None = None


def choose_runs(opened: OpenedBundle, findings: Findings, rerun: Rerun) -> list[Path]:
    """Return the runs to repeat, chosen at random among those that can be; note why others cannot."""
    if not rerun.number:
        findings.unchecked.append("No run was run again, as was asked for.")
        return []
    runs = findings.runs.items() if findings.has_extensions else ()
    obstacles = {place: _obstacle(opened, run, rerun) for place, run in runs}
    findings.unchecked += [
        f"{counted(number, 'run')} could not be run again: {obstacle}."
        for obstacle, number in Counter(filter(None, obstacles.values())).items()
    ]
    able = [place for place, obstacle in obstacles.items() if not obstacle]
    picked = generator(rerun.seed, "verify").permutation(len(able))[: rerun.number]
    return [able[number] for number in sorted(map(int, picked))]


def _obstacle(opened: OpenedBundle, run: RunRecord, rerun: Rerun) -> str:
    """Return why a run cannot be repeated; empty if it can."""
    plan, name = opened.plan, run.manager
    sources = opened.manifest.managers.get(name)
    is_own = _manager(opened, run) not in MANAGERS
    facts = plan.flight_facts.get(run.flight)
    is_on_bag = plan.bag is not None if facts is None else not facts.conditions
    obstacles = {
        "live runs take place in real time and never repeat to the byte": run.middleware != SIMULATED,
        "failed runs leave no messages to compare": run.is_empty,
        "the flight is not in the bundle; name it with --bag": is_on_bag and rerun.bag is None,
        f"its model {plan.model} is not installed; name its folder with --model": (
            rerun.model is None
            and (
                plan.model not in list_models()
                or model_checksum(load_model(plan.model).card) != plan.model_checksum
            )
        ),
        f"that runs the code of {name}, which the bundle has; read it, and let it run with --trust": (
            is_own and not rerun.trust
        ),
        f"{name} was a class of a program or notebook, which only its process can load": (
            is_own and (sources is None or not sources.load)
        ),
    }
    return next((obstacle for obstacle, holds in obstacles.items() if holds), "")


def _manager(opened: OpenedBundle, run: RunRecord) -> str:
    """Return the name by which the plan loads the managing system of a run."""
    return campaign_managers(opened.plan).get(run.manager, run.manager)


def rerun_run(
    opened: OpenedBundle, place: Path, findings: Findings, rerun: Rerun, into: Path
) -> Iterator[str]:
    """Repeat a run into a new folder; yield a sentence for each difference."""
    run = findings.runs[place]
    try:
        with _importing(opened, run) as manager:
            again = run_again(
                place,
                into,
                manager=manager,
                model=rerun.model or opened.plan.model,
                bag=None if run.flight_conditions else rerun.bag,
            ).record
    except (InvalidInputError, ManagerError) as error:
        yield opened.text(error)
        return
    if run.manager_versions != again.manager_versions:
        note = f"{run.manager} imported {_packages(run)} when it was run, and now {_packages(again)}."
        findings.unchecked = list(dict.fromkeys((*findings.unchecked, note)))
    stored, now = _values(run), _values(again)
    for name in sorted(stored.keys() | now.keys()):
        before, after = stored.get(name, UNSET), now.get(name, UNSET)
        # the sentence about a managing system that hung depends on its time limit
        if before != after and not (name == "manager_failed" and before and after):
            yield f"Its {name} is stored as {before!r}, and running it again gave {after!r}."


def _values(run: RunRecord) -> dict[str, object]:
    """Return the figures of a record, and its fields that must repeat, by name."""
    fields = {
        name: value for name, value in asdict(run).items() if name not in {*_OF_THIS_COMPUTER, "metrics"}
    }
    return {**run.metrics, **fields}


def _packages(run: RunRecord) -> str:
    versions = run.manager_versions or {}
    return ", ".join(f"{name} {version}" for name, version in versions.items()) or "nothing"


@contextmanager
def _importing(opened: OpenedBundle, run: RunRecord) -> Iterator[str]:
    """Give the name by which a managing system is loaded, while its modules can be imported."""
    manager = _manager(opened, run)
    if manager in MANAGERS:
        yield manager
        return
    sources, folder = opened.manifest.managers[run.manager], manager_folder(run.manager)
    if sources.load.startswith(PREFIX):
        yield _unpacked(opened.root, sources, folder)
        return
    where, _, kind = sources.load.rpartition(":")
    file = opened.file(where)
    path = list(sys.path)
    try:
        if file is None:  # a module of a package, which the folder holds
            import_from(opened.root / folder)
        yield f"{file}:{kind}" if file is not None else sources.load
    finally:
        sys.path[:] = path


def _unpacked(root: Path, sources: ManagerSources, folder: str) -> str:
    """Return the command of a program whose files are in an opened bundle."""
    words = [
        str(root / word) if word == folder or word.startswith(f"{folder}/") else word
        for word in shlex.split(sources.load.removeprefix(PREFIX))
    ]
    if words[0].startswith(f"{root}/"):
        Path(words[0]).chmod(0o755)  # a bundle lacks permissions
    return PREFIX + shlex.join(words)
