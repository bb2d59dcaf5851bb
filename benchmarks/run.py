"""How fast a whole experiment is: against its bare inferences, and against real time.

Prints, as medians of several rounds: the wall time of one run without the inference cache and with it filled, the wall
time of the same inferences alone, their ratio, and the real-time factor (flown seconds over wall seconds).
"""

import argparse
import resource
import statistics
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from sunset.data import default_flight, read_bag
from sunset.experiments import RunSpec, Settings, run
from sunset.perception import Modality, Segmenter, load_model
from sunset.scenarios import load_scenario


def median_seconds(rounds: int, function: Callable[[int], object]) -> float:
    """Return the median wall time of `function(round)`."""
    times = []
    for number in range(rounds):
        started = time.perf_counter()
        function(number)
        times.append(time.perf_counter() - started)
    return statistics.median(times)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--model", default="lite")
    arguments = parser.parse_args()
    settings = Settings(model=arguments.model)
    cached = RunSpec(scenario=load_scenario("nofault"), manager="none", settings=settings)
    spec = replace(cached, settings=replace(settings, cache=False))
    timing = cached.timing
    with read_bag(default_flight()) as bag:
        frames = [bag.frame(index) for index in range(timing.least_frames)]
    segmenter = Segmenter(load_model(arguments.model))

    def infer(_: int) -> None:
        for frame in frames:
            segmenter.segment(Modality.FUSION, frame.rgb, frame.depth)

    with tempfile.TemporaryDirectory() as folder:
        infer(0)
        run(cached, Path(folder) / "warm-up")
        bare = median_seconds(arguments.rounds, infer)
        computed = median_seconds(
            arguments.rounds, lambda number: run(spec, Path(folder) / f"computed-{number}")
        )
        looked_up = median_seconds(
            arguments.rounds, lambda number: run(cached, Path(folder) / f"cached-{number}")
        )
    flown = timing.warm_up_s + timing.duration_s
    print(f"flown                          {flown:8.1f} s, {timing.least_frames} frames")
    print(f"bare inferences                {bare:8.2f} s, {1e3 * bare / timing.least_frames:.1f} ms a frame")
    print(f"run, inferences computed       {computed:8.2f} s, {flown / computed:.1f} times real time")
    print(f"run over bare inferences       {computed / bare:8.2f}")
    print(f"run, inferences looked up      {looked_up:8.2f} s, {flown / looked_up:.1f} times real time")
    print(
        f"peak memory of this process    {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:8.0f} MiB"
    )


if __name__ == "__main__":
    main()
