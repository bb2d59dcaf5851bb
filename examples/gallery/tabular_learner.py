"""A tabular learner (numpy): looks up the seconds that a cure took in training, by the cures that were tried before."""

import json
from pathlib import Path

import numpy as np

from sunset.managing import ManagingSystem, Symptoms, Treatment

UNKNOWN_S = 30.0  # what training never tried


class TabularLearner(ManagingSystem):
    """Tries the cure with the least expected time until the failure is gone; `learn.py` wrote the table."""

    files = ("tabular.json",)

    def on_start(self) -> None:
        self.treatment = Treatment(self)
        self.table = json.loads((Path(__file__).parent / self.files[0]).read_text(encoding="utf-8"))

    def adapt(self, symptoms: Symptoms) -> None:
        failure = self.treatment.due(symptoms)
        if failure is None:
            return
        untried = self.treatment.untried(failure)
        tried = [str(option) for option in self.treatment.options(failure) if option not in untried]
        learned = self.table.get("; ".join([failure.name, *tried]), {})
        seconds = [learned.get(str(option), UNKNOWN_S) for option in untried]
        self.treatment.try_cure(failure, untried[int(np.argmin(seconds))])
