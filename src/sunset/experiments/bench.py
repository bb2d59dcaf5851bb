"""Campaigns: run by processes or an executor, whole or in shards; resumable."""

import logging
import re
import shutil
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, as_completed
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Final, TypeVar

from msgspec import Struct
from msgspec.structs import asdict

from sunset.errors import InvalidInputError, OutputError, RecordError
from sunset.experiments.campaign import (
    BenchSpec,
    campaign_managers,
    describe_campaign,
    flights_of,
    in_turn,
    plan,
    run_folder,
)
from sunset.experiments.cluster import run_on_workers
from sunset.experiments.resources import prepare_runs, warn_of_walls
from sunset.experiments.run import run_of_campaign
from sunset.experiments.spec import RunSpec
from sunset.files.outputs import make_folder, write_text
from sunset.files.schemas import document_text
from sunset.managing import is_registered
from sunset.processes.workers import Progress, Stages, check_jobs, processors, worker_pool
from sunset.recording import CampaignPlan, read_plan, read_run
from sunset.texts.names import PLAN_FILE, RUN_FILE
from sunset.texts.sentences import counted, listed
from sunset_ros.texts import shown

_log: Final = logging.getLogger(__name__)

_CHANGING: Final = MappingProxyType({"manager_checksums": "managing system", "extensions": "extension"})
"""Key of a campaign's plan that holds checksums of the user's own files → what the files contain."""

_LOCK_FILE: Final = ".lock"
_SHARD: Final = re.compile(r"([1-9][0-9]{0,8})/([1-9][0-9]{0,8})")

_Item = TypeVar("_Item")

_Order = tuple[RunSpec, Path, str | None]
"""A run, its folder, and the checksum that its managing system must have."""


@dataclass(frozen=True, slots=True)
class Shard:
    """Part `number`, from 1 on, of the `count` parts that a campaign's runs are split into."""

    number: int
    count: int

    @classmethod
    def parse(cls, text: object) -> "Shard":
        """Return the shard that the text `I/N` names.

        >>> Shard.parse("2/4")
        Shard(number=2, count=4)
        """
        match = _SHARD.fullmatch(text) if isinstance(text, str) else None
        if match is None or int(match[1]) > int(match[2]):
            raise InvalidInputError(
                f"A shard must be I/N, the I-th of N parts, from 1/N to N/N, got {shown(text)}."
            )
        return cls(int(match[1]), int(match[2]))

    def of(self, items: Sequence[_Item]) -> Sequence[_Item]:
        """Return this part of the items: neighbours; the sizes of parts differ by at most 1.

        >>> [Shard(number, 3).of("abcdefgh") for number in (1, 2, 3)]
        ['ab', 'cde', 'fgh']
        """
        total, count = len(items), self.count
        if count > total:
            raise InvalidInputError(f"A campaign of {counted(total, 'run')} cannot have {count} shards.")
        return items[total * (self.number - 1) // count : total * self.number // count]


def bench(
    spec: BenchSpec,
    out: Path,
    *,
    jobs: int | None = None,
    executor: Executor | None = None,
    shard: Shard | None = None,
    progress: Progress | None = None,
    preparing: Stages | None = None,
) -> int:
    """Run a campaign and return how many runs were done; runs that `out` holds already are not repeated.

    A run's folder appears when it is complete, so that the same call continues an interrupted campaign.

    Args:
        spec: the campaign.
        out: the folder of results; it is made if there is none, and must belong to the same campaign.
        jobs: number of worker processes, which changes no result; if None a process per core, or one for live runs.
        executor: does the runs in place of worker processes; it is not shut down.
        shard: the part of the campaign that is run; all if None.
        progress: called with (finished runs, all runs), first with the runs that `out` held already.
        preparing: called with (stage, frames done, all frames) while flights are rendered and measured.
    """
    check_jobs(jobs)
    if executor is not None:
        _check_executor(executor, spec, jobs)
    runs = plan(spec)
    wanted = in_turn(runs) if shard is None else shard.of(in_turn(runs))
    of_flights = flights_of(runs)
    prepared = list(zip(of_flights, prepare_runs(of_flights, preparing), strict=True))
    if preparing is not None:
        warn_of_walls(runs)
    described = describe_campaign(spec, runs, prepared)
    with locked_campaign(out, shard):
        _claim(out, described)
        known = described.manager_checksums.get
        orders = [(run, run_folder(out, run), known(run.manager_name)) for run in wanted]
        todo = [order for order in orders if not _is_done(order[1])]
        done = len(wanted) - len(todo)
        if executor is None:
            counts = _run_all(todo, min(jobs or (1 if spec.settings.live else processors()), len(todo)))
        else:
            counts = run_on_workers(executor, todo, prepared)
        for count in counts:
            if progress is not None:
                progress(done + count, len(wanted))
    return len(todo)


@contextmanager
def locked_campaign(out: Path, shard: Shard | None = None) -> Iterator[None]:
    """Make a campaign's folder, if there is none, and keep other processes from running the same runs in it."""
    import fcntl  # noqa: PLC0415  not on every system

    make_folder(out)
    beside = (_LOCK_FILE, f".{PLAN_FILE}.")  # another shard may have just begun
    names = [path.name for path in out.iterdir() if not path.name.startswith(beside)]
    if names and not (out / PLAN_FILE).exists():
        raise OutputError(f"The folder {out} is not empty and holds no campaign; name a new folder.")
    locks = {_LOCK_FILE: fcntl.LOCK_SH if shard else fcntl.LOCK_EX}
    if shard:
        locks[f"{_LOCK_FILE}-{shard.number}-of-{shard.count}"] = fcntl.LOCK_EX
    with ExitStack() as files:
        for name, kind in locks.items():
            file = files.enter_context((out / name).open("a+b"))  # network drives need both permissions
            try:
                fcntl.flock(file, kind | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise OutputError(
                    f"The campaign in {out} is being run by another process: wait for its end, or name another folder."
                ) from error
            except OSError as error:
                raise OutputError(
                    f"The file system of {out} has no locks for files ({error.strerror}), without which two processes "
                    "could write to it: name a folder on another one."
                ) from error
        yield


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


def _check_executor(executor: object, spec: BenchSpec, jobs: int | None) -> None:
    """Check that an executor can do the runs of a campaign."""
    if not isinstance(executor, Executor):
        hint = ": it gives one by get_executor()" if hasattr(executor, "get_executor") else ""
        raise InvalidInputError(
            f"The executor must be a concurrent.futures.Executor, got {shown(executor)}{hint}."
        )
    if jobs is not None or spec.settings.live:
        raise InvalidInputError(
            "An executor has workers of its own, and does no live runs: leave out the jobs, or the executor."
        )
    for name, manager in campaign_managers(spec).items():
        if is_registered(manager):
            raise InvalidInputError(
                f"An executor's workers do not have the managing system {name}, which was passed as a class or "
                "function: name it FILE.py:Class or module:Class."
            )


def _run_all(todo: Sequence[_Order], jobs: int) -> Iterator[int]:
    """Do all runs, in this process for a single job; yield how many are finished, first 0 and then after each."""
    yield 0
    if jobs <= 1:
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
    """Write the campaign's plan into its folder, or check that the folder has the same plan."""
    file = out / PLAN_FILE
    if not file.exists():
        write_text(file, document_text(plan))
        return
    theirs, ours = _flat(read_plan(out)), _flat(plan)
    differing = sorted(key for key in ours | theirs if theirs.get(key) != ours.get(key))
    if differing:
        # a name that differs says more than the checksum or the number that differs with it
        key = min(differing, key=lambda name: (name == "runs", "checksum" in name or "flight_facts" in name))
        raise InvalidInputError(_difference_text(out, key, theirs, ours))
    for name, manager in campaign_managers(plan).items():
        if is_registered(manager) and not plan.manager_checksums[name]:
            raise InvalidInputError(
                f"The campaign in {out} cannot be continued: nothing says whether its managing system {name} "
                f"is the same as then: pass a class or function of a file, or name a new folder."
            )


def _difference_text(out: Path, key: str, theirs: dict[str, object], ours: dict[str, object]) -> str:
    kind, _, name = key.partition(".")
    if kind in _CHANGING and key in ours and key in theirs:
        return (
            f"The {_CHANGING[kind]} {name} has changed since the campaign in {out} was begun, and its runs are of the "
            "old one; name a new folder."
        )
    if kind == "extensions":
        word = "with" if key in theirs else "without"
        return (
            f"The campaign in {out} was begun {word} the extension {name}; name the same extensions, or a new "
            "folder."
        )
    if key == "versions.sunset":
        return (
            f"The campaign in {out} was begun with SUNSET {theirs.get(key)}, and this is {ours[key]}, whose code "
            "differs: go on with that one, or name a new folder."
        )
    is_plural = key == kind and key.endswith("s") and not (key.endswith("_s") or isinstance(ours[key], bool))
    verb = "are" if is_plural else "is"
    return (
        f"The folder {out} holds another campaign: its {key} {verb} {_entry_text(theirs.get(key))}, this one's {verb} "
        f"{_entry_text(ours.get(key))}; name a new folder."
    )


def _entry_text(value: object) -> str:
    if isinstance(value, list):
        return listed([*map(repr, value)]) if value else "not given"
    return repr(value)


def _flat(value: object, key: str = "") -> dict[str, object]:
    """Return a plan as a flat dictionary, with keys such as `versions.numpy` for the entries of its dictionaries."""
    if isinstance(value, Struct):
        value = asdict(value)
    if isinstance(value, dict):
        parts = (_flat(entry, f"{key}.{name}" if key else name) for name, entry in value.items())
        return {name: entry for part in parts for name, entry in part.items()}
    return {key: list(value) if isinstance(value, tuple) else value}
