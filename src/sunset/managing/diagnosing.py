"""A managing system that reasons: it has a probability for each fault, and learns from the effects of adaptations."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from math import exp, prod
from typing import Final

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import (
    Configuration,
    Setting,
    configuration_faults,
    request,
    settings_of,
    settings_without,
    view_setting,
)
from sunset.managing.watching import NEW_FRAMES_S, PASSING_S, Watch
from sunset.system.vocabulary import (
    PERIOD_S,
    REPAIR,
    Adaptation,
    AdaptationKind,
    Failure,
    Fault,
    FaultKind,
    Value,
    current_system,
    full_name,
)

_BLIND_S: Final = 1.0
"""Cost of doing without a sensor, in seconds of output."""
_LOOK_S: Final = 20.0
"""Time from hiding a sensor to a look at it. A look costs c = 0.6 s of output: two parameters and a few bad frames. A
sensor that is hidden in vain costs a tenth of the output, g = 0.1, and a fault heals once in 1 / r = 30 s. So the mean
cost is c / T + r g T / 2, which is least at T = sqrt(2 c / (r g)) = 20 s."""
_NOTABLE: Final = 0.015
"""A signal that falls by less has not become better: the scene changes it by as much."""
_DOUBTFUL: Final = 0.05
"""The probability that a fault has healed, from which on its workaround may be lifted."""
_LIKELY: Final = 0.5
"""The probability from which on a fault counts as present."""
_RARE: Final = 0.01
"""Probability of a fault without a symptom."""
_USUAL: Final = 0.1
"""Prior probability of each suspect of a symptom."""
_PLAUSIBLE: Final = 0.08
"""The least joint prior probability of plausible suspects."""
_EXCLUDED: Final = 0.002
_CERTAIN: Final = 0.97
_HEALED: Final = 0.25
"""Probability, in the long run, that a confirmed fault has healed."""
_FORGETTING_S: Final = 8.0
"""Time constant with which exclusions and confirmations decay, since a fault may come again or heal."""

Cure = tuple[Adaptation, ...]


class Belief:
    """The probabilities of independent faults, at least one of which causes each symptom.

    Args:
        faults: the names of all possible faults.

    >>> belief = Belief(["camera_driver_issue", "hardware_disconnect"])
    >>> belief.suspect("F1", ["camera_driver_issue", "hardware_disconnect"])
    >>> round(belief.probability("hardware_disconnect"), 2)
    0.53
    >>> belief.exclude(["camera_driver_issue"])  # a restart did not help
    >>> round(belief.probability("hardware_disconnect"), 2)
    0.98
    """

    def __init__(self, faults: Iterable[str]) -> None:
        self._alone = dict.fromkeys(faults, _USUAL)
        self._suspects: dict[str, frozenset[str]] = {}
        self._healed: dict[str, float] = {}  # of confirmed faults

    def probability(self, fault: str) -> float:
        """Return the probability that a fault is present, for a suspect given that at least one suspect is."""
        alone = self._alone[fault]
        if self.is_certain(fault):
            return alone
        for suspects in self._suspects.values():
            if fault in suspects:
                return alone / (1 - prod(1 - self._alone[name] for name in sorted(suspects)))
        return min(alone, _RARE)

    def probability_of_any(self, faults: Iterable[str]) -> float:
        """Return the probability that at least one of some faults is present."""
        return 1 - prod(1 - self.probability(fault) for fault in faults)

    def suspect(self, failure: str, faults: Collection[str]) -> None:
        """Note a symptom of a failure, which at least one of some faults must cause."""
        self._suspects[failure] = frozenset(faults)

    def is_plausible(self, faults: Iterable[str]) -> bool:
        """Return whether some faults were not all excluded a moment ago."""
        return 1 - prod(1 - self._alone[fault] for fault in faults) > _PLAUSIBLE

    def settle(self, failure: str, faults: Iterable[str]) -> None:
        """Note that the symptom of a failure is gone; each of its faults may come next."""
        self._suspects.pop(failure, None)
        self._alone |= {fault: _USUAL for fault in faults if not self.is_certain(fault)}

    def exclude(self, faults: Iterable[str]) -> None:
        """Note that faults are not present, or not any more."""
        self._alone |= dict.fromkeys(faults, _EXCLUDED)

    def confirm(self, fault: str) -> None:
        """Note that a fault is present, whether it shows or not, until it is excluded."""
        self._alone[fault] = _CERTAIN
        self._healed[fault] = 0.0

    def is_certain(self, fault: str) -> bool:
        """Return whether a fault was confirmed."""
        return self._alone[fault] >= _CERTAIN

    def probability_healed(self, fault: str) -> float:
        """Return the probability that a confirmed fault has healed since."""
        return self._healed.get(fault, 0.0)

    def forget(self, seconds: float) -> None:
        """Let time pass: excluded faults may come, and confirmed faults may heal."""
        share = exp(-seconds / _FORGETTING_S)
        for fault, alone in self._alone.items():
            if alone < _USUAL:
                self._alone[fault] = _USUAL - (_USUAL - alone) * share
        for fault, healed in self._healed.items():
            self._healed[fault] = _HEALED - (_HEALED - healed) * share


@dataclass(frozen=True)
class _Option:
    """A possible action: a cure of some faults or, without a cure, lifting the workaround of a fault."""

    faults: tuple[str, ...]
    cure: Cure
    wait_s: float  # until its effect can be seen
    probability: float = 1.0  # of success
    cost_s: float = 1.0  # in seconds of output


@dataclass(frozen=True)
class _Trial:
    option: _Option
    before: float  # how bad the signal was
    due_s: float  # when its effect can be seen
    released: dict[Setting, Value]  # the workaround that it lifts


class Diagnosing(ManagingSystem):
    """Has a probability for each fault, by symptoms and effects of adaptations, and tries the most promising cures.

    It knows the catalogue: which faults show as which failure, and the cures of each fault. A failure that shows makes
    all of its faults suspects. It tries the cure with the highest probability of success, divided by the time until its
    effect can be seen. A cure without effect is undone, and excludes the faults that it would have cured.

    - The node to repair is the node that gets all of its inputs and sends nothing. While a sensor boots or has stopped,
      the segmentation takes the others.
    - A configuration fault needs no symptom: its parameter is read.
    - The workaround of an external fault stays in place. It is lifted when it may cause a symptom, and otherwise so
      rarely that it pays.
    """

    def on_start(self) -> None:
        """Begin without suspects."""
        self.faults, self.failures = current_system().faults, current_system().failures
        self.view, self.without = view_setting(), settings_without()
        self.belief = Belief(self.faults)
        self.configuration = Configuration(self)
        self.watch = Watch(self, self.configuration)
        self.trials: dict[str, _Trial] = {}  # by failure
        self.in_place: dict[str, dict[Setting, Value]] = {}  # fault → its workaround
        self.showing: set[str] = set()  # failures that were seen and have not gone since
        self.look_s: dict[str, float] = {}  # fault whose sensor is hidden → when to look at it again
        self.last_s, self.diagnosis = self.now_s, dict[str, float]()
        self.suspected: dict[str, float] = {}  # fault → its probability before its cure is tried now
        self.may_adapt = self.greeting["task"] == REPAIR

    def adapt(self, symptoms: Symptoms) -> None:
        """Treat the failures that show, and publish the probabilities of faults, for treated faults before the cure."""
        self.symptoms = symptoms
        self.belief.forget(self.now_s - self.last_s)
        self.last_s = self.now_s
        self.configuration.see(symptoms)
        self.watch.see(symptoms)
        self.correct()
        for failure in self.failures.values():
            self.treat(failure)
        self.configuration.want(self.wanted(), symptoms)
        believed = {name: self.belief.probability(name) for name in self.faults} | self.suspected
        diagnosis = {name: round(probability, 2) for name, probability in believed.items()}
        self.suspected = {}
        if diagnosis != self.diagnosis:
            self.diagnosis = diagnosis
            self.diagnose(diagnosis)

    def correct(self) -> None:
        """Restore wrong parameters, as far as they can be read."""
        self.configuration.read()
        for fault in configuration_faults():
            is_wrong = self.configuration.is_wrong(fault)
            if is_wrong is not None:
                self.belief.exclude([fault.name])
            if is_wrong:
                self.suspected[fault.name] = 1.0
                if self.may_adapt and fault.healthy is not None:
                    self.configuration.set((fault.node, fault.parameter), fault.healthy)
                    self.wait_for(self.failures[fault.failure])

    def wait_for(self, failure: Failure) -> None:
        """Wait for the effect of an adaptation before treating a failure."""
        due_s = self.now_s + NEW_FRAMES_S
        trial = self.trials.get(failure.name, _Trial(_Option((), (), 0.0), 0.0, due_s, {}))
        self.trials[failure.name] = replace(trial, due_s=due_s)

    def treat(self, failure: Failure) -> None:
        """Judge a trial that is over, and begin the next if the failure shows."""
        shows, trial = self.watch.shows(failure), self.trials.get(failure.name)
        is_over = trial is None or self.now_s >= trial.due_s or self.watch.is_back(failure)
        if shows is None or not is_over:
            return
        if trial is not None:
            self.judge(failure, self.trials.pop(failure.name), shows=shows)
        faults = [fault for fault in self.faults.values() if fault.failure == failure.name]
        if shows:
            self.try_best(failure, faults)
        else:
            self.conclude(failure, faults)

    def judge(self, failure: Failure, trial: _Trial, *, shows: bool) -> None:
        """Learn from a trial, and undo a cure without effect."""
        has_helped = not shows or self.watch.badness(failure) < trial.before - _NOTABLE
        if failure.topic:
            self.watch.end_repair(full_name(failure.topic))
        for name in trial.option.faults:
            settings = self.in_place.get(name, {})
            if trial.released and not has_helped:
                self.keep(name, trial.released)
            elif self.view in settings and self.belief.probability(name) > _LIKELY:
                self.keep(name, settings)  # it has not helped, but other suspects are missing
            elif settings and has_helped and self.view not in settings:
                self.belief.confirm(name)
            elif failure.topic or settings or trial.released:
                self.in_place.pop(name, None)
                self.belief.exclude([name])

    def keep(self, name: str, settings: dict[Setting, Value]) -> None:
        """Keep the workaround of a fault that is present."""
        self.in_place[name] = settings
        self.belief.confirm(name)
        if self.view in settings:
            self.look_s[name] = self.now_s + _LOOK_S
            self.prevent(self.faults[name].failure)

    def prevent(self, failure: str) -> None:
        """Cure plausible faults that would not show while a sensor is hidden, if a single parameter cures them."""
        for fault in self.faults.values():
            steps = fault.cures[0] if fault.kind is FaultKind.INTERNAL and fault.failure == failure else ()
            if len(steps) == 1 and steps[0].parameter and self.belief.is_plausible([fault.name]):
                request(self, steps[0])
                self.belief.exclude([fault.name])

    def conclude(self, failure: Failure, faults: list[Fault]) -> None:
        """Exclude the faults of a failure that would show if they were present, and look at hidden faults."""
        proven = [fault.name for fault in faults if self.watch.sees(fault, is_conclusive=True)]
        self.showing.discard(failure.name)
        if len(proven) == len(faults):
            self.belief.settle(failure.name, proven)
        else:
            self.belief.exclude(name for name in proven if name not in self.in_place)
        for fault in faults:
            is_hidden = self.view in self.in_place.get(fault.name, {})
            if is_hidden and self.now_s > self.look_s.get(fault.name, self.now_s):
                self.begin(failure, _Option((fault.name,), (), NEW_FRAMES_S))
                return

    def try_best(self, failure: Failure, faults: list[Fault]) -> None:
        """Try the option with the highest probability of success for its cost."""
        seen = [fault for fault in faults if self.watch.sees(fault) and fault.name not in self.in_place]
        suspects = [fault for fault in seen if self.configuration.is_wrong(fault) is not False]
        names = [fault.name for fault in suspects]
        if failure.name not in self.showing and not self.belief.is_plausible(names):
            self.belief.settle(failure.name, names)  # the failure has come since they were excluded
        self.showing.add(failure.name)
        self.belief.suspect(failure.name, names)
        self.suspected |= {name: self.belief.probability(name) for name in names}
        if not self.may_adapt:
            return
        options = list(self.releases(faults))
        if self.belief.is_plausible(names):
            options += self.cures(suspects)
        if options:
            self.begin(failure, max(options, key=lambda option: option.probability / option.cost_s))

    def begin(self, failure: Failure, option: _Option) -> None:
        """Begin a trial."""
        released = {} if option.cure else self.in_place.pop(option.faults[0])
        self.do(option)
        if failure.topic:
            self.watch.begin_repair(full_name(failure.topic))
        elif option.cure and not self.lasts(option.faults):
            self.belief.exclude(option.faults)  # from now on, whenever the effect can be seen
        badness = self.watch.badness(failure)
        self.trials[failure.name] = _Trial(option, badness, self.now_s + option.wait_s, released)

    def cures(self, suspects: list[Fault]) -> Iterator[_Option]:
        """Yield the possible cures of some faults."""
        for cure in dict.fromkeys(cure for fault in suspects for cure in fault.cures):
            if all(self.is_up(step) for step in cure):
                names = tuple(fault.name for fault in suspects if cure in fault.cures)
                wait_s = self.wait_s(cure)
                cost_s = self.cost_s(cure, names, wait_s)
                yield _Option(names, cure, wait_s, self.belief.probability_of_any(names), cost_s)

    def releases(self, faults: list[Fault]) -> Iterator[_Option]:
        """Yield the lifting of workarounds whose faults may have healed."""
        for fault in faults:
            healed = self.belief.probability_healed(fault.name)
            if healed > _DOUBTFUL and self.view not in self.in_place.get(fault.name, {self.view: 0}):
                yield _Option((fault.name,), (), NEW_FRAMES_S, healed, NEW_FRAMES_S)

    def is_up(self, step: Adaptation) -> bool:
        """Return whether a step is possible: only a redeploy brings back a node without a process."""
        is_there = self.symptoms.state(step.node) != "unknown" or step.kind is AdaptationKind.REDEPLOY
        return is_there and step.node not in self.configuration.booting

    def wait_s(self, cure: Cure) -> float:
        """Return the time until the effect of a cure can be seen [s]."""
        boots = [self.configuration.boot_s[step.node] for step in cure if _is_redeploy(step)]
        is_restart = all(step.kind is AdaptationKind.RESTART for step in cure)
        return max(boots, default=0.0) + (PASSING_S if is_restart else NEW_FRAMES_S)

    def cost_s(self, cure: Cure, names: tuple[str, ...], wait_s: float) -> float:
        """Return the cost of trying a cure, and of undoing it [s]."""
        cost_s = wait_s + sum(current_system().price(step.kind) * PERIOD_S for step in cure)
        hides = any((step.node, step.parameter) == self.view for step in cure)
        return (2 * cost_s if self.lasts(names) else cost_s) + (_BLIND_S if hides else 0.0)

    def lasts(self, names: tuple[str, ...]) -> bool:
        """Return whether a cure must stay in place, since one of the faults is external."""
        return any(self.faults[name].kind is FaultKind.EXTERNAL for name in names)

    def do(self, option: _Option) -> None:
        """Request a cure; the workaround of an external fault is set as long as it is in place."""
        settings = settings_of(option.cure)
        if self.lasts(option.faults) and settings:
            self.in_place |= dict.fromkeys(option.faults, settings)
            return
        for step in option.cure:
            self.configuration.do(step)
            if _is_redeploy(step):
                self.belief.exclude(fault.name for fault in self.faults.values() if (step,) in fault.cures)

    def wanted(self) -> dict[Setting, Value]:
        """Return the settings of all workarounds."""
        wanted: dict[Setting, Value] = {}
        for settings in self.in_place.values():
            wanted |= settings
        return wanted | dict(self.without[topic] for topic in filter(self.watch.is_away, self.without))


def _is_redeploy(step: Adaptation) -> bool:
    return step.kind is AdaptationKind.REDEPLOY
