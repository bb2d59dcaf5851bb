"""A bandit (mabwiser): Thompson sampling over the cures of each failure; the reward is whether the failure went."""

from mabwiser.mab import MAB, LearningPolicy

from sunset.managing import ManagingSystem, Symptoms, Treatment, Trial


class Bandit(ManagingSystem):
    """Learns during a run which cures help; the prior is a success and a failure of each."""

    def on_start(self) -> None:
        self.treatment = Treatment(self)
        seed = self.declare_parameter("manager_seed", 0).value
        self.trials: list[Trial] = []
        self.bandits: dict[str, MAB] = {}
        for failure in self.treatment.failures:
            arms = [str(option) for option in self.treatment.options(failure)]
            bandit = MAB(arms, LearningPolicy.ThompsonSampling(), seed=seed)
            bandit.fit([*arms, *arms], [1] * len(arms) + [0] * len(arms))
            self.bandits[failure.name] = bandit

    def adapt(self, symptoms: Symptoms) -> None:
        failure = self.treatment.due(symptoms)
        for trial in [trial for trial in self.trials if trial.helped is not None]:
            self.bandits[trial.failure.name].partial_fit([str(trial.option)], [int(trial.helped)])
            self.trials.remove(trial)
        if failure is not None:
            drawn = self.bandits[failure.name].predict_expectations()
            best = max(
                self.treatment.untried(failure), key=lambda option: drawn[str(option)] / option.seconds
            )
            self.trials.append(self.treatment.try_cure(failure, best))
