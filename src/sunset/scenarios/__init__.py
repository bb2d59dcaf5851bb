"""Scenarios: the faults that a run injects, and the suites."""

from sunset.scenarios.loading import generate as generate
from sunset.scenarios.loading import load_scenario as load_scenario
from sunset.scenarios.loading import load_suite as load_suite
from sunset.scenarios.loading import scenario_names as scenario_names
from sunset.scenarios.loading import split_hash as split_hash
from sunset.scenarios.loading import suite as suite
from sunset.scenarios.loading import suite_names as suite_names
from sunset.scenarios.loading import suite_of as suite_of
from sunset.scenarios.loading import suite_size as suite_size
from sunset.scenarios.reading import parse_scenario as parse_scenario
from sunset.scenarios.schema import After as After
from sunset.scenarios.schema import Profile as Profile
from sunset.scenarios.schema import Scenario as Scenario
from sunset.scenarios.schema import ScenarioFault as ScenarioFault
from sunset.scenarios.schema import onsets as onsets
from sunset.scenarios.schema import problems as problems
from sunset.scenarios.schema import with_strengths as with_strengths
from sunset.scenarios.splits import SPLIT_FILE as SPLIT_FILE
from sunset.scenarios.splits import SPLITS as SPLITS
from sunset.scenarios.splits import SplitDescription as SplitDescription
from sunset.scenarios.splits import SplitSpec as SplitSpec
from sunset.scenarios.splits import check_split as check_split
from sunset.scenarios.splits import draw_split as draw_split
from sunset.scenarios.splits import read_salt as read_salt
from sunset.scenarios.splits import scenario_files as scenario_files
from sunset.scenarios.splits import write_split as write_split
