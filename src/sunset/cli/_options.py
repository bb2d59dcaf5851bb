"""Options that several verbs share."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import cast

from sunset.api.options import Options, settings_of
from sunset.api.running import campaign_of, run_spec_of
from sunset.cli._parser import at_least_one
from sunset.experiments import BenchSpec, RunSpec, Settings
from sunset.perception import DEVICES
from sunset.rmw.backends import BACKENDS, SIMULATED
from sunset.scenarios import suite_names
from sunset.system import DURATION_S, REPAIR, TASKS


def add_campaign_options(
    parser: argparse.ArgumentParser,
    *,
    suite: str,
    managers: str,
    repetitions: int,
    what: str = "runs",
    more: str = "",
) -> None:
    """Add what says which runs a campaign consists of, with these defaults; `more` is said of managing systems."""
    parser.add_argument(
        "--suite",
        default=suite,
        metavar="NAME|DIR",
        help=f"one of {', '.join(suite_names())}, or a folder of scenario files",
    )
    parser.add_argument(
        "--scenarios",
        default=(),
        metavar="A,B,…",
        help="names of some scenarios of the suite ('sunset scenarios list --suite NAME'; default: all)",
    )
    parser.add_argument(
        "--managers",
        default=managers,
        metavar="A,B,…",
        help="managing systems, separated by commas that are not in quotes, each as LABEL=… under a name of your own"
        f"{more}",
    )
    parser.add_argument(
        "--flights",
        default=(),
        metavar="A,B,…",
        help="run every scenario on each of these: panel (eight flights), one of the panel, default, or a bag's path, "
        "also as LABEL=PATH",
    )
    parser.add_argument(
        "--repetitions", type=int, default=repetitions, metavar="N", help=f"{what} a scenario"
    )
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="seed of the first repetition")


def campaign(arguments: argparse.Namespace, *, references: bool, score: bool) -> BenchSpec:
    """Return the campaign that the options of `add_campaign_options` and those of its runs describe."""
    return campaign_of(
        arguments.suite,
        arguments.managers,
        _options(arguments),
        scenarios=arguments.scenarios,
        flights=arguments.flights,
        repetitions=arguments.repetitions,
        seed=arguments.seed,
        references=references,
        score=score,
    )


def run_spec(arguments: argparse.Namespace) -> RunSpec:
    """Return the run that the arguments `scenario`, `manager` and `seed` and the options of runs describe."""
    return run_spec_of(arguments.scenario, arguments.manager, arguments.seed, _options(arguments))


def add_format_options(
    parser: argparse.ArgumentParser, formats: Sequence[str], text: str, default: str | None = "table"
) -> None:
    """Add what says in which of some formats a result is printed."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--format", default=default, choices=formats, help=text)
    group.add_argument(
        "--json", action="store_const", dest="format", const="json", help="same as --format json"
    )


def add_count_option(parser: argparse.ArgumentParser, name: str, text: str) -> None:
    """Add an option that takes a whole number of at least 1."""
    parser.add_argument(name, type=at_least_one, metavar="N", help=text)


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """Add what says which frames are segmented by what, and where."""
    parser.add_argument("--model", default="lite", metavar="NAME|DIR", help="segmentation model")
    parser.add_argument("--bag", type=Path, metavar="PATH", help="a rosbag2 in place of the default flight")
    add_device_option(parser)


def add_device_option(
    parser: argparse.ArgumentParser,
    text: str = "what networks run on; between devices, last digits may differ",
) -> None:
    """Add what says where networks run."""
    parser.add_argument("--device", default="cpu", choices=DEVICES, help=text)


def add_rate_option(parser: argparse.ArgumentParser, text: str) -> None:
    """Add what says how fast `/clock` runs."""
    parser.add_argument("--rate", type=float, default="1", metavar="R", help=text)


def add_flight_options(parser: argparse.ArgumentParser) -> None:
    """Add what says on which flight runs take place, and for how long."""
    add_model_options(parser)
    parser.add_argument(
        "--loop", action="store_true", help="let a bag that is too short begin again at its first frame"
    )
    parser.add_argument(
        "--duration",
        type=float,
        metavar="S",
        help=f"seconds that are measured (default: those of the scenario, {DURATION_S:g} if it names none)",
    )
    parser.add_argument(
        "--no-cache",
        action="store_false",
        dest="cache",
        help="simulation: compute every inference again instead of looking it up",
    )


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add what says how a scenario is run, whatever its managing system."""
    add_flight_options(parser)
    add_limit_option(parser)
    parser.add_argument(
        "--manager-env",
        action="append",
        default=[],
        metavar="NAME",
        help="let the managing system have this variable of your environment, such as the key of a service; no record "
        "has its value (repeatable)",
    )
    parser.add_argument(
        "--task",
        default=REPAIR,
        choices=TASKS,
        help="what the managing system does: repair; or diagnose only, where all adaptations are refused",
    )
    parser.add_argument(
        "--thinking",
        type=float,
        default="0",
        metavar="S",
        help="seconds of the experiment that every decision of the managing system takes",
    )


def add_limit_option(parser: argparse.ArgumentParser) -> None:
    """Add what says how long a managing system may take."""
    parser.add_argument(
        "--manager-limit",
        type=float,
        default="30",
        metavar="S",
        help="processor time that a managing system may take to load, and for each of its callbacks, and a tenth of "
        "the wall time; live, it is all the wall time",
    )


def add_images_option(parser: argparse.ArgumentParser) -> None:
    """Add what says that images are kept."""
    parser.add_argument(
        "--images",
        action="store_true",
        help="keep all images in the record, losslessly: some 100 MB for 20 s",
    )


def add_middleware_options(parser: argparse.ArgumentParser) -> None:
    """Add what says where nodes run."""
    places = "; ".join(f"{backend.name} = {backend.description}" for backend in BACKENDS.values())
    parser.add_argument(
        "--middleware", default=SIMULATED, choices=BACKENDS, help=f"where the nodes run: {places}"
    )
    add_rate_option(parser, "live: seconds of /clock in a second")
    parser.add_argument(
        "--viewer",
        action="append",
        default=[],
        dest="viewers",
        metavar="NODE",
        help="live: full name of a node that only watches and may read everything, such as /rosbag2_recorder "
        "(repeatable)",
    )


def run_settings(arguments: argparse.Namespace) -> Settings:
    """Return the settings that the options of `add_run_options` and `add_middleware_options` describe."""
    return settings_of(_options(arguments))


def _options(arguments: argparse.Namespace) -> Options:
    """Return those of the arguments that are options of the calls."""
    given = {name: value for name, value in vars(arguments).items() if name in Options.__annotations__}
    return cast("Options", given)
