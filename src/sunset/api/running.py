"""Runs and campaigns: executed, planned, checked and compared."""

import tempfile
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Unpack

from sunset import experiments
from sunset.api.arguments import as_path, extended, optional_path, whole_of
from sunset.api.options import CampaignOptions, Manager, Managers, campaign_of, run_spec_of
from sunset.api.planning import CampaignForecast, count_runs, forecast
from sunset.api.results import Results
from sunset.api.viewing import Run
from sunset.errors import InvalidInputError
from sunset.evaluation.agreement import Agreement, compare
from sunset.evaluation.results import load_results
from sunset.experiments import (
    CHECK_SCENARIO,
    DEFAULT_SCENARIO,
    BenchSpec,
    ManagerCheck,
    Options,
    Shard,
    connected_scheduler,
    keep_last_run,
    last_run,
)
from sunset.processes.workers import Progress, Stages
from sunset.scenarios import Scenario
from sunset.texts.sentences import counted
from sunset_ros.rmw.backends import LIVE, SIMULATED, live_middleware

__all__ = [
    "CHECK_SCENARIO",
    "DEFAULT_SCENARIO",
    "added_runs",
    "agree",
    "bench",
    "check_manager",
    "connected_scheduler",
    "keep_last_run",
    "last_run",
    "plan_bench",
    "run",
]


def run(
    scenario: str | Path | Scenario = DEFAULT_SCENARIO,
    manager: Manager = "baseline",
    *,
    seed: int = 1,
    out: str | Path | None = None,
    log: bool = False,
    **options: Unpack[Options],
) -> Run:
    """Run a scenario and measure the adaptation, as `sunset run` does.

    Args:
        scenario: a scenario's name, a YAML file, faults joined by `+`, or a scenario of `load_scenario`.
        manager: the managing system: a name, `FILE.py:CLASS`, `MODULE:CLASS`, `exec:COMMAND`, a class, or a function
            that makes it. It runs in a process of its own, forked from this process, so that a class of a
            notebook will do.
        seed: a whole number in [0, 2³² − 1]. The same seed gives the same record.
        out: keep the record in this new folder; it is not kept if None.
        log: whether messages that the managing system logs are printed on stderr, too.
        **options: as in `sunset.Options`.

    Raises:
        InvalidInputError: an argument is not usable.
        ManagerError: the managing system could not be loaded, or kept the system from coming up.
        OutputError: the record cannot be written.
    """
    extensions = options.get("extensions", ())
    with extended(extensions), tempfile.TemporaryDirectory(prefix="sunset-") as temporary:
        spec = run_spec_of(scenario, manager, seed, options)
        folder = Path(temporary, "run") if out is None else as_path(out, "folder of the record")
        stored = experiments.run(spec, folder, log=bool(log), preparing=options.get("preparing"))
        return Run.of(stored, extensions=extensions, is_kept=out is not None)


def bench(
    suite: str | Path = "paper",
    managers: Managers = ("none", "baseline"),
    *,
    out: str | Path,
    jobs: int | None = None,
    executor: Executor | None = None,
    shard: str | None = None,
    progress: Progress | None = None,
    **options: Unpack[CampaignOptions],
) -> Results:
    """Run managing systems over a suite, as `sunset bench` does; runs that `out` holds already are not repeated.

    Args:
        suite: a suite's name, or a folder of scenario files.
        managers: managing systems, as in `run`: a list, or a dictionary of them by their labels in tables.
        out: the folder of the results.
        jobs: worker processes, which change no result; a process per core if None.
        executor: any executor of `concurrent.futures`, which does the runs in place of worker processes.
        shard: do a part of the campaign only, as `I/N`, the I-th of N.
        progress: called with (finished runs, all runs).
        **options: as in `sunset.CampaignOptions` and `sunset.Options`.

    Raises:
        InvalidInputError: an argument is not usable, `out` holds another campaign, or a worker lacks a resource.
        ManagerError: a managing system cannot be loaded.
        SunsetError: `out` cannot be written, another process runs its campaign, a worker was killed, or the executor
            has failed; finished runs are kept.
    """
    with extended(options.get("extensions", ())):
        spec = campaign_of(suite, managers, options)
        folder = as_path(out, "folder of the results")
        experiments.bench(
            spec,
            folder,
            jobs=whole_of(jobs),
            executor=executor,
            shard=None if shard is None else Shard.parse(shard),
            progress=progress,
            preparing=options.get("preparing"),
        )
        return Results(folder, load_results(folder))


def plan_bench(
    suite: str | Path = "paper",
    managers: Managers = ("none", "baseline"),
    *,
    like: str | Path | None = None,
    jobs: int | None = None,
    **options: Unpack[CampaignOptions],
) -> CampaignForecast:
    """Return the number of runs of a campaign, their duration and their power, as `sunset bench --plan` prints them.

    Args:
        suite: as in `bench`, like `managers` and the options.
        managers: as in `bench`.
        like: the folder of an earlier campaign, from which time and variances are taken. Without it, two trial runs
            are done and timed.
        jobs: worker processes of the campaign; a process per core if None.
        **options: as in `bench`.

    Raises:
        InvalidInputError: an argument is not usable.
        RecordError: the earlier campaign is missing or damaged.
    """
    with extended(options.get("extensions", ())):
        spec = campaign_of(suite, managers, options)
        earlier = optional_path(like, "folder of an earlier campaign")
        return forecast(spec, earlier, jobs=whole_of(jobs), preparing=options.get("preparing"))


def added_runs(suite: str | Path, managers: Managers, **options: Unpack[CampaignOptions]) -> list[str]:
    """Return in words how many runs are added to the runs of the named managing systems."""
    added = list(count_runs(campaign_of(suite, managers, options)).items())[1:]
    return [f"{counted(number, 'run')} of {name}" for name, number in added]


def check_manager(
    manager: Manager,
    scenario: str | Path | Scenario = CHECK_SCENARIO,
    *,
    seed: int = 1,
    progress: Progress | None = None,
    **options: Unpack[Options],
) -> ManagerCheck:
    """Return whether a managing system runs, keeps the rules and is deterministic, as `sunset managers check` does.

    Args:
        manager: as in `run`.
        scenario: as in `run`.
        seed: of both runs.
        progress: called with (finished runs, all runs).
        **options: as in `sunset.Options`.

    Raises:
        SunsetError: as `run`.
    """
    with extended(options.get("extensions", ())):
        spec = run_spec_of(scenario, manager, seed, options)
        return experiments.check_manager(spec, progress=progress, preparing=options.get("preparing"))


def agree(
    suite: str | Path = "artifact",
    managers: Managers = ("baseline",),
    *,
    out: str | Path,
    jobs: int | None = None,
    stored: bool = False,
    progress: Progress | None = None,
    **options: Unpack[CampaignOptions],
) -> list[Agreement]:
    """Run the same seeds in the simulation and live, and return how well they agree, as `sunset agree` does.

    Args:
        suite: as in `bench`.
        managers: as in `bench`; by name, since live they are processes of their own.
        out: the folder of the results.
        jobs: worker processes of the simulation; a process per core if None. Live runs take turns.
        stored: whether to run nothing and compare the runs in the folder.
        progress: called with (finished runs, all runs), first for the simulation.
        **options: as in `bench`; `rate` is for the live runs, and `repetitions` is 1 if left out.

    Raises:
        SunsetError: as `bench`.
    """
    folder = as_path(out, "folder of the results")
    if "middleware" in options:
        raise InvalidInputError("An agreement is of the simulation with live runs: leave the middleware out.")
    with extended(options.get("extensions", ())):
        if not stored:
            fixed: CampaignOptions = {"middleware": LIVE, "references": False, "score": False}
            live = campaign_of(suite, managers, {"repetitions": 1, **options, **fixed})
            live_middleware()
            _run_pairs(live, folder, whole_of(jobs), progress, options.get("preparing"))
        return compare(folder / "sim", folder / "live", progress=progress if stored else None)


def _run_pairs(
    live: BenchSpec, folder: Path, jobs: int | None, progress: Progress | None, preparing: Stages | None
) -> None:
    sim = replace(live, settings=replace(live.settings, middleware=SIMULATED, speed=1.0))
    pairs = min(len(experiments.plan(spec)) for spec in (live, sim))  # an error in either ends both
    done = 0

    def update(count: int, _: int) -> None:
        if progress is not None:
            progress(done + count, 2 * pairs)

    for name, spec, workers in (("sim", sim, jobs), ("live", live, 1)):
        experiments.bench(spec, folder / name, jobs=workers, progress=update, preparing=preparing)
        done += pairs
