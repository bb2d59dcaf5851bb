"""How many decisions a second the environment makes on a core, how long a reset and a fork take, and where time goes.

Run it with `python benchmarks/environment.py`; `--profile` shows the functions that take the time.
"""

import argparse
import cProfile
import pstats
from collections.abc import Callable
from statistics import median
from time import perf_counter, process_time

import gymnasium

from sunset.gym import RepairEnv

SCENARIO = "paper/camera_driver_issue+image_degradation+image_shift"
FORKED_AFTER = 40


def made(observation: str = "arrays") -> RepairEnv:
    """Return an environment whose inferences are in the cache."""
    env = gymnasium.make(
        "sunset/Repair-v0", disable_env_checker=True, scenarios=[SCENARIO], seeds=[1], observation=observation
    ).unwrapped
    assert isinstance(env, RepairEnv)  # noqa: S101  of its type
    env.reset(seed=1)
    idle(env)
    return env


def idle(env: RepairEnv) -> int:
    """Do nothing to the end of the episode; return the number of decisions."""
    decisions, over = 0, False
    while not over:
        _, _, _, over, _ = env.step(0)
        decisions += 1
    return decisions


def timed(function: Callable[[], object], clock: Callable[[], float] = process_time) -> float:
    """Return the seconds that a call takes."""
    begun = clock()
    function()
    return clock() - begun


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--episodes", type=int, default=5, help="how often each is measured (default: 5)")
    parser.add_argument("--profile", action="store_true", help="show where the time of an episode goes")
    arguments = parser.parse_args()
    for observation in ("arrays", "graph", "text"):
        env = made(observation)
        resets, rates = [], []
        for _ in range(arguments.episodes):
            resets.append(timed(env.reset))
            begun = process_time()
            rates.append(idle(env) / (process_time() - begun))
        print(
            f"{observation}: {median(rates):.0f} decisions/s, a reset {1e3 * median(resets):.0f} ms of a processor"
        )
    env = made()
    env.reset()
    for _ in range(FORKED_AFTER):
        env.step(0)
    forks = [timed(lambda: env.fork(lambda _: 0), perf_counter) for _ in range(arguments.episodes)]
    played = [timed(lambda: env.fork(lambda copy: copy.play(lambda *_: 0)), perf_counter) for _ in forks]
    print(f"a fork: {1e3 * median(forks):.0f} ms, with the rest of the episode {1e3 * median(played):.0f} ms")
    if arguments.profile:
        env.reset()
        with cProfile.Profile() as profile:
            idle(env)
        pstats.Stats(profile).sort_stats("tottime").print_stats(25)


if __name__ == "__main__":
    main()
