"""`sunset data`: flights and what is in them."""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from sunset.classes import CLASS_OF_CARLA_ID, CLASSES
from sunset.cli._progress import progress_bar, rendering_progress
from sunset.data import FlightPlan, Frame, default_flight, read_bag, render_frames, write_bag

__all__ = ["add_parser", "info", "render"]


def add_parser(verbs: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb."""
    parser = verbs.add_parser("data", help="render flights, look into bags")
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)
    rendering = actions.add_parser(
        "render",
        help="render a flight to a rosbag2",
        description="Render a flight over a procedural town and write it as a rosbag2 (MCAP).",
    )
    rendering.add_argument("--town", type=int, default=1, metavar="N", help="1 to 8 (default: 1)")
    rendering.add_argument("--height", type=float, default=50.0, metavar="M", help="metres (default: 50)")
    rendering.add_argument(
        "--angle", type=float, default=60.0, metavar="DEG", help="camera pitch down (default: 60)"
    )
    rendering.add_argument("--time", default="noon", help="time of day (default: noon)")
    rendering.add_argument("--weather", default="clear", help="weather (default: clear)")
    rendering.add_argument("--frames", type=int, default=400, metavar="N", help="at 10 Hz (default: 400)")
    rendering.add_argument(
        "--seed", type=int, default=0, metavar="N", help="of the sensor noise (default: 0)"
    )
    rendering.add_argument("--out", type=Path, required=True, metavar="DIR", help="the new bag's folder")
    rendering.set_defaults(execute=render)
    looking = actions.add_parser("info", help="what a bag holds")
    looking.add_argument("bag", nargs="?", type=Path, help="a rosbag2 (default: the default flight)")
    looking.add_argument("--json", action="store_true", help="print one JSON object")
    looking.set_defaults(execute=info)


def render(arguments: argparse.Namespace) -> int:
    """Render a flight."""
    plan = FlightPlan(
        town=arguments.town,
        height=arguments.height,
        pitch_deg=arguments.angle,
        time=arguments.time,
        weather=arguments.weather,
        frames=arguments.frames,
        seed=arguments.seed,
    )
    with progress_bar("Rendering") as progress:

        def frames() -> Iterator[Frame]:
            for done, frame in enumerate(render_frames(plan), 1):
                yield frame
                progress(done, plan.frames)

        write_bag(arguments.out, frames(), plan.stamps_ns())
    print(f"The flight is in {arguments.out}.", file=sys.stderr)
    return 0


def info(arguments: argparse.Namespace) -> int:
    """Print what a bag holds."""
    if arguments.bag is None:
        with rendering_progress() as progress:
            bag = default_flight(progress=progress)
    else:
        bag = arguments.bag
    with read_bag(bag) as reader:
        pixels: Counter[str] = Counter()
        for index in range(len(reader)):
            counts = np.bincount(CLASS_OF_CARLA_ID[reader.frame(index).labels].ravel(), minlength=256)
            pixels.update({name: int(counts[number]) for number, name in enumerate(CLASSES)})
    total = sum(pixels.values())
    height, width = reader.size
    stamps = reader.stamps_ns
    seconds = (stamps[-1] - stamps[0]) / 1e9
    shares = {name: count / total for name, count in pixels.most_common() if count}
    if arguments.json:
        found = {"bag": str(bag), "frames": len(reader), "width": width, "height": height, "seconds": seconds}
        print(json.dumps(found | {"classes": shares}, sort_keys=True))
        return 0
    print(f"{bag}\n{len(reader)} frames of {width} x {height} pixels over {seconds:.1f} s")
    for name, share in shares.items():
        print(f"  {name:14}{share:8.3%}")
    return 0
