"""Options that several verbs share."""

import argparse
from pathlib import Path

from sunset.experiments import BenchSpec, Settings, Timing
from sunset.perception import DEVICES
from sunset.rmw.backends import BACKENDS, SIMULATED
from sunset.scenarios import suite_names
from sunset.system import DURATION_S


def names(text: str) -> tuple[str, ...]:
    """Parse names that are separated by commas."""
    return tuple(name.strip() for name in text.split(",") if name.strip())


def add_campaign_options(
    parser: argparse.ArgumentParser,
    *,
    suite: str,
    managers: str,
    repetitions: int,
    what: str = "runs",
    more: str = "",
) -> None:
    """Add what says which runs a campaign consists of, with these defaults.

    Args:
        parser: gets the options.
        suite: the default suite.
        managers: the default managing systems, separated by commas.
        repetitions: how many there are by default.
        what: is repeated.
        more: what else is said of managing systems.
    """
    parser.add_argument(
        "--suite",
        default=suite,
        metavar="NAME|DIR",
        help=f"one of {', '.join(suite_names())}, or a folder of scenario files (default: {suite})",
    )
    parser.add_argument(
        "--scenarios", default="", metavar="A,B,…", help="some scenarios of the suite (default: all)"
    )
    parser.add_argument(
        "--managers",
        default=managers,
        metavar="A,B,…",
        help=f"managing systems, separated by commas, each as LABEL=… under a name of your own{more} "
        f"(default: {managers})",
    )
    parser.add_argument(
        "--repetitions",
        type=int,
        default=repetitions,
        metavar="N",
        help=f"{what} a scenario (default: {repetitions})",
    )
    parser.add_argument(
        "--seed", type=int, default=1, metavar="N", help="seed of the first repetition (default: 1)"
    )


def campaign(arguments: argparse.Namespace, settings: Settings, *, references: bool) -> BenchSpec:
    """Return the campaign that the options of `add_campaign_options` describe."""
    return BenchSpec(
        suite=arguments.suite,
        scenarios=names(arguments.scenarios),
        references=references,
        managers=names(arguments.managers),
        repetitions=arguments.repetitions,
        seed=arguments.seed,
        settings=settings,
    )


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """Add what says which frames are segmented by what, and where."""
    parser.add_argument(
        "--model", default="lite", metavar="NAME|DIR", help="segmentation model (default: lite)"
    )
    parser.add_argument("--bag", metavar="PATH", help="a rosbag2 to fly instead of the default flight")
    add_device_option(parser)


def add_device_option(parser: argparse.ArgumentParser) -> None:
    """Add what says where networks run."""
    parser.add_argument(
        "--device",
        default="cpu",
        choices=DEVICES,
        help="what networks run on; between devices, last digits may differ (default: cpu)",
    )


def bag_path(arguments: argparse.Namespace) -> Path | None:
    """Return the bag that the options of `add_model_options` name."""
    return None if arguments.bag is None else Path(arguments.bag)


def add_flight_options(parser: argparse.ArgumentParser) -> None:
    """Add what says how a mission is flown, whoever manages it."""
    add_model_options(parser)
    parser.add_argument(
        "--loop", action="store_true", help="let a bag that is too short begin again at its first frame"
    )
    parser.add_argument(
        "--duration",
        type=float,
        default=DURATION_S,
        metavar="S",
        help=f"seconds that are measured (default: {DURATION_S:g})",
    )
    parser.add_argument(
        "--manager-limit",
        type=float,
        default=30.0,
        metavar="S",
        help="simulation: wall time that one callback of the managing system may take (default: 30)",
    )
    parser.add_argument(
        "--no-cache",
        action="store_true",
        help="simulation: compute every inference again instead of looking it up",
    )


def add_middleware_options(parser: argparse.ArgumentParser) -> None:
    """Add what says where nodes run."""
    places = "; ".join(f"{backend.name} = {backend.description}" for backend in BACKENDS.values())
    parser.add_argument(
        "--middleware",
        default=SIMULATED,
        choices=BACKENDS,
        help=f"where the nodes run: {places} (default: {SIMULATED})",
    )
    parser.add_argument(
        "--rate",
        type=float,
        default=1.0,
        metavar="R",
        help="live: seconds of /clock in a second (default: 1)",
    )


def flight_settings(
    arguments: argparse.Namespace, *, middleware: str = "sim", speed: float = 1.0
) -> Settings:
    """Return the settings that the options of `add_flight_options` describe, for a back end of the middleware."""
    return Settings(
        model=arguments.model,
        bag=bag_path(arguments),
        device=arguments.device,
        loop=arguments.loop,
        timing=Timing(duration_s=arguments.duration),
        cache=not arguments.no_cache,
        manager_limit_s=arguments.manager_limit,
        middleware=middleware,
        speed=speed,
    )
