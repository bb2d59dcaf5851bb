"""Scenarios: the faults that a run injects, and the suites."""

from sunset.scenarios.courses import onsets, problems
from sunset.scenarios.fault import After, Profile, ScenarioFault
from sunset.scenarios.loading import (
    generate,
    load_scenario,
    load_suite,
    scenario_names,
    split_hash,
    suite,
    suite_names,
    suite_of,
)
from sunset.scenarios.reading import parse_scenario
from sunset.scenarios.schema import Scenario, with_strengths
from sunset.scenarios.split_files import (
    SPLIT_FILE,
    SplitDescription,
    check_split,
    read_salt,
    read_split,
    scenario_files,
    write_split,
)
from sunset.scenarios.splits import SPLITS, SplitSpec, draw_split

__all__ = [
    "SPLITS",
    "SPLIT_FILE",
    "After",
    "Profile",
    "Scenario",
    "ScenarioFault",
    "SplitDescription",
    "SplitSpec",
    "check_split",
    "draw_split",
    "generate",
    "load_scenario",
    "load_suite",
    "onsets",
    "parse_scenario",
    "problems",
    "read_salt",
    "read_split",
    "scenario_files",
    "scenario_names",
    "split_hash",
    "suite",
    "suite_names",
    "suite_of",
    "with_strengths",
    "write_split",
]
