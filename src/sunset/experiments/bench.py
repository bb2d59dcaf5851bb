"""A campaign: every scenario of a suite, every managing system, several repetitions; resumable."""

import hashlib
import inspect
import json
import multiprocessing
import os
import re
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from sunset.errors import InvalidInputError, OutputError, SunsetError
from sunset.experiments.files import make_folder, write_text
from sunset.experiments.resources import Resources
from sunset.experiments.run import RUN_FILE, prepare, run, versions
from sunset.experiments.spec import EXTERNAL, RunSpec, Timing
from sunset.managing import load_manager
from sunset.scenarios import suite
from sunset.seeding import check_seed

__all__ = ["BenchSpec", "Progress", "bench", "plan", "run_folder"]

REFERENCE_SUITES: Final = ("nofault", "degraded")
"""The suites that, without a managing system, give the first two rows of the paper's table."""

_PLAN_FILE: Final = "bench.json"

Progress = Callable[[int, int], None]
"""Called with (runs that are done, runs in all), first with those that an earlier call had done."""


@dataclass(frozen=True, kw_only=True)
class BenchSpec:
    """One campaign.

    Repetition r flies every scenario with seed `seed + r`: all managing systems and all scenarios of one
    repetition see the same stretch of the flight, so that differences are paired.
    """

    suite: str = "paper"
    managers: tuple[str, ...] = ("none", "baseline")
    repetitions: int = 3
    seed: int = 1
    model: str = "lite"
    bag: Path | None = None
    device: str = "cpu"
    timing: Timing = field(default_factory=Timing)
    cache: bool = True
    manager_limit_s: float = 30.0
    middleware: str = "sim"
    speed: float = 1.0

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            InvalidInputError: a number is out of range or a managing system is named twice.
        """
        check_seed(self.seed)
        if self.repetitions < 1:
            raise InvalidInputError(f"There must be at least 1 repetition, got {self.repetitions}.")
        check_seed(self.seed + self.repetitions - 1)
        if not self.managers or len(set(self.managers)) < len(self.managers):
            named = ", ".join(self.managers) or "none at all"
            raise InvalidInputError(f"Each managing system must be named once, got {named}.")


def plan(spec: BenchSpec) -> tuple[RunSpec, ...]:
    """Return all runs of a campaign, reference rows first, in the order in which they are started."""
    groups = [(name, "none") for name in REFERENCE_SUITES]
    groups += [(spec.suite, manager) for manager in spec.managers]
    return tuple(
        RunSpec(
            scenario=scenario,
            suite=name,
            manager=manager,
            seed=spec.seed + repetition,
            model=spec.model,
            bag=spec.bag,
            device=spec.device,
            timing=spec.timing,
            cache=spec.cache,
            manager_limit_s=spec.manager_limit_s,
            middleware=spec.middleware,
            speed=spec.speed,
        )
        # a repetition at a time: runs that share their frames are neighbours, for the inference cache
        for repetition in range(spec.repetitions)
        for name, manager in dict.fromkeys(groups)
        for scenario in suite(name)
    )


def run_folder(out: Path, spec: RunSpec) -> Path:
    """Return where a campaign in `out` keeps this run."""
    parts = (spec.suite, spec.manager, spec.scenario.name.rsplit("/", 1)[-1])
    return out.joinpath("runs", *(_slug(part) for part in parts), f"seed-{spec.seed}")


def bench(spec: BenchSpec, out: Path, *, jobs: int | None = None, progress: Progress | None = None) -> int:
    """Fly a campaign; runs that `out` holds already are not repeated.

    Every run is written to a temporary folder and renamed when it is complete, so that nothing that was
    finished is lost, whatever ends this process, and an interrupted campaign is continued by the same call.

    Args:
        spec: what to run.
        out: the folder of results; it is made if there is none, and must belong to the same campaign.
        jobs: number of worker processes; if None one a core, or one in all for live runs, which need the processor
            in time. It has no influence on any result of the simulation.
        progress: called after every run.

    Returns:
        How many runs were flown by this call.

    Raises:
        InvalidInputError: `out` holds another campaign, or a scenario, model or bag is not usable.
        ManagerError: a managing system cannot be loaded or failed.
        OutputError: `out` cannot be written.
    """
    if jobs is not None and jobs < 1:
        raise InvalidInputError(f"There must be at least 1 job, got {jobs}.")
    runs = plan(spec)
    # rendering a flight and loading a model are done once, before the workers need them
    _claim(out, describe(spec, prepare(runs[0])))
    todo = [one for one in runs if not (run_folder(out, one) / RUN_FILE).is_file()]
    done = len(runs) - len(todo)
    if progress is not None:
        progress(done, len(runs))
    if todo:
        for count in _run_all(todo, out, min(jobs or _jobs(spec), len(todo))):
            if progress is not None:
                progress(done + count, len(runs))
    return len(todo)


def _jobs(spec: BenchSpec) -> int:
    return (spec.middleware == "sim" and os.cpu_count()) or 1


def _run_all(todo: Sequence[RunSpec], out: Path, jobs: int) -> Iterator[int]:
    """Fly all runs; yield how many are finished, after each."""
    if jobs == 1:
        for count, one in enumerate(todo, 1):
            run(one, run_folder(out, one))
            yield count
        return
    waiting = iter(todo)
    pending: set[Future[None]] = set()
    finished = 0
    with _workers(jobs) as pool:
        while True:
            for one in waiting:
                pending.add(pool.submit(_fly, one, run_folder(out, one)))
                if len(pending) >= 2 * jobs:
                    break
            if not pending:
                return
            complete, pending = wait(pending, return_when=FIRST_COMPLETED)
            for future in complete:
                future.result()
                finished += 1
                yield finished


@contextmanager
def _workers(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Give worker processes, which end with the context: at once if it ends with an exception."""
    others = multiprocessing.active_children()
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_set_up_worker)
    try:
        yield pool
    except BaseException as error:
        # nobody waits for runs that are not wanted any more; a run leaves nothing before it is complete
        for worker in multiprocessing.active_children():
            if worker not in others:
                worker.terminate()
        if not isinstance(error, BrokenProcessPool):
            raise
        raise SunsetError(
            "A worker process ended in the middle of a run: it was killed, for instance for want of memory, or the "
            "managing system ended it; finished runs are kept: run the same command again, with fewer --jobs."
        ) from error
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _fly(spec: RunSpec, folder: Path) -> None:
    run(spec, folder)


def _set_up_worker() -> None:
    """Leave interrupts and stdout to the parent, and end when it ends, however it does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stdout = sys.stderr
    threading.Thread(target=_end_with_the_parent, daemon=True).start()


def _end_with_the_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _claim(out: Path, described: dict[str, Any]) -> None:
    """Write the campaign's plan into its folder, or check that it is the one that stands there."""
    file = out / _PLAN_FILE
    if not file.exists():
        make_folder(out)
        if any(path.name != _PLAN_FILE for path in out.iterdir()):
            raise OutputError(f"The folder {out} is not empty and holds no campaign; name a new folder.")
        write_text(file, json.dumps(described, indent=2, sort_keys=True) + "\n")
        return
    try:
        found = dict(json.loads(file.read_text(encoding="utf-8")))
    except (OSError, TypeError, ValueError) as error:
        raise InvalidInputError(
            f"The campaign's plan {file} cannot be read ({error}); name a new folder."
        ) from error
    theirs, ours = _flat(found), _flat(described)
    differing = sorted(key for key in ours | theirs if theirs.get(key) != ours.get(key))
    if differing:
        # a name that differs says more than the checksum that differs with it
        key = min(differing, key=lambda name: "checksum" in name)
        raise InvalidInputError(
            f"The folder {out} holds another campaign: its {key} is {theirs.get(key)!r}, this one's is "
            f"{ours.get(key)!r}; name a new folder."
        )


def _flat(described: dict[str, Any]) -> dict[str, Any]:
    """Return a plan with the entries of its dictionaries as entries of its own: `versions.numpy`."""
    flat: dict[str, Any] = {}
    for key, value in described.items():
        inner = {f"{key}.{name}": one for name, one in value.items()} if isinstance(value, dict) else {}
        flat |= inner or {key: value}
    return flat


def describe(spec: BenchSpec, resources: Resources) -> dict[str, Any]:
    """Return a campaign's plan as it is stored: whatever its results may depend on, by name and by content.

    Raises:
        ManagerError: a managing system cannot be loaded.
    """
    return {
        "bag": str(spec.bag) if spec.bag else None,
        "bag_checksum": resources.bag_checksum,
        "device": resources.segmenter.device,
        "manager_checksums": {name: _source_checksum(name) for name in spec.managers},
        "managers": list(spec.managers),
        "model": spec.model,
        "model_checksum": _checksum(json.dumps(resources.model.card.to_json(), sort_keys=True)),
        "repetitions": spec.repetitions,
        "scenarios_checksum": _checksum(repr([one.scenario for one in plan(spec)])),
        "seed": spec.seed,
        "suite": spec.suite,
        "versions": versions(),
    } | ({} if spec.middleware == "sim" else {"middleware": spec.middleware, "speed": spec.speed})


def _source_checksum(manager: str) -> str:
    """Return the SHA-256 of the file in which a managing system is written; empty if nobody knows."""
    source = None if manager == EXTERNAL else inspect.getsourcefile(load_manager(manager))
    return _checksum(Path(source).read_text(encoding="utf-8")) if source else ""


def _checksum(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _slug(text: str) -> str:
    """Return `text` as a folder's name; distinct texts have distinct names."""
    slug = re.sub(r"[^A-Za-z0-9_+.-]+", "-", text).strip("-.")
    return slug if slug == text else f"{slug}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"
