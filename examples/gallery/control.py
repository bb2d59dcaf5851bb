"""Control (no library): extremum seeking on the strength of a correction; a switching law for all other cures."""

from sunset.managing import ManagingSystem, Option, Symptoms, Treatment, Trial, described_faults
from sunset.system.vocabulary import Adaptation, AdaptationKind

LEAST_STEP = 0.1  # smaller steps do not show


class Loop:
    """Seeks the strength at which a signal is least, if a cure activates a node that corrects a strength."""

    def __init__(self, options: tuple[Option, ...]) -> None:
        self.cure: Option | None = None
        self.trial: Trial | None = None  # the last step
        for option in options:
            fault = described_faults().get(next(iter(option.faults), ""))
            nodes = [step.node for step in option.steps if step.kind is AdaptationKind.ACTIVATE]
            if fault and fault.limits and nodes:
                self.cure, self.node, self.parameter = option, nodes[0], fault.parameter
                self.strength, self.step, self.limits = (
                    float(fault.value),
                    float(fault.value) / 2,
                    fault.limits,
                )

    def next_step(self) -> Option | None:
        """Return the usual strength first, then steps from the best; None if no step helps."""
        if self.cure is None or self.trial is None:
            return self.cure
        if self.trial.kept and self.trial.option != self.cure:
            self.strength += self.step
        elif not self.trial.kept:
            self.step /= -2
        if abs(self.step) < LEAST_STEP or (not self.trial.kept and self.trial.option == self.cure):
            self.cure = None
            return None
        low, high = self.limits
        strength = round(min(high, max(low, self.strength + self.step)), 3)
        setting = Adaptation(AdaptationKind.SET_PARAMETER, self.node, self.parameter, strength)
        return Option((setting,), self.cure.faults, self.cure.seconds)


class Control(ManagingSystem):
    """Seeks the strength of a correction while a failure shows; then switches to the next cure."""

    def on_start(self) -> None:
        self.treatment = Treatment(self)
        self.loops: dict[str, Loop] = {}

    def adapt(self, symptoms: Symptoms) -> None:
        failure = self.treatment.due(symptoms)
        showing = {shown.name for shown in self.treatment.showing}
        self.loops = {name: loop for name, loop in self.loops.items() if name in showing}
        if failure is not None:
            loop = self.loops.setdefault(failure.name, Loop(self.treatment.options(failure)))
            option = loop.next_step() or self.treatment.untried(failure)[0]
            loop.trial = self.treatment.try_cure(failure, option)
