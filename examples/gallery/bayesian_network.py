"""A Bayesian network (pgmpy): infers the fault from the cures that did not help, and weighs help against time."""

from pgmpy.factors.discrete import TabularCPD
from pgmpy.inference import VariableElimination
from pgmpy.models import DiscreteBayesianNetwork

from sunset.managing import ManagingSystem, Option, Symptoms, Treatment

FAILS_AS_RIGHT_CURE = 0.05  # such as when a second fault hides that it helped
FAILS_AS_WRONG_CURE = 0.98


def causes(option: Option) -> tuple[str, ...]:
    """Return the faults that a cure ends; without a catalogue, a fault of its own."""
    return option.faults or (str(option),)


class BayesianNetwork(ManagingSystem):
    """Has a network for each failure: its fault, and whether each cure would fail."""

    def on_start(self) -> None:
        self.treatment = Treatment(self)
        self.faults: dict[str, list[str]] = {}
        self.inference: dict[str, VariableElimination] = {}
        for failure in self.treatment.failures:
            options = self.treatment.options(failure)
            faults = list(dict.fromkeys(fault for option in options for fault in causes(option)))
            network = DiscreteBayesianNetwork([("fault", f"{option} fails") for option in options])
            network.add_cpds(TabularCPD("fault", len(faults), [[1 / len(faults)]] * len(faults)))
            for option in options:
                fails = [
                    FAILS_AS_RIGHT_CURE if fault in causes(option) else FAILS_AS_WRONG_CURE
                    for fault in faults
                ]
                helps = [1 - probability for probability in fails]
                network.add_cpds(TabularCPD(f"{option} fails", 2, [helps, fails], ["fault"], [len(faults)]))
            self.faults[failure.name], self.inference[failure.name] = faults, VariableElimination(network)

    def adapt(self, symptoms: Symptoms) -> None:
        failure = self.treatment.due(symptoms)
        if failure is None:
            return
        untried = self.treatment.untried(failure)
        failed = {f"{option} fails": 1 for option in self.treatment.options(failure) if option not in untried}
        posterior = self.inference[failure.name].query(["fault"], evidence=failed, show_progress=False)
        probability = dict(zip(self.faults[failure.name], map(float, posterior.values), strict=True))
        self.diagnose({fault: min(1.0, share) for fault, share in probability.items()})

        def worth(option: Option) -> float:
            return sum(probability[fault] for fault in causes(option)) / option.seconds

        self.treatment.try_cure(failure, max(untried, key=worth))
