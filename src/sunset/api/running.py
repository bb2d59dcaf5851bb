"""Runs and campaigns: flown, stored, opened again, compared."""

import tempfile
from collections.abc import Collection, Mapping
from concurrent.futures import Executor
from pathlib import Path
from typing import TypeAlias, Unpack

from sunset import experiments
from sunset.api.options import (
    Extensions,
    Manager,
    Options,
    as_path,
    check_flags,
    check_progress,
    chosen_flights,
    chosen_scenarios,
    extended,
    manager_name,
    manager_names,
    names_of,
    scenario_of,
    settings_of,
    whole_of,
)
from sunset.api.planning import CampaignForecast, forecast
from sunset.api.results import Results
from sunset.api.viewing import Run
from sunset.errors import ManagerError, RecordError
from sunset.evaluation import load_results, render_report
from sunset.experiments import (
    CHECK_SCENARIO,
    DEFAULT_SCENARIO,
    BenchSpec,
    ManagerCheck,
    RunSpec,
    Settings,
    Shard,
)
from sunset.processes.workers import Progress
from sunset.published import paper_report
from sunset.recording import RUN_FILE, read_stored_run
from sunset.scenarios import Scenario, generate
from sunset.texts import shown

_Scenario: TypeAlias = str | Path | Scenario
Managers: TypeAlias = Manager | Mapping[str, Manager] | list[Manager] | tuple[Manager, ...]
Names: TypeAlias = str | list[str] | tuple[str, ...]
Flights: TypeAlias = str | Path | list[str | Path] | tuple[str | Path, ...]


def run(
    scenario: _Scenario = DEFAULT_SCENARIO,
    manager: Manager = "baseline",
    *,
    seed: int = 1,
    out: str | Path | None = None,
    **options: Unpack[Options],
) -> Run:
    """Run one scenario and measure the adaptation, as `sunset run` does.

    Args:
        scenario: a scenario's name, a YAML file, faults joined by `+`, or what `load_scenario` returned.
        manager: the managing system: a name, `FILE.py:CLASS`, `MODULE:CLASS`, `exec:COMMAND`, a class, or a function
            that makes one. It runs in a process of its own, which is forked from this one, so that a class of a
            notebook will do.
        seed: a whole number in [0, 2³² − 1]. The same seed gives the same record.
        out: keep the record in this new folder; it is not kept if None.
        **options: those of `sunset.Options`: `model`, `bag`, `loop`, `device`, `duration`, `cache`, `images`,
            `manager_limit`, `manager_env`, `task`, `thinking`, `middleware`, `rate`, `viewers`, `extensions`.

    Raises:
        InvalidInputError: an argument is not usable.
        ManagerError: the managing system could not be loaded, or kept the system from coming up.
        OutputError: the record cannot be written.
    """
    extensions = options.get("extensions", ())
    with extended(extensions):
        spec = run_spec_of(scenario, manager, seed, options)
        if out is not None:
            return Run.of(experiments.run(spec, as_path(out, "folder of the record")), extensions=extensions)
        with tempfile.TemporaryDirectory(prefix="sunset-") as folder:
            return Run.of(experiments.run(spec, Path(folder) / "run"), extensions=extensions, is_kept=False)


def bench(
    suite: str | Path = "paper",
    managers: Managers = ("none", "baseline"),
    *,
    out: str | Path,
    scenarios: Names = (),
    flights: Flights = (),
    references: bool = True,
    score: bool = True,
    repetitions: int = 3,
    seed: int = 1,
    jobs: int | None = None,
    executor: Executor | None = None,
    shard: str | None = None,
    progress: Progress | None = None,
    **options: Unpack[Options],
) -> Results:
    """Run managing systems over a suite, as `sunset bench` does; runs that `out` holds already are not repeated.

    Args:
        suite: a suite's name, or a folder of scenario files.
        managers: managing systems, as of `run`: a list, or a dictionary of them by their labels in tables.
        out: the folder of the results.
        scenarios: some scenarios of the suite; all if empty.
        flights: what every scenario is run on: `panel`, names of its flights, `default`, or bags, also as `LABEL=PATH`;
            if empty, each is run on its own flight.
        references: whether the paper's two reference rows are run too.
        score: whether `none` and `oracle` are run too, which scores are measured between.
        repetitions: runs a scenario, at least 1.
        seed: of the first repetition.
        jobs: worker processes; one a core if None. They change no result of the simulation.
        executor: does the runs in the place of worker processes: any of `concurrent.futures`, such as one of dask's or
            mpi4py's, whose workers may be on other computers. It changes no result either, and is not shut down.
        shard: do a part of the campaign only, as `I/N`, the I-th of N.
        progress: called with (runs that are done, runs in all).
        **options: those of `sunset.Options`: `model`, `bag`, `loop`, `device`, `duration`, `cache`, `images`,
            `manager_limit`, `manager_env`, `task`, `thinking`, `middleware`, `rate`, `viewers`, `extensions`.

    Raises:
        InvalidInputError: an argument is not usable, `out` holds another campaign, or a worker of the executor has not
            what the runs need.
        ManagerError: a managing system cannot be loaded.
        OutputError: `out` cannot be written, or another process runs its campaign.
        SunsetError: a worker was killed, or the executor has failed; what was finished is kept.
    """
    check_progress(progress)
    part = None if shard is None else Shard.parse(shard)
    with extended(options.get("extensions", ())):
        spec = campaign_of(
            suite,
            managers,
            options,
            scenarios=scenarios,
            flights=flights,
            repetitions=repetitions,
            seed=seed,
            references=references,
            score=score,
        )
        folder = as_path(out, "folder of the results")
        experiments.bench(spec, folder, jobs=whole_of(jobs), executor=executor, shard=part, progress=progress)
        return Results(folder, load_results(folder))


def plan_bench(
    suite: str | Path = "paper",
    managers: Managers = ("none", "baseline"),
    *,
    like: str | Path | None = None,
    scenarios: Names = (),
    flights: Flights = (),
    references: bool = True,
    score: bool = True,
    repetitions: int = 3,
    seed: int = 1,
    **options: Unpack[Options],
) -> CampaignForecast:
    """Return what a campaign would be, as `sunset bench --plan` prints it.

    Args:
        suite: as of `bench`, like all that is not described here.
        managers: as of `bench`.
        like: the folder of an earlier campaign, from which time and variances are taken. Without it, two trial runs
            are done and timed.
        scenarios: as of `bench`.
        flights: as of `bench`.
        references: as of `bench`.
        score: as of `bench`.
        repetitions: as of `bench`.
        seed: as of `bench`.
        **options: as of `bench`.

    Raises:
        InvalidInputError: an argument is not usable.
        RecordError: there is no such earlier campaign, or it is damaged.
    """
    with extended(options.get("extensions", ())):
        spec = campaign_of(
            suite,
            managers,
            options,
            scenarios=scenarios,
            flights=flights,
            repetitions=repetitions,
            seed=seed,
            references=references,
            score=score,
        )
        return forecast(spec, None if like is None else as_path(like, "folder of an earlier campaign"))


def load(path: str | Path, *, recompute: bool = False, extensions: Extensions = ()) -> Run | Results:
    """Open stored runs: of the folder of one run, that run; of one with several, their results.

    Args:
        path: what `run` or `bench`, or the command line, has written.
        recompute: compute the figures of several runs from the recorded messages instead of reading the stored ones.
        extensions: those of the managed system that the runs were flown with, where figures are computed.

    Raises:
        RecordError: there is no such folder, no run in it, or one that is damaged or of another version.
    """
    folder = as_path(path, "folder of stored runs")
    if folder.is_file():
        raise RecordError(f"A record is a folder, got the file {folder}: name the folder that it is in.")
    check_flags(recompute=recompute)
    with extended(extensions):
        if (folder / RUN_FILE).exists():
            return Run.of(read_stored_run(folder), extensions=extensions)
        return Results(folder, load_results(folder, again=recompute))


def report(
    path: str | Path,
    form: str | None = None,
    *,
    every: bool = False,
    recompute: bool = False,
    paper: bool = False,
    extensions: Extensions = (),
) -> str:
    """Return the report of stored runs, as `sunset report` prints it; with extensions as `load`.

    Args:
        path: as of `load`; with `paper`, also a log of the published exemplar, or a folder of logs.
        form: `table`, `latex`, `csv`, `json` or `html`; if it is None, `table`, but of the folder of one run its time
            line.
        every: whether a table or LaTeX has every figure, and not the first page only.
        recompute: as of `load`; of a table.
        paper: whether to return the paper's five figures by the published evaluation script instead, as `table`,
            `latex`, `html` or `json`.
        extensions: as of `load`.

    Raises:
        RecordError: as `load`.
        InvalidInputError: there is no such format.
    """
    folder = as_path(path, "folder of stored runs")
    check_flags(every=every, recompute=recompute, paper=paper)
    with extended(extensions):
        if paper:
            return paper_report(folder, "table" if form is None else form)
        if form is None and not (every or recompute) and (folder / RUN_FILE).is_file():
            return f"{read_stored_run(folder)}\n"
        return render_report(folder, "table" if form is None else form, every=every, recompute=recompute)


def check_manager(
    manager: Manager,
    scenario: _Scenario = CHECK_SCENARIO,
    *,
    seed: int = 1,
    progress: Progress | None = None,
    **options: Unpack[Options],
) -> ManagerCheck:
    """Return whether a managing system runs, keeps the rules and is deterministic, as `sunset managers check` does.

    Args:
        manager: as of `run`.
        scenario: as of `run`.
        seed: of both runs.
        progress: called with (runs that are done, runs in all).
        **options: those of `sunset.Options`: `model`, `bag`, `loop`, `device`, `duration`, `cache`, `images`,
            `manager_limit`, `manager_env`, `task`, `thinking`, `middleware`, `rate`, `viewers`, `extensions`.

    Raises:
        SunsetError: as `run`.
    """
    check_progress(progress)
    with extended(options.get("extensions", ())):
        spec = run_spec_of(scenario, manager, seed, options)
        return experiments.check_manager(spec, progress=progress)


def make_scenario(*faults: str, name: str = "") -> Scenario:
    """Make a scenario of faults, each as `FAULT` or `FAULT=STRENGTH`, as `sunset scenarios generate` does.

    Raises:
        ScenarioError: there is no such fault, or no such strength.
    """
    return generate(names_of(list(faults), "faults"), name=name)


def run_spec_of(scenario: _Scenario, manager: Manager, seed: int, options: Options) -> RunSpec:
    """Return the run that arguments as those of `run` describe.

    Raises:
        InvalidInputError: one of them is not usable.
        ManagerError: the managing system is none, or is not a name although the run is live.
    """
    settings = settings_of(options)
    _check_named(manager, settings)
    return RunSpec(
        scenario=scenario_of(scenario),
        manager=manager_name(manager),
        seed=whole_of(seed),
        settings=settings,
    )


def campaign_of(
    suite: str | Path,
    managers: Managers,
    options: Options,
    *,
    scenarios: Names,
    flights: Flights,
    repetitions: int,
    seed: int,
    references: bool,
    score: bool,
) -> BenchSpec:
    """Return the campaign that arguments as those of `bench` describe.

    Raises:
        InvalidInputError: one of them is not usable.
    """
    settings = settings_of(options)
    _check_named(managers, settings)
    return BenchSpec(
        suite=str(suite) if isinstance(suite, Path) else suite,
        scenarios=chosen_scenarios(scenarios),
        references=references,
        score=score,
        managers=manager_names(managers),
        flights=chosen_flights(flights),
        repetitions=whole_of(repetitions),
        seed=whole_of(seed),
        settings=settings,
    )


def _check_named(managers: Managers, settings: Settings) -> None:
    """Check that managing systems of live runs are names, since each is a process that this one does not fork.

    Raises:
        ManagerError: one is a class or a function.
    """
    listed = managers.values() if isinstance(managers, Mapping) else managers
    listed = listed if isinstance(listed, Collection) and not isinstance(listed, str) else [listed]
    for manager in listed:
        if settings.live and callable(manager):
            raise ManagerError(
                f"A class or function cannot manage a live run, got {shown(manager)}: live, name it FILE.py:Class or "
                "module:Class."
            )
