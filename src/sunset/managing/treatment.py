"""One cure at a time for each failure that shows: what managing systems need that differ only in their choices."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import (
    Configuration,
    Setting,
    Thresholds,
    Waits,
    Wiring,
    healthy_settings,
    settings_of,
)
from sunset.system.vocabulary import (
    Adaptation,
    AdaptationKind,
    Failure,
    Value,
    current_system,
    full_name,
    redeploy,
    restart,
)

_PASSING_S: Final = 0.5
"""The time until a node that sends again is seen."""
_NEW_FRAMES_S: Final = 0.75
"""The time until a signal, a mean over 5 frames, is of new frames only."""
_UNCHANGED_S: Final = 0.3
"""The time in which a signal is mostly of frames from before a cure."""
_FORGETTING_S: Final = 8.0
"""The time after which a cure that did not help may be tried again: another fault may have come."""
_BETTER: Final = 0.05
"""The share of its value by which a signal must fall for a cure to stay in place."""


@dataclass(frozen=True, slots=True)
class Option:
    """A cure of a failure; as a text, its steps in words.

    Attributes:
        steps: the adaptations.
        faults: the names of the failure's faults that it cures; empty if the catalogue lists none.
        seconds: the time until its effect can be seen [s].
    """

    steps: tuple[Adaptation, ...]
    faults: tuple[str, ...]
    seconds: float

    def __str__(self) -> str:
        return " and ".join(map(str, self.steps))


@dataclass(slots=True)
class Trial:
    """A cure that was tried.

    Attributes:
        failure: the failure that it was to end.
        option: the cure.
        due_s: when its effect can be seen [s].
        before: the settings that it changed, with their values before.
        first: the worst value of the failure's signal before its effect, negated if low is bad.
        peak: the worst value since.
        helped: whether the failure is gone; None until that is known.
        kept: whether its settings stay, since the failure is gone or its signal is better; None until that is known.
    """

    failure: Failure
    option: Option
    due_s: float
    before: dict[Setting, Value]
    first: float
    peak: float
    helped: bool | None = None
    kept: bool | None = None


class Treatment:
    """Says which failure to treat now, and with which cures; performs a cure, and judges it when its effect shows.

    - A failure is treated when no topic upstream of it is silent, and no cure upstream of it waits for its effect.
    - A cure that does not improve its signal is undone.
    - A cure that did not end its failure is not offered again for 8 s.

    Args:
        manager: the managing system.

    Attributes:
        failures: the failures of the catalogue and the silences of other nodes, those furthest upstream first.
        showing: those of them that show.
    """

    def __init__(self, manager: ManagingSystem) -> None:
        self._manager = manager
        self._wiring, self._waits, self._thresholds = Wiring(), Waits(manager), Thresholds(manager)
        self._configuration, self._healthy = Configuration(manager), healthy_settings()
        self._trials: dict[str, Trial] = {}  # failure → its last cure, until that is judged
        self._tried_s: dict[tuple[str, Option], float] = {}
        self._badness: dict[str, float] = {}  # failure → its signal now
        self._badness_before: dict[str, float] = {}  # failure → its signal without the cure that is tried
        listed = [
            failure
            for failure in current_system().failures.values()
            if failure.signal or full_name(failure.topic) in self._wiring.topics
        ]
        watched = {full_name(failure.topic) for failure in listed if failure.topic}
        others = [_silence(topic) for topic in self._wiring.topics if topic not in watched]
        self.failures: tuple[Failure, ...] = tuple(
            sorted([*listed, *others], key=lambda failure: len(self._upstream(self.node(failure))))
        )
        self.showing: tuple[Failure, ...] = ()
        self._undoing: dict[Setting, Value] = {}
        self._options = {failure.name: tuple(self._offered(failure)) for failure in self.failures}

    def node(self, failure: Failure) -> str:
        """Return the node that a failure shows at."""
        if failure.topic:
            return self._wiring.publisher[full_name(failure.topic)]
        return current_system().signals[failure.signal].node

    def options(self, failure: Failure) -> tuple[Option, ...]:
        """Return all cures of a failure, those whose effect shows soonest first."""
        return self._options[failure.name]

    def untried(self, failure: Failure) -> tuple[Option, ...]:
        """Return the cures of a failure that were not tried in vain lately, and are not in place."""
        since_s = self._manager.now_s - _FORGETTING_S
        return tuple(
            option
            for option in self.options(failure)
            if self._tried_s.get((failure.name, option), since_s) <= since_s and not self._is_in_place(option)
        )

    def due(self, symptoms: Symptoms) -> Failure | None:
        """Judge the cures whose effect can be seen, and return the failure to treat now; None if there is none.

        Call it in every `adapt`.
        """
        self._configuration.see(symptoms)
        self.showing = tuple(failure for failure in self.failures if self._look(failure, symptoms))
        waiting = (failure for failure in self.showing if self.untried(failure))
        due = next((failure for failure in waiting if not self._is_blocked(failure)), None)
        if due is None:
            self._undo()
        return due

    def try_cure(self, failure: Failure, option: Option, *, think_s: float = 0.0) -> Trial:
        """Perform a cure of a failure, of `options` or of your own.

        Args:
            failure: the failure that is due.
            option: the cure.
            think_s: the time by which `think` has delayed it [s].
        """
        self._undo()  # not in `due`, after which a managing system may think
        settings = settings_of(option.steps) or {}
        before = {setting: self._configuration.get(setting) for setting in settings if setting[1]}
        for step in option.steps:
            if before.get((step.node, step.parameter)) is None or step.value is None:
                self._configuration.do(step)
            else:
                self._configuration.set((step.node, step.parameter), step.value)
        known = {setting: value for setting, value in before.items() if value is not None}
        due_s, badness = self._manager.now_s + think_s + option.seconds, self._badness[failure.name]
        trial = Trial(failure, option, due_s, known, badness, badness)
        self._trials[failure.name] = trial
        self._tried_s[failure.name, option] = self._manager.now_s
        return trial

    def _offered(self, failure: Failure) -> list[Option]:
        """Return the cures of a failure."""
        faults: dict[tuple[Adaptation, ...], list[str]] = {}
        for fault in current_system().faults.values():
            for cure in fault.cures if fault.failure == failure.name else ():
                faults.setdefault(cure, []).append(fault.name)
        if not faults:
            node = self.node(failure)
            faults = {(restart(node),): [], (redeploy(node),): []}
        options = [Option(cure, tuple(names), self._seconds(failure, cure)) for cure, names in faults.items()]
        return sorted(options, key=lambda option: option.seconds)

    def _seconds(self, failure: Failure, cure: Iterable[Adaptation]) -> float:
        boots = [self._wiring.boot_s[step.node] for step in cure if step.kind is AdaptationKind.REDEPLOY]
        shows_s = _PASSING_S if failure.topic else _NEW_FRAMES_S
        return sum(boots) + shows_s

    def _upstream(self, node: str) -> set[str]:
        """Return a node and the nodes upstream of it."""
        return {node, *(self._wiring.publisher[topic] for topic in self._wiring.topics_before(node))}

    def _is_in_place(self, option: Option) -> bool:
        """Return whether the settings of a cure are those that an earlier cure has set."""
        settings = {key: value for key, value in (settings_of(option.steps) or {}).items() if key[1]}
        return bool(settings) and all(
            self._configuration.get(key) == value != self._healthy.get(key) for key, value in settings.items()
        )

    def _is_blocked(self, failure: Failure) -> bool:
        """Return whether a cure of a failure, of its node or of a node upstream waits for its effect."""
        upstream = self._upstream(self.node(failure))
        return failure.name in self._trials or any(
            upstream.intersection(step.node for step in trial.option.steps)
            for trial in self._trials.values()
            if self._manager.now_s < trial.due_s
        )

    def _look(self, failure: Failure, symptoms: Symptoms) -> bool:
        """Judge the last cure of a failure, if its effect can be seen; return whether the failure shows."""
        shows = self._shows(failure, symptoms)
        trial = self._trials.get(failure.name)
        badness = self._thresholds.badness(failure.signal, symptoms) if failure.signal else 0.0
        self._badness[failure.name] = badness
        if trial is not None and shows is not None:
            self._judge(trial, shows, badness)
        if shows is False and failure.name not in self._trials:
            self._tried_s = {key: time_s for key, time_s in self._tried_s.items() if key[0] != failure.name}
            self._badness_before.pop(failure.name, None)
        return shows is True

    def _judge(self, trial: Trial, shows: bool, badness: float) -> None:
        """Note a failure's signal, and judge the cure if its effect can be seen."""
        now_s = self._manager.now_s
        trial.peak = max(trial.peak, badness)
        if now_s < trial.due_s - trial.option.seconds + _UNCHANGED_S:
            trial.first = trial.peak
        if now_s < trial.due_s:
            return
        del self._trials[trial.failure.name]
        # a fault that has just come raises the signal further in the first trial
        before = self._badness_before.get(trial.failure.name, trial.peak)
        trial.helped = not shows
        trial.kept = trial.helped or badness < before - _BETTER * abs(before)
        if trial.kept or not trial.before:
            self._badness_before[trial.failure.name] = badness
        else:  # what is undone may have raised the signal
            self._badness_before.setdefault(trial.failure.name, trial.first)
        if not trial.kept:
            self._undoing |= trial.before

    def _undo(self) -> None:
        """Set the settings of cures that were no use as they were before."""
        for setting, value in self._undoing.items():
            if self._configuration.get(setting) != value:
                self._configuration.set(setting, value)
        self._undoing = {}

    def _shows(self, failure: Failure, symptoms: Symptoms) -> bool | None:
        """Return whether a failure shows; None while that cannot be known."""
        if failure.topic:
            if not symptoms.stopped(failure.topic):
                return False
            return self._wiring.first_silent(symptoms) == self.node(failure) or None
        if any(map(symptoms.stopped, self._wiring.topics_until(self.node(failure)))):
            self._waits.start(failure.name, _NEW_FRAMES_S)
        return (
            self._thresholds.is_beyond(failure.signal, symptoms) if self._waits.over(failure.name) else None
        )


def _silence(topic: str) -> Failure:
    """Return the failure of a topic that no failure of the catalogue names."""
    return Failure(
        f"silence_of{topic.replace('/', '_')}",
        f"{topic} has no messages",
        symptom=f"no message on {topic} for 1 s",
        gone=f"messages on {topic} are back",
        topic=topic,
    )
