"""`sunset data`: flights rendered, imported and looked into."""

import argparse
import json
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Final

import sunset
from sunset.cli.options import add_count_option, add_flag, add_path, call
from sunset.cli.parser import Actions, Parser, parse_number
from sunset.cli.progress import BUILDING, progress_bar, rendering_progress, stages_progress
from sunset.data import (
    DEPTH_UNITS,
    IDS,
    RENDERING,
    SYNDRONE,
    TIMES,
    WEATHERS,
    BagStatistics,
    FlightPlan,
    Frame,
    Reading,
    default_flight,
    find_pictures,
    find_syndrone,
    is_syndrone,
    read_bag,
    survey_syndrone,
    write_bag,
)
from sunset.errors import InvalidInputError
from sunset.flights import KEYS, FlightSpec
from sunset.texts.sentences import counted
from sunset_ros.texts import printable

_PLACE: Final = "The flight of {} frames is in {}."
_OUT: Final = "the new bag: a folder, or a file in .mcap or .db3"
_SOURCES: Final = ("syndrone", "pictures", "bag")
_OF_SOURCES: Final = (
    ("town", "1", _SOURCES[:1]),
    ("height", 50, _SOURCES[:1]),
    ("weather", None, _SOURCES[:1]),
    ("rate", 10, _SOURCES[:2]),
    ("ids", SYNDRONE.ids, _SOURCES[1:]),
    ("depth-unit", SYNDRONE.depth_unit, _SOURCES[1:]),
    ("jobs", None, _SOURCES[:2]),
)
"""Options of `import`, what they are where they are not given, and the sources that have a use for them."""
_rate: Final = partial(
    parse_number, kind=float, expected="frames a second from 0.1 to 1000", least=0.1, most=1000
)


def add_arguments(parser: Parser) -> None:
    actions = parser.add_subparsers(title="actions", metavar="ACTION")
    _add_render(actions)
    _add_import(actions)
    looking = actions.add_parser("info", help="say what a bag or a folder of SynDrone's holds")
    looking.add_argument(
        "path", nargs="?", type=Path, help="a rosbag2 or SynDrone's folder (default: the default flight)"
    )
    add_flag(looking, "--json", "print one JSON object")
    looking.set_defaults(execute=info)


def _add_render(actions: Actions) -> None:
    parser = actions.add_parser(
        "render",
        help="render a flight",
        description="Render a flight over a procedural town. It is kept in the cache folder, where scenarios, "
        "campaigns and runs with the same conditions find it, and written as a rosbag2 (MCAP) if --out names one.",
    )
    parser.add_argument("--town", type=int, default=1, metavar="N", help="1 to 8")
    parser.add_argument(
        "--height", type=float, default="50", metavar="M", help="20 to 300 m; below 45 it follows a street"
    )
    parser.add_argument("--angle", type=float, default="60", metavar="DEG", help="camera pitch down, 0 to 90")
    parser.add_argument("--time", default="noon", help=f"one of {', '.join(TIMES)}")
    parser.add_argument("--weather", default="clear", help=f"one of {', '.join(WEATHERS)}")
    parser.add_argument("--frames", type=int, default=400, metavar="N", help="at 10 Hz, at most 1333")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of the sensor noise")
    add_count_option(parser, "--jobs", "rendering processes (default: one a core, at most 8)")
    add_path(parser, "--out", "PATH", _OUT)
    parser.set_defaults(execute=render)


def _add_import(actions: Actions) -> None:
    parser = actions.add_parser(
        "import",
        help="make a flight of SynDrone's folders, of a folder of pictures, or of another bag",
        description="Read a flight of the SynDrone data set, a folder of pictures, or any rosbag2, check it, resample "
        "it, and write it as a rosbag2 (MCAP) that 'sunset run --bag' plays.",
    )
    source = parser.add_mutually_exclusive_group(required=True)
    add_path(source, "--syndrone", "DIR", "the folder that holds TownNN_Opt_120")
    add_path(source, "--pictures", "DIR", "a folder with pictures in rgb, depth and, if any, labels")
    add_path(source, "--bag", "PATH", "a rosbag2 folder or file")
    parser.add_argument("--town", default="1", metavar="N", help="SynDrone's, 1 to 7 or 10HD")
    parser.add_argument("--height", type=int, default=50, metavar="M", help="SynDrone's, 20, 50 or 80")
    parser.add_argument("--weather", metavar="NAME", help="SynDrone's, where a town has several")
    _add_reading(parser)
    add_count_option(parser, "--jobs", "reading threads (default: one a core)")
    add_path(parser, "--out", "PATH", _OUT, required=True)
    parser.set_defaults(execute=import_flight)


def _add_reading(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--frames",
        type=_span,
        default=(None, None),
        metavar="FIRST:LAST",
        help="indices of the first and the last frame, from 0 (default: all)",
    )
    parser.add_argument("--rate", type=_rate, default="10", metavar="HZ", help="of the pictures' frames")
    parser.add_argument("--size", type=_size, default="256x144", metavar="WxH", help="in pixels")
    parser.add_argument(
        "--ids",
        choices=tuple(IDS),
        default=SYNDRONE.ids,
        help="what labels are: SynDrone's, ids of CARLA since 0.9.14, class indices (default: syndrone)",
    )
    parser.add_argument(
        "--depth-unit",
        choices=DEPTH_UNITS,
        default=SYNDRONE.depth_unit,
        help="of whole numbers: counts of 1000 / 65535 m, or millimetres (default: counts)",
    )


def _span(text: str) -> tuple[int | None, int | None]:
    match = re.fullmatch(r"(\d*):(\d*)", text)
    if not match:
        raise argparse.ArgumentTypeError(f"expected FIRST:LAST such as 0:299, got {text!r}")
    first, last = (int(number) if number else None for number in match.groups())
    return first, last


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,4})x(\d{1,4})", text)
    width, height = (int(number) for number in match.groups()) if match else (0, 0)
    if not (width and height):
        raise argparse.ArgumentTypeError(f"expected WIDTHxHEIGHT such as 256x144, got {text!r}")
    return height, width


def render(arguments: argparse.Namespace) -> None:
    given = {name: getattr(arguments, name) for name in KEYS if name != "bag"}
    plan = FlightPlan.of(FlightSpec.of(given), arguments.frames)
    with stages_progress() as stage:
        stage(BUILDING)  # before there is a frame
        folder = sunset.render_flight(
            arguments.out, plan, jobs=arguments.jobs, progress=partial(stage, RENDERING)
        )
    print(_PLACE.format(plan.frames, folder), file=sys.stderr)


def import_flight(arguments: argparse.Namespace) -> None:
    _check_source(arguments)
    first, last = arguments.frames
    reading = Reading(arguments.ids, arguments.depth_unit)
    if arguments.bag is None:
        if arguments.pictures is not None:
            flight = find_pictures(arguments.pictures, first=first, last=last)
        else:
            flight = call(find_syndrone, arguments, root=arguments.syndrone, first=first, last=last)
        if flight.unlabelled:
            print(f"{_unlabelled_text(flight.unlabelled, len(flight))}.", file=sys.stderr)
        stamps = [round((index + 1) * 1e9 / arguments.rate) for index in range(len(flight))]
        frames = flight.frames(arguments.size, jobs=arguments.jobs, reading=reading)
        _write(arguments.out, frames, stamps, reading)
        return
    with read_bag(arguments.bag, size=arguments.size, reading=reading) as reader:
        low, high = first or 0, len(reader) - 1 if last is None else last
        if not low <= high < len(reader):
            raise InvalidInputError(
                f"The bag {reader.path} has frames 0 to {len(reader) - 1}, got --frames from {low} to {high}; "
                "choose them among these."
            )
        if any(reader.dropped.values()):
            print(f"Images without a frame are left out: {_dropped(reader.dropped)}.", file=sys.stderr)
        if reader.unlabelled:
            print(f"{_unlabelled_text(reader.unlabelled, len(reader))}.", file=sys.stderr)
        chosen = range(low, high + 1)
        stamps = [reader.stamps_ns[index] for index in chosen]
        _write(arguments.out, map(reader.frame, chosen), stamps, reading)


def _check_source(arguments: argparse.Namespace) -> None:
    """Refuse options that the source does not use."""
    (source,) = (name for name in _SOURCES if getattr(arguments, name) is not None)
    for option, unset, sources in _OF_SOURCES:
        if source not in sources and getattr(arguments, option.replace("-", "_")) != unset:
            uses = " and ".join(f"--{name}" for name in sources)
            raise InvalidInputError(
                f"The option --{option} is for {uses} and cannot be used with --{source}; leave it out."
            )


def _write(out: Path, frames: Iterable[Frame], stamps_ns: Sequence[int], reading: Reading) -> None:
    """Write a bag with a progress bar; print how its frames were read."""
    with progress_bar("Importing") as progress:

        def counted() -> Iterator[Frame]:
            for done, frame in enumerate(frames, 1):
                yield frame
                progress(done, len(stamps_ns))

        write_bag(out, counted(), stamps_ns)
    print(_PLACE.format(len(stamps_ns), out), file=sys.stderr)
    print(reading, file=sys.stderr)


def info(arguments: argparse.Namespace) -> None:
    if arguments.path is None:
        with rendering_progress() as progress:
            path = default_flight(progress=partial(progress, RENDERING))
    else:
        path = arguments.path
    if is_syndrone(path):
        contents, text = _syndrone(path)
    else:
        with progress_bar("Looking") as progress:
            statistics = sunset.bag_statistics(path, progress=progress)
        contents, text = statistics.to_json(), _bag_text(statistics)
    print(json.dumps(contents, sort_keys=True) if arguments.json else printable(text))


def _syndrone(root: Path) -> tuple[dict[str, object], str]:
    flights, lines = [], [f"{root}\n  town  weather          height     rgb  depth  semantic"]
    for (town, weather, height), counts in survey_syndrone(root).items():
        flights.append({"town": town, "weather": weather, "height_m": height, "images": dict(counts)})
        lines.append(
            f"  {town:6}{weather:16}{height:4} m{counts['rgb']:10}{counts['depth']:7}{counts['semantic']:10}"
        )
    return {"syndrone": str(root), "flights": flights}, "\n".join(lines)


def _unlabelled_text(unlabelled: int, frames: int) -> str:
    has, it_is, counts = ("has", "it is", "counts") if unlabelled == 1 else ("have", "they are", "count")
    return f"{unlabelled} of {counted(frames, 'frame')} {has} no labels: {it_is} flown, and {counts} for no quality"


def _dropped(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{count} on {topic}" for topic, count in counts.items())


def _bag_text(contents: BagStatistics) -> str:
    """Return the contents of a bag as text."""
    rate = f" at {contents.rate_hz:.4g} Hz" if contents.rate_hz else ""
    height, width = contents.size
    lines = [
        f"{contents.path}",
        f"{contents.frames} frames of {width} x {height} pixels over {contents.seconds:.1f} s{rate}",
    ]
    for topic, (kind, count) in contents.topics.items():
        encoding = f", {contents.encodings[topic]}" if topic in contents.encodings else ""
        lines.append(f"  {topic}: {count} x {kind}{encoding}")
    if any(contents.dropped.values()):
        lines.append(f"images without a frame: {_dropped(contents.dropped)}")
    near, far = contents.depth_m
    lines.append(
        f"depth from {near:.1f} to {far:.1f} m; {contents.depth_far:.1%} is further away or not known"
    )
    if contents.unlabelled:
        lines.append(_unlabelled_text(contents.unlabelled, contents.frames))
    lines.append(str(SYNDRONE))
    lines += [f"  {name:14}{share:8.3%}" for name, share in contents.classes.items()]
    return "\n".join([*lines, f"  {'(no class)':14}{contents.ignored:8.3%}"])
