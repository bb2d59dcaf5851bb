"""Runs of a bundle, run again: which ones can be, which ones are, and what differs."""

import shlex
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from msgspec import UNSET
from msgspec.structs import asdict

from sunset.bundling.checks import Findings
from sunset.bundling.layout import ManagerSources
from sunset.bundling.opened import OpenedBundle
from sunset.bundling.sources import bundle_file
from sunset.errors import InvalidInputError, ManagerError
from sunset.experiments import campaign_managers, model_checksum, run_again
from sunset.managing import MANAGERS, PREFIX
from sunset.perception import list_models, load_model
from sunset.recording import RunRecord
from sunset.rmw.backends import SIMULATED
from sunset.seeding import generator
from sunset.source_files import import_from
from sunset.texts import counted


@dataclass(frozen=True)
class Rerun:
    """Which runs are run again, and with what.

    Attributes:
        number: how many, at most.
        seed: of the choice among those that can be.
        trust: whether code of the bundle may run.
        model: the model's folder or name; that of the plan if None.
        bag: the campaign's bag; the default flight if None.
    """

    number: int
    seed: int
    trust: bool = False
    model: str | None = None
    bag: Path | None = None


def choose_runs(opened: OpenedBundle, findings: Findings, rerun: Rerun) -> list[Path]:
    """Return the runs that are run again, chosen at random among those that can be; note why others cannot."""
    if not rerun.number:
        findings.unchecked.append("No run was run again, as was asked for.")
        return []
    refused: dict[str, int] = {}
    able = []
    for place, run in findings.runs.items() if findings.extended else ():
        reason = _obstacle(opened, run, rerun)
        if reason:
            refused[reason] = refused.get(reason, 0) + 1
        else:
            able.append(place)
    findings.unchecked += [
        f"{counted(number, 'run')} could not be run again: {reason}." for reason, number in refused.items()
    ]
    picked = generator(rerun.seed, "verify").permutation(len(able))[: rerun.number]
    return [able[place] for place in sorted(map(int, picked))]


def _obstacle(opened: OpenedBundle, run: RunRecord, rerun: Rerun) -> str:
    """Return why a run cannot be run again; empty if it can."""
    described, name = opened.described, run.manager
    place = opened.manifest.managers.get(name)
    own = _manager(opened, run) not in MANAGERS
    facts = described.flight_facts.get(run.flight)
    of_bag = described.bag is not None if facts is None else not facts.conditions
    obstacles = {
        "live runs take place in real time and never repeat to the byte": run.middleware != SIMULATED,
        "failed runs leave no messages to compare": run.is_empty,
        "the flight is not in the bundle; name it with --bag": of_bag and rerun.bag is None,
        f"its model {described.model} is not installed; name its folder with --model": (
            rerun.model is None
            and (
                described.model not in list_models()
                or model_checksum(load_model(described.model).card) != described.model_checksum
            )
        ),
        f"that runs the code of {name}, which the bundle has; read it, and let it run with --trust": (
            own and not rerun.trust
        ),
        f"{name} was a class of a program or notebook, which only its process can load": (
            own and (place is None or not place.load)
        ),
    }
    return next((reason for reason, stands in obstacles.items() if stands), "")


def _manager(opened: OpenedBundle, run: RunRecord) -> str:
    """Return the name by which the plan loads the managing system of a run."""
    return campaign_managers(opened.described).get(run.manager, run.manager)


def rerun_run(
    opened: OpenedBundle, place: Path, findings: Findings, rerun: Rerun, into: Path
) -> Iterator[str]:
    """Run a run again, into a new folder; yield what differs, each as a sentence."""
    run = findings.runs[place]
    try:
        with _importing(opened, run) as manager:
            again = run_again(
                place,
                into,
                manager=manager,
                model=rerun.model or opened.described.model,
                bag=None if run.flight_conditions else rerun.bag,
            )
    except (InvalidInputError, ManagerError) as error:
        yield opened.text(error)
        return
    if run.manager_versions != again.record.manager_versions:
        note = f"{run.manager} imported {_packages(run)} when it was run, and now {_packages(again.record)}."
        findings.unchecked = list(dict.fromkeys((*findings.unchecked, note)))
    stored, now = asdict(run), asdict(again.record)
    # neither where it lies nor what it is called is what it is
    of_this_computer = {"versions", "manager_versions", "missing_walls", "manager_spec", "flight"}
    for name in sorted(stored.keys() - of_this_computer):
        # how a managing system hung depends on the limit of the time that it had
        if stored[name] != now[name] and not (name == "manager_failed" and stored[name] and now[name]):
            yield from _contrasts(name, stored[name], now[name])


def _packages(run: RunRecord) -> str:
    return (
        ", ".join(f"{name} {version}" for name, version in (run.manager_versions or {}).items()) or "nothing"
    )


def _contrasts(name: str, stored: object, now: object) -> Iterator[str]:
    """Yield, as sentences, how a stored value differs from that of the run made again: of a mapping, its entries."""
    if not (isinstance(stored, Mapping) and isinstance(now, Mapping)):
        yield f"Its {name} is stored as {stored!r}, and running it again gave {now!r}."
        return
    for key in sorted(stored.keys() | now.keys()):
        before, after = stored.get(key, UNSET), now.get(key, UNSET)
        if before != after:
            yield f"Its {key} is stored as {before!r}, and running it again gave {after!r}."


@contextmanager
def _importing(opened: OpenedBundle, run: RunRecord) -> Iterator[str]:
    """Give the name by which a managing system is loaded, as long as what it is in can be imported."""
    manager = _manager(opened, run)
    if manager in MANAGERS:
        yield manager
        return
    place = opened.manifest.managers[run.manager]
    if place.load.startswith(PREFIX):
        yield _unpacked(opened.root, place)
        return
    where, _, kind = place.load.rpartition(":")
    file = bundle_file(opened.root, where)
    path = list(sys.path)
    try:
        if file is None:  # a module, of the folder that the bundle has of its package
            import_from(opened.root / place.folder)
        yield f"{file}:{kind}" if file is not None else place.load
    finally:
        sys.path[:] = path


def _unpacked(root: Path, place: ManagerSources) -> str:
    """Return the command of a program whose files are in a bundle that was opened into a folder."""
    words = [
        str(root / word) if word == place.folder or word.startswith(f"{place.folder}/") else word
        for word in shlex.split(place.load.removeprefix(PREFIX))
    ]
    if words[0].startswith(f"{root}/"):
        Path(words[0]).chmod(0o755)  # zip files that anybody can check have no permissions
    return PREFIX + shlex.join(words)
