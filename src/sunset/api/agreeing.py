"""Agreements: the same seeds in the simulation and live."""

from dataclasses import replace
from pathlib import Path
from typing import Unpack

from sunset import experiments
from sunset.api.options import Options, as_path, check_progress, extended, whole_of
from sunset.api.running import Flights, Managers, Names, campaign_of
from sunset.errors import InvalidInputError
from sunset.evaluation import Agreement, compare
from sunset.experiments import BenchSpec
from sunset.processes.workers import Progress
from sunset.rmw.backends import LIVE, SIMULATED, live_middleware


def agree(
    suite: str | Path = "artifact",
    managers: Managers = ("baseline",),
    *,
    out: str | Path,
    scenarios: Names = (),
    flights: Flights = (),
    repetitions: int = 1,
    seed: int = 1,
    jobs: int | None = None,
    progress: Progress | None = None,
    **options: Unpack[Options],
) -> list[Agreement]:
    """Run the same seeds in the simulation and live, and return how well they agree, as `sunset agree` does.

    Args:
        suite: as of `bench`.
        managers: as of `bench`; by name, since live they are processes of their own.
        out: the folder of the results.
        scenarios: as of `bench`.
        flights: as of `bench`.
        repetitions: pairs a scenario.
        seed: of the first repetition.
        jobs: worker processes of the simulation; one a core if None. Live runs take place one at a time.
        progress: called with (runs that are done, runs in all), those of the simulation first.
        **options: as `sunset.Options`; the rate is that of the live runs.

    Raises:
        SunsetError: as `bench`.
    """
    check_progress(progress)
    folder = as_path(out, "folder of the results")
    if "middleware" in options:
        raise InvalidInputError("An agreement is of the simulation with live runs: leave the middleware out.")
    with extended(options.get("extensions", ())):
        options["middleware"] = LIVE
        live = campaign_of(
            suite,
            managers,
            options,
            scenarios=scenarios,
            flights=flights,
            repetitions=repetitions,
            seed=seed,
            references=False,
            score=False,
        )
        done = 0

        def update(count: int, total: int) -> None:
            if progress is not None:
                progress(done + count, 2 * total)

        for name, spec, workers in paired_campaigns(live, whole_of(jobs)):
            experiments.bench(spec, folder / name, jobs=workers, progress=update)
            done = len(experiments.plan(spec))
        return compare(folder / "sim", folder / "live")


def paired_campaigns(
    live: BenchSpec, jobs: int | None
) -> tuple[tuple[str, BenchSpec, int | None], tuple[str, BenchSpec, int | None]]:
    """Return the simulated and the live campaign of an agreement: its folder's name, what it is, and its processes.

    Raises:
        SunsetError: one of them cannot be run, which is said before either is.
    """
    live_middleware()
    sim = replace(live, settings=replace(live.settings, middleware=SIMULATED, speed=1.0))
    for spec in (live, sim):
        experiments.plan(spec)
    return ("sim", sim, jobs), ("live", live, 1)
