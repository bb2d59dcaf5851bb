"""A managing system that reasons: it believes more or less in each fault, and learns from what its adaptations do."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from sunset.managing.base import ManagingSystem
from sunset.managing.belief import Belief
from sunset.managing.configuration import MODALITY, SEEN, WITHOUT, Configuration, Setting, settings_of
from sunset.managing.requesting import request
from sunset.managing.symptoms import Symptoms
from sunset.managing.watching import NEW_FRAMES_S, PASSING_S, Watch
from sunset.managing.wiring import Wiring
from sunset.system.vocabulary import (
    REPAIR,
    Adaptation,
    AdaptationKind,
    Failure,
    Fault,
    FaultKind,
    Sensor,
    Value,
    described_failures,
    described_faults,
    full_name,
)

_BLIND_S: Final = 1.0
"""Cost of doing without a sensor, in seconds of output, when nothing is known of what is wrong."""
_FIRST_LOOK_S: Final = 3.0
"""Time from hiding a sensor from the segmentation to looking at it again; each time it is twice as long."""
_RISE: Final = 0.015
"""A signal that is higher by so much than at the last look says that something has come."""
_DOUBTFUL: Final = 0.05
"""A fault that is worked around is taken to be there still, unless it is more probable than this that it has healed."""
_LIKELY: Final = 0.5
"""A fault that is more probable than this is taken to be there."""

_PROVEN: Final = {**SEEN, 1: frozenset[Sensor]()}
"""Modality → the sensors whose faults a calm entropy excludes. With the colour image alone it stays calm where that
image is dark or misaligned, so that it proves nothing."""

Cure = tuple[Adaptation, ...]


@dataclass(frozen=True)
class _Option:
    """A possible action: a cure of some faults, or lifting the cure of one."""

    faults: tuple[str, ...]
    cure: Cure
    probability: float
    cost_s: float


@dataclass(frozen=True)
class _Trial:
    """What is being tried, how bad the signal was before, and when one sees whether it has helped."""

    option: _Option
    before: float
    due_s: float
    released: dict[Setting, Value]


class Diagnosing(ManagingSystem):
    """Believes in faults by what shows and by what its adaptations do, and tries what promises most for what it costs.

    It knows the catalogue: which faults show as which failure, and what cures each. A failure that shows makes all of
    its faults suspects. It tries the cure with the highest probability of helping, divided by the time until one sees
    whether it has. What does not help excludes the faults that it would have cured, and is undone.

    - The node to repair is the one that gets all of its inputs and sends nothing, seen before a second is over. While a
      sensor boots, the segmentation takes the other one.
    - A calm entropy proves nothing of what the segmentation does not look at, and with the colour image alone nothing
      at all. So it returns to both images for a moment now and then, and compares.
    """

    def on_start(self) -> None:
        """Believe in nothing yet."""
        self.faults, self.failures, self.wiring = described_faults(), described_failures(), Wiring()
        self.belief = Belief(self.faults)
        self.configuration = Configuration(self)
        self.watch = Watch(self, self.configuration)
        self.trials: dict[str, _Trial] = {}  # by failure
        self.in_place: dict[str, dict[Setting, Value]] = {}  # fault → what works around it
        self.is_looking, self.look_s, self.next_look_s, self.level = False, _FIRST_LOOK_S, 0.0, 0.0
        self.last_s, self.told = self.now_s, dict[str, float]()
        self.suspected: dict[str, float] = {}  # fault → its probability before its cure is tried now
        self.may_adapt = self.greeting["task"] == REPAIR

    def adapt(self, symptoms: Symptoms) -> None:
        """Treat the failures that show, and say what it believes: of what it tries to cure, what it believed before."""
        self.symptoms = symptoms
        self.belief.forget(self.now_s - self.last_s)
        self.last_s = self.now_s
        self.configuration.see(symptoms)
        if self.hidden() and not self.is_looking and self.now_s > self.next_look_s:
            self.look()
        self.watch.see(symptoms)
        for failure in self.failures.values():
            self.treat(failure)
        self.configuration.want(self.wanted(), symptoms)
        believed = {name: self.belief.probability(name) for name in self.faults} | self.suspected
        told = {name: round(probability, 2) for name, probability in believed.items()}
        self.suspected = {}
        if told != self.told:
            self.told = told
            self.diagnose(told)

    def treat(self, failure: Failure) -> None:
        """See what a trial has done, conclude, and try what is best next if the failure shows."""
        shows, trial = self.watch.shows(failure), self.trials.get(failure.name)
        is_looked_at = self.is_looking and any(
            self.faults[name].failure == failure.name for name in self.hidden()
        )
        is_over = trial is None or self.now_s >= trial.due_s or self.watch.is_back(failure)
        if shows is None or not is_over:
            return
        if trial is not None:
            self.judge(failure, self.trials.pop(failure.name), shows=shows)
        faults = [fault for fault in self.faults.values() if fault.failure == failure.name]
        if not shows:
            self.conclude(failure, faults)
        elif not is_looked_at or self.watch.badness(failure) > self.level + _RISE:
            self.try_best(failure, faults)
        if is_looked_at and failure.name not in self.trials:
            self.hide(self.watch.badness(failure))

    def judge(self, failure: Failure, trial: _Trial, *, shows: bool) -> None:
        """Learn from a trial, and undo what was no help."""
        # that nothing is needed any more must be plain to see, since the signal also changes with what is flown over
        margin = _RISE if trial.released else 0.0
        has_helped = not shows or self.watch.badness(failure) < trial.before - margin
        if failure.topic:
            self.watch.end_repair(full_name(failure.topic))
        for name in trial.option.faults:
            settings = self.in_place.get(name, {})
            if trial.released and not has_helped:
                self.in_place[name] = trial.released
                self.belief.confirm(name)
            elif MODALITY in settings and self.belief.probability(name) > _LIKELY:
                self.belief.confirm(name)  # not since it has helped, but for want of other suspects
                self.look_s = _FIRST_LOOK_S
                self.hide(trial.before)
            elif settings and has_helped and MODALITY not in settings:
                self.belief.confirm(name)
            elif failure.topic or settings or trial.released:
                self.in_place.pop(name, None)
                self.belief.exclude([name])

    def conclude(self, failure: Failure, faults: list[Fault]) -> None:
        """Exclude the faults of a failure that would show if they were there."""
        sensors = _PROVEN[self.configuration.get(MODALITY) or 0]
        proven = [fault.name for fault in faults if fault.effect is None or fault.effect.sensor in sensors]
        for name in set(proven).intersection(self.hidden()):
            del self.in_place[name]
            self.belief.exclude([name])
        if len(proven) == len(faults):
            self.belief.settle(failure.name, proven)
        else:
            self.belief.exclude(name for name in proven if name not in self.in_place)

    def try_best(self, failure: Failure, faults: list[Fault]) -> None:
        """Try what has the highest probability of helping for its cost."""
        suspects = [fault for fault in faults if fault.name not in self.in_place and self.is_possible(fault)]
        names = [fault.name for fault in suspects]
        self.belief.suspect(failure.name, names)
        self.suspected |= {name: self.belief.probability(name) for name in names}
        if not self.may_adapt:
            return
        options = list(self.releases(faults))
        if failure.topic or self.belief.is_plausible(names):
            options += self.cures(suspects)
        if not options:
            return
        best = max(options, key=lambda option: option.probability / option.cost_s)
        released = {} if best.cure else self.in_place.pop(best.faults[0])
        self.do(best)
        if failure.topic:
            self.watch.begin_repair(full_name(failure.topic))
        elif best.cure and not self.lasts(best.faults):
            self.belief.exclude(best.faults)  # of this moment, whenever one sees whether it has helped
        due_s = self.now_s + (best.cost_s if failure.topic else NEW_FRAMES_S)
        self.trials[failure.name] = _Trial(best, self.watch.badness(failure), due_s, released)

    def is_possible(self, fault: Fault) -> bool:
        """Return whether a fault could be there, by the sensors in use and by the nodes that it activates."""
        activated = [step.node for step in fault.injection if step.kind is AdaptationKind.ACTIVATE]
        foreign = [node for node in activated if not self.configuration.get((node, ""))]
        is_set = not activated or any(self.symptoms.state(node) == "active" for node in foreign)
        seen = SEEN[self.configuration.get(MODALITY) or 0]
        return is_set and (fault.effect is None or fault.effect.sensor in seen)

    def cures(self, suspects: list[Fault]) -> Iterator[_Option]:
        """Yield the cures of some faults that can be done now."""
        for cure in dict.fromkeys(cure for fault in suspects for cure in fault.cures):
            if all(self.is_up(step) for step in cure):
                names = tuple(fault.name for fault in suspects if cure in fault.cures)
                yield _Option(names, cure, self.belief.probability_of_any(names), self.cost_s(cure, names))

    def releases(self, faults: list[Fault]) -> Iterator[_Option]:
        """Yield the workarounds that could be lifted, since their faults may have healed."""
        for fault in faults:
            healed = self.belief.probability_healed(fault.name)
            if healed > _DOUBTFUL and MODALITY not in self.in_place.get(fault.name, {MODALITY: 0}):
                yield _Option((fault.name,), (), healed, NEW_FRAMES_S)

    def is_up(self, step: Adaptation) -> bool:
        """Return whether a step can be done now: only a redeploy brings back a node without a process."""
        is_there = self.symptoms.state(step.node) != "unknown" or step.kind is AdaptationKind.REDEPLOY
        return is_there and step.node not in self.configuration.booting

    def cost_s(self, cure: Cure, names: tuple[str, ...]) -> float:
        """Return how long it takes to see whether a cure helps, and to undo what was no help [s]."""
        boots = [self.configuration.boot_s(step.node) for step in cure if _is_redeploy(step)]
        is_restart = all(step.kind is AdaptationKind.RESTART for step in cure)
        cost_s = max(boots, default=0.0) + (PASSING_S if is_restart else NEW_FRAMES_S)
        hides = any((step.node, step.parameter) == MODALITY for step in cure)
        return (2 * cost_s if self.lasts(names) else cost_s) + (_BLIND_S if hides else 0.0)

    def lasts(self, names: tuple[str, ...]) -> bool:
        """Return whether a cure of faults must stay in place, since they are of the world."""
        return any(self.faults[name].kind is FaultKind.EXTERNAL for name in names)

    def do(self, option: _Option) -> None:
        """Do a cure; what works around a fault of the world is set as long as it is in place."""
        settings = settings_of(option.cure)
        if self.lasts(option.faults) and settings:
            self.in_place |= dict.fromkeys(option.faults, settings)
            return
        for step in option.cure:
            if _is_redeploy(step):
                self.configuration.redeploy(step.node)
                self.belief.exclude(fault.name for fault in self.faults.values() if (step,) in fault.cures)
            else:
                request(self, step)

    # What it hides from the segmentation

    def hidden(self) -> list[str]:
        """Return the faults that it keeps from the segmentation by doing without a sensor."""
        return [name for name, settings in self.in_place.items() if self.hides(name, settings)]

    def hides(self, name: str, settings: dict[Setting, Value]) -> bool:
        """Return whether a fault is taken to be there, and worked around without its sensor."""
        return MODALITY in settings and self.belief.is_certain(name)

    def look(self) -> None:
        """Return to both images for a moment, after cures that cost nothing of what would not show without."""
        self.is_looking = True
        self.configuration.want(self.wanted(), self.symptoms)
        failures = {self.faults[name].failure for name in self.hidden()}
        for fault in self.faults.values():
            (step, *others) = fault.cures[0]
            if (
                fault.failure in failures
                and fault.kind is FaultKind.INTERNAL
                and not others
                and step.parameter
            ):
                request(self, step)
                self.belief.exclude([fault.name])

    def hide(self, level: float) -> None:
        """End a look, or begin to do without a sensor, at a level of the signal."""
        self.is_looking, self.level = False, level
        self.next_look_s, self.look_s = self.now_s + self.look_s, 2 * self.look_s

    def wanted(self) -> dict[Setting, Value]:
        """Return the settings that work around what is wrong."""
        wanted: dict[Setting, Value] = {}
        for settings in self.in_place.values():
            wanted |= settings
        if self.is_looking:
            wanted.pop(MODALITY, None)
        booting = self.configuration.booting
        away = [topic for topic in WITHOUT if self.wiring.publisher[topic] in booting]
        return wanted | dict(WITHOUT[topic] for topic in away)


def _is_redeploy(step: Adaptation) -> bool:
    return step.kind is AdaptationKind.REDEPLOY
