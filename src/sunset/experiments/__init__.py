"""The composition root: (scenario, seed, managing system, middleware) → one record."""

from sunset.experiments.bench import BenchSpec, bench, plan, run_folder
from sunset.experiments.run import RunResult, prepare, run
from sunset.experiments.spec import DEFAULT_SCENARIO, MIDDLEWARES, RunSpec, Timing

__all__ = [
    "DEFAULT_SCENARIO",
    "MIDDLEWARES",
    "BenchSpec",
    "RunResult",
    "RunSpec",
    "Timing",
    "bench",
    "plan",
    "prepare",
    "run",
    "run_folder",
]
