"""The composition root: (scenario, seed, managing system, middleware) → one record."""

from sunset.experiments.again import play_back, run_again
from sunset.experiments.bench import bench, count_runs, failing_managers
from sunset.experiments.campaign import (
    BenchSpec,
    added_managers,
    campaign_managers,
    flights_of,
    in_turn,
    plan,
    run_folder,
    scenarios_checksum,
)
from sunset.experiments.checking import ManagerCheck, check_manager
from sunset.experiments.cluster import connected_scheduler
from sunset.experiments.last import keep_last_run, last_run
from sunset.experiments.manager import manager_checksum
from sunset.experiments.resources import (
    Resources,
    flight_name,
    inference_file,
    model_checksum,
    prepare,
    prepare_all,
)
from sunset.experiments.run import run
from sunset.experiments.shards import Shard
from sunset.experiments.spec import (
    CHECK_SCENARIO,
    DEFAULT_SCENARIO,
    MIDDLEWARES,
    RunSpec,
    RunTiming,
    Settings,
    Timing,
)
from sunset.experiments.stored_faults import scenario_of

__all__ = [
    "CHECK_SCENARIO",
    "DEFAULT_SCENARIO",
    "MIDDLEWARES",
    "BenchSpec",
    "ManagerCheck",
    "Resources",
    "RunSpec",
    "RunTiming",
    "Settings",
    "Shard",
    "Timing",
    "added_managers",
    "bench",
    "campaign_managers",
    "check_manager",
    "connected_scheduler",
    "count_runs",
    "failing_managers",
    "flight_name",
    "flights_of",
    "in_turn",
    "inference_file",
    "keep_last_run",
    "last_run",
    "manager_checksum",
    "model_checksum",
    "plan",
    "play_back",
    "prepare",
    "prepare_all",
    "run",
    "run_again",
    "run_folder",
    "scenario_of",
    "scenarios_checksum",
]
