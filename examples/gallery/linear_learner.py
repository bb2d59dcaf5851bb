"""A linear learner (numpy): the seconds that a cure takes are a linear function of the signals and of cures tried."""

import json
from pathlib import Path

import numpy as np

from sunset.managing import ManagingSystem, Symptoms, Treatment
from sunset.system.vocabulary import Failure, current_system

UNKNOWN_S = 30.0  # of cures that training never tried


class LinearLearner(ManagingSystem):
    """Tries the cure with the least expected time until the failure is gone; `learn.py` wrote the weights."""

    files = ("linear.json",)

    def on_start(self) -> None:
        self.treatment = Treatment(self)
        self.weights = json.loads((Path(__file__).parent / self.files[0]).read_text(encoding="utf-8"))

    def features(self, failure: Failure, symptoms: Symptoms) -> list[float]:
        """Return 1, all signals, and 1 or 0 for each cure of the failure: whether it was tried."""
        untried = self.treatment.untried(failure)
        signals = np.nan_to_num([symptoms.signal(name) for name in current_system().signals])
        return [1.0, *signals, *(float(option not in untried) for option in self.treatment.options(failure))]

    def adapt(self, symptoms: Symptoms) -> None:
        failure = self.treatment.due(symptoms)
        if failure is None:
            return
        features, learned = self.features(failure, symptoms), self.weights.get(failure.name, {})
        untried = self.treatment.untried(failure)
        seconds = [
            np.dot(learned[str(option)], features) if str(option) in learned else UNKNOWN_S
            for option in untried
        ]
        self.treatment.try_cure(failure, untried[int(np.argmin(seconds))])
