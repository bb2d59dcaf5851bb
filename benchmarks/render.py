"""Time the renderer: seconds for a town, milliseconds for a flight frame, milliseconds to read one from a bag."""

import argparse
import statistics
import tempfile
from pathlib import Path
from time import perf_counter, process_time

from sunset.data import DEFAULT_FLIGHT, Frame, read_bag, render_frames, write_bag
from sunset_town.town import build_town


def main() -> None:
    """Render every n-th frame of the default flight and print the times."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=10, help="render each n-th frame (default: %(default)s)")
    every = parser.parse_args().every
    start = perf_counter()
    build_town(DEFAULT_FLIGHT.town)
    print(f"town built            {perf_counter() - start:7.2f} s")
    next(render_frames(DEFAULT_FLIGHT, [0]))
    frames: list[Frame] = []
    times: list[float] = []
    busy: list[float] = []
    for index in range(0, DEFAULT_FLIGHT.frames, every):
        start, worked = perf_counter(), process_time()
        frames += render_frames(DEFAULT_FLIGHT, [index])
        times.append(1000 * (perf_counter() - start))
        busy.append(1000 * (process_time() - worked))
    print(f"frame, median         {statistics.median(times):7.1f} ms")
    print(f"frame, median of CPU  {statistics.median(busy):7.1f} ms")
    print(f"frame, slowest        {max(times):7.1f} ms")
    with tempfile.TemporaryDirectory() as folder:
        path = write_bag(Path(folder) / "bag", frames, DEFAULT_FLIGHT.stamps_ns()[: len(frames)])
        start = perf_counter()
        with read_bag(path) as bag:
            print(f"bag opened, a frame   {1000 * (perf_counter() - start) / len(bag):7.3f} ms")
            start = perf_counter()
            for index in range(len(bag)):
                bag.frame(index)
            print(f"frame read            {1000 * (perf_counter() - start) / len(bag):7.3f} ms")


if __name__ == "__main__":
    main()
