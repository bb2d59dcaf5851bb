"""A campaign is run: by processes, an executor or in shards; resumable."""

import logging
import shutil
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

from msgspec.structs import asdict

from sunset.errors import InvalidInputError, RecordError
from sunset.experiments.campaign import (
    BenchSpec,
    campaign_managers,
    describe_campaign,
    flights_of,
    flown,
    in_turn,
    plan,
    run_folder,
)
from sunset.experiments.campaign_lock import locked_campaign
from sunset.experiments.campaign_run import run_of_campaign
from sunset.experiments.cluster import check_executor, run_on_workers
from sunset.experiments.resources import prepare_all
from sunset.experiments.shards import Shard
from sunset.experiments.spec import RunSpec
from sunset.experiments.worker import facts_of
from sunset.managing import is_registered, split_label
from sunset.output_files import write_text
from sunset.processes.workers import Progress, check_jobs, processors, worker_pool
from sunset.recording import (
    PLAN_FILE,
    RUN_FILE,
    CampaignPlan,
    read_plan,
    read_run,
)
from sunset.schemas import document_text
from sunset.texts import counted, listed

_log: Final = logging.getLogger(__name__)

_CHANGING: Final = MappingProxyType({"manager_checksums": "managing system", "extensions": "extension"})
"""Key of a campaign's plan that holds checksums by name → what they are of, where that is the user's own."""


def count_runs(out: Path) -> tuple[int, int] | None:
    """Return how many runs of a folder's campaign are there, and how many it has; None if it holds no campaign.

    Those of folders in it count, too: of one campaign, once, such as its shards.

    Raises:
        RecordError: a campaign's plan is damaged, or of another version.
    """
    found: dict[bytes, tuple[int, set[Path]]] = {}
    for file in sorted([*out.glob(PLAN_FILE), *out.glob(f"*/{PLAN_FILE}")]):
        planned = read_plan(file.parent).runs
        runs = found.setdefault(file.read_bytes(), (planned, set()))[1]
        runs.update(run.relative_to(file.parent) for run in file.parent.glob(f"runs/*/*/*/seed-*/{RUN_FILE}"))
    if not found:
        return None
    return sum(len(runs) for _, runs in found.values()), sum(planned for planned, _ in found.values())


def bench(
    spec: BenchSpec,
    out: Path,
    *,
    jobs: int | None = None,
    executor: Executor | None = None,
    shard: Shard | None = None,
    progress: Progress | None = None,
) -> int:
    """Run a campaign; runs that `out` holds already are not repeated.

    Every run is written to a temporary folder and renamed when it is complete, so that nothing that was
    finished is lost, whatever ends this process, and an interrupted campaign is continued by the same call.

    Args:
        spec: what to run.
        out: the folder of results; it is made if there is none, and must belong to the same campaign.
        jobs: number of worker processes; if None one a core, or one in all for live runs, which need the processor
            in time. It has no influence on any result of the simulation.
        executor: does the runs in the place of worker processes, also on other computers; it is not shut down.
        shard: the part of the campaign that is run; all if None.
        progress: called with (runs that are done, runs in all), first with those that an earlier call had done.

    Returns:
        How many runs this call has done.

    Raises:
        InvalidInputError: `out` holds another campaign, or a scenario, model or bag is not usable; or an executor
            cannot do the runs.
        ManagerError: a managing system cannot be loaded or failed.
        OutputError: `out` cannot be written, or another process runs its campaign.
        SunsetError: a worker process was killed, or the executor has failed.
    """
    check_jobs(jobs)
    spec = _as_begun(spec, out)
    if executor is not None:
        _check_executor(executor, spec, jobs)
    runs = plan(spec)
    wanted = in_turn(runs) if shard is None else shard.of(in_turn(runs))
    # rendering and measuring flights and loading a model are done once, before the workers need them
    of_flights = flights_of(runs)
    prepared = list(zip(of_flights, prepare_all(of_flights), strict=True))
    described = describe_campaign(spec, runs, prepared)
    checksums = described.manager_checksums
    with locked_campaign(out, shard):
        _claim(out, described)
        places = [(run, run_folder(out, run), checksums.get(run.manager_name)) for run in wanted]
        todo = [place for place in places if not _is_done(place[1])]
        done = len(wanted) - len(todo)
        if progress is not None:
            progress(done, len(wanted))
        if not todo:
            return 0
        if executor is not None:
            facts = {flown(run): facts_of(resources) for run, resources in prepared}
            counts = run_on_workers(executor, [(*place, facts[flown(place[0])]) for place in todo])
        else:
            jobs = jobs or (1 if spec.settings.live else processors())
            counts = _run_all(todo, min(jobs, len(todo)))
        for count in counts:
            if progress is not None:
                progress(done + count, len(wanted))
    return len(todo)


def failing_managers(out: Path, runs: Sequence[RunSpec]) -> dict[str, str]:
    """Return the managing systems that failed in all of some finished runs: name → the first failure.

    Raises:
        RecordError: a record is damaged, or of another version.
    """
    failures: dict[str, list[str | None]] = {}
    for run in runs:
        failures.setdefault(run.manager_name, []).append(read_run(run_folder(out, run)).manager_failed)
    return {name: found[0] for name, found in failures.items() if found[0] is not None and None not in found}


def _as_begun(spec: BenchSpec, out: Path) -> BenchSpec:
    """Return a campaign with its managing systems named as when it was begun, if it was by another path."""
    if not (out / PLAN_FILE).is_file():
        return spec
    begun = {_resolved(manager): manager for manager in read_plan(out).managers}
    managers = tuple(begun.get(_resolved(manager), manager) for manager in spec.managers)
    return replace(spec, managers=managers)


def _resolved(manager: str) -> tuple[str, str, str]:
    """Return the label, the file or module, and the class of a managing system."""
    label, named = split_label(manager)
    where, _, name = named.rpartition(":")
    return label, str(Path(where).resolve()) if where.endswith(".py") else where, name


def _is_done(folder: Path) -> bool:
    """Return whether a run is done; a damaged record, such as a power cut leaves, is removed."""
    if not (folder / RUN_FILE).is_file():
        return False
    try:
        read_run(folder)
    except RecordError as error:
        _log.warning("%s It is run again.", error)
        shutil.rmtree(folder)
        return False
    return True


def _check_executor(executor: Executor, spec: BenchSpec, jobs: int | None) -> None:
    """Make sure that an executor can do the runs of a campaign.

    Raises:
        InvalidInputError: it cannot.
    """
    check_executor(executor)
    if jobs is not None:
        raise InvalidInputError(
            f"An executor has workers of its own, got {counted(jobs, 'job')} besides: leave the jobs out."
        )
    if spec.settings.live:
        raise InvalidInputError("Live runs take place on this computer: leave the executor out.")
    for name, manager in campaign_managers(spec).items():
        if is_registered(manager):
            raise InvalidInputError(
                f"An executor's workers do not have the managing system {name}, which was passed as a "
                "class or function: name it FILE.py:Class or module:Class."
            )


def _run_all(todo: Sequence[tuple[RunSpec, Path, str | None]], jobs: int) -> Iterator[int]:
    """Do all runs, each into its folder, with the managing system's checksum; yield how many are finished, after each.

    With several jobs they are done by other processes, as many at a time as there are jobs.
    """
    if jobs == 1:
        for count, order in enumerate(todo, 1):
            run_of_campaign(*order)
            yield count
        return
    forked = any(is_registered(spec.manager) for spec, _, _ in todo)
    with worker_pool(jobs, forked=forked) as pool:
        futures = [pool.submit(run_of_campaign, *order) for order in todo]
        for count, future in enumerate(as_completed(futures), 1):
            future.result()
            yield count


def _claim(out: Path, plan: CampaignPlan) -> None:
    """Write the campaign's plan into its folder, or check that it is the one that stands there.

    Raises:
        InvalidInputError: another one stands there, or none that can be read, or nothing says whether a managing system
            is the same.
    """
    file = out / PLAN_FILE
    if not file.exists():
        write_text(file, document_text(plan))
        return
    theirs, ours = _flat(read_plan(out)), _flat(plan)
    differing = sorted(key for key in ours | theirs if theirs.get(key) != ours.get(key))
    if differing:
        # a name that differs says more than the checksum or the number that differs with it
        key = min(differing, key=lambda name: (name == "runs", "checksum" in name or "flight_facts" in name))
        kind, _, name = key.partition(".")
        changed = _CHANGING.get(kind)
        if changed and key in ours and key in theirs:
            raise InvalidInputError(
                f"The {changed} {name} has changed since the campaign in {out} was begun, and its runs are of the old "
                "one; name a new folder."
            )
        if kind == "extensions":
            word = "with" if key in theirs else "without"
            raise InvalidInputError(
                f"The campaign in {out} was begun {word} the extension {name}; name the same extensions, or a new "
                "folder."
            )
        if key == "versions.sunset":
            raise InvalidInputError(
                f"The campaign in {out} was begun with SUNSET {theirs.get(key)}, and this is {ours[key]}, whose code "
                "differs: go on with that one, or name a new folder."
            )
        several = (
            kind == key and key.endswith("s") and not (key.endswith("_s") or isinstance(ours[key], bool))
        )
        verb = "are" if several else "is"
        raise InvalidInputError(
            f"The folder {out} holds another campaign: its {key} {verb} {_told(theirs.get(key))}, this one's "
            f"{verb} {_told(ours.get(key))}; name a new folder."
        )
    for name, manager in campaign_managers(plan).items():
        if is_registered(manager) and not plan.manager_checksums[name]:
            raise InvalidInputError(
                f"The campaign in {out} cannot be continued: nothing says whether its managing system {name} "
                f"is the same as then: pass a class or function of a file, or name a new folder."
            )


def _told(value: object) -> str:
    """Return an entry of a plan as a sentence has it."""
    if isinstance(value, list):
        return listed([*map(repr, value)]) if value else "not given"
    return repr(value)


def _flat(plan: CampaignPlan) -> dict[str, object]:
    """Return a plan by key, with the entries of its dictionaries as entries of its own: `versions.numpy`."""
    flat: dict[str, object] = {}
    for key, value in asdict(plan).items():
        inner = {f"{key}.{name}": entry for name, entry in value.items()} if isinstance(value, dict) else {}
        if key == "flight_facts":
            inner = {
                f"{name}.{part}": fact
                for name, facts in inner.items()
                for part, fact in asdict(facts).items()
            }
        if not isinstance(value, dict):
            inner = {key: list(value) if isinstance(value, tuple) else value}
        flat |= inner
    return flat
