"""Write tabular.json and linear.json: from runs that try cures at random.

Usage: python examples/gallery/learn.py FOLDER [SCENARIOS]. FOLDER gets the runs, on scenarios of the split `train`.
"""

import json
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

import sunset
from sunset.files.outputs import write_text
from sunset.managing import ManagingSystem, Symptoms, Treatment, Trial
from sunset.system.vocabulary import current_system
from sunset_ros.seeding import generator

GIVEN_UP_S = 30.0  # the time that a failure lasts when no cure is left
RIDGE = 1.0
ROUNDS = 10  # more than cures that a failure has
HERE = Path(__file__).parent


class Exploring(ManagingSystem):
    """Tries cures at random, and logs each trial."""

    def on_start(self) -> None:
        self.treatment = Treatment(self)
        self.seed = self.declare_parameter("manager_seed", 0).value
        self.trials: list[tuple[Trial, dict[str, object]]] = []

    def adapt(self, symptoms: Symptoms) -> None:
        failure = self.treatment.due(symptoms)
        for trial, seen in [known for known in self.trials if known[0].helped is not None]:
            self.get_logger().info(json.dumps({**seen, "helped": trial.helped}))
            self.trials.remove((trial, seen))
        if failure is not None:
            untried, options = self.treatment.untried(failure), self.treatment.options(failure)
            random = generator(self.seed, "exploring", repr(symptoms))  # other draws in each scenario
            option = untried[random.integers(len(untried))]
            seen = {
                "failure": failure.name,
                "cures": [str(other) for other in options],
                "seconds": option.seconds,
                "signals": [float(np.nan_to_num(symptoms.signal(name))) for name in current_system().signals],
                "tried": [int(other not in untried) for other in options],
                "cure": options.index(option),
            }
            self.trials.append((self.treatment.try_cure(failure, option), seen))


def explored(folder: Path, scenarios: int) -> list[dict]:
    """Return the trials that the runs have logged."""
    sunset.generate_split("train", scenarios, folder / "train", seed=1)
    manager = {"exploring": f"{__file__}:Exploring"}
    results = sunset.bench(folder / "train", manager, out=folder / "runs", score=False, references=False)
    lines = [line for row in results.runs for line in sunset.load(row.folder).log]
    return [json.loads(line.text) for line in lines if line.text.startswith('{"failure"')]


def after(trial: dict) -> list[int]:
    """Return which cures were tried after a trial."""
    return [int(tried or number == trial["cure"]) for number, tried in enumerate(trial["tried"])]


def row(trial: dict, tried: list[int]) -> str:
    """Return the name of a row of the table: the failure, and the cures that were tried."""
    return "; ".join(
        [trial["failure"], *(cure for cure, was in zip(trial["cures"], tried, strict=True) if was)]
    )


def table_of(trials: list[dict]) -> dict[str, dict[str, float]]:
    """Return row → cure → expected seconds until the failure is gone, from the shares of trials that helped."""
    groups = defaultdict(list)
    for trial in sorted(trials, key=lambda trial: -sum(trial["tried"])):
        groups[row(trial, trial["tried"]), trial["cures"][trial["cure"]]].append(trial)
    table = defaultdict(dict)
    for (name, cure), same in groups.items():  # rows with more tried cures come first
        helps = (sum(trial["helped"] for trial in same) + 0.5) / (len(same) + 1)
        later = min(table[row(same[0], after(same[0]))].values(), default=GIVEN_UP_S)
        table[name][cure] = round(same[0]["seconds"] + (1 - helps) * later, 2)
    return {name: cures for name, cures in sorted(table.items()) if cures}


def weights_of(trials: list[dict]) -> dict[str, dict[str, list[float]]]:
    """Return failure → cure → weights of 1, the signals and the cures tried, by fitted value iteration."""
    weights: dict[str, dict[str, list[float]]] = defaultdict(dict)
    for _ in range(ROUNDS):
        fitted = defaultdict(dict)
        for name, number in sorted({(trial["failure"], trial["cure"]) for trial in trials}):
            same = [t for t in trials if (t["failure"], t["cure"]) == (name, number)]
            seen = np.array([[1.0, *trial["signals"], *trial["tried"]] for trial in same])
            seconds = np.array([trial["seconds"] + remaining_s(trial, weights[name]) for trial in same])
            ridge = seen.T @ seen + RIDGE * np.eye(seen.shape[1])
            found = np.linalg.solve(ridge, seen.T @ seconds)
            fitted[name][same[0]["cures"][number]] = [round(float(weight), 3) for weight in found]
        weights = fitted
    return weights


def remaining_s(trial: dict, weights: dict[str, list[float]]) -> float:
    """Return the expected seconds that a failure goes on after a trial."""
    if trial["helped"]:
        return 0.0
    tried = after(trial)
    left = [cure for cure, was in zip(trial["cures"], tried, strict=True) if not was and cure in weights]
    seen = [1.0, *trial["signals"], *tried]
    return min([GIVEN_UP_S, *(max(0.0, float(np.dot(weights[cure], seen))) for cure in left)])


def main() -> None:
    """Explore, and write both files."""
    folder, scenarios = Path(sys.argv[1]), int(sys.argv[2]) if sys.argv[2:] else 100
    trials = explored(folder, scenarios)
    write_text(HERE / "tabular.json", json.dumps(table_of(trials), indent=1) + "\n")
    write_text(HERE / "linear.json", json.dumps(weights_of(trials), indent=1) + "\n")
    print(f"{len(trials)} trials in {scenarios} scenarios")


if __name__ == "__main__":
    main()
