"""The composition root: (scenario, seed, managing system, settings) → a record."""

from sunset.experiments.again import play_back, run_again
from sunset.experiments.bench import Shard, bench
from sunset.experiments.campaign import (
    BenchSpec,
    added_managers,
    campaign_managers,
    in_turn,
    plan,
    run_folder,
)
from sunset.experiments.checking import ManagerCheck, check_manager
from sunset.experiments.cluster import connected_scheduler
from sunset.experiments.manager import manager_checksum
from sunset.experiments.resources import (
    inference_file,
    missing_networks,
    model_checksum,
    prepare,
    prepare_runs,
    warn_of_walls,
)
from sunset.experiments.run import keep_last_run, last_run, run
from sunset.experiments.settings import OPTIONS, Options, RunTiming, Settings, Timing
from sunset.experiments.spec import CHECK_SCENARIO, DEFAULT_SCENARIO, RunSpec, scenario_of
from sunset.recording import count_runs

__all__ = [
    "CHECK_SCENARIO",
    "DEFAULT_SCENARIO",
    "OPTIONS",
    "BenchSpec",
    "ManagerCheck",
    "Options",
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
    "in_turn",
    "inference_file",
    "keep_last_run",
    "last_run",
    "manager_checksum",
    "missing_networks",
    "model_checksum",
    "plan",
    "play_back",
    "prepare",
    "prepare_runs",
    "run",
    "run_again",
    "run_folder",
    "scenario_of",
    "warn_of_walls",
]
