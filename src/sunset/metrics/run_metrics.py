"""The figures of a run (paper, section 4; `docs/metrics.md`)."""

import itertools
import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Annotated, Any, Final

import numpy as np
import numpy.typing as npt
from msgspec import Meta

from sunset.metrics.adaptations import ExecutedAdaptation, executed_adaptations, unnecessary_redeploys
from sunset.metrics.confusion import accumulated_iou
from sunset.metrics.episodes import Episode, failure_episodes
from sunset.metrics.timeline import MOST, TOLERANCE_S, Amount, Count, Injection, Share, Timeline, Tokens
from sunset.metrics.treatments import FaultOutcome, fault_outcomes, faults_of, treats
from sunset.system import RESULT_TOPIC, current_system
from sunset.texts.names import base_name

_SURE: Final = 0.5  # a diagnosis reports faults if the probability of at least one of them is at least this
_WINDOW_S: Final = 8.0  # a fault counts as diagnosed only within this time from its onset [s]
_LEVELS: Final = ("detected", "located", "identified", "top1")
_GAP_PERIODS: Final = 2  # a gap up to this many periods is the expected rate, with jitter


@dataclass(frozen=True, slots=True, kw_only=True)
class RunMetrics:
    """The figures of a run; None where a figure is not applicable. `docs/metrics.md` defines each by its name.

    Attributes:
        failures: the episodes, in order of time.
        executed: the adaptations, in order of time.
        outcomes: the outcome of each fault, in order of time.
        needless_adaptations: in order of time.
        models_asked: the language models that the managing system named in its costs.
    """

    f_resolved_per_adaptation: Amount | None
    t_react_s: Amount | None
    t_detect_s: Amount | None
    t_decide_s: Annotated[float, Meta(ge=-MOST, le=MOST)] | None
    t_repair_s: Amount | None
    redeploys_unnecessary: Count
    t_down_s: Amount
    availability: Share
    iou: Share | None
    iou_all: Share | None
    miou: Share | None
    episodes: Count
    episodes_resolved: Count
    episodes_unresolved: Count
    episodes_subsided: Count
    adaptations: Count
    faults_injected: Count
    faults_cured: Count | None
    faults_masked: Count | None
    masked_s: Amount | None
    uncured_s: Amount | None
    needless: Count
    cost_frames: Amount
    iou_healthy: Share | None
    utility: Annotated[float, Meta(ge=-MOST, le=1)] | None
    frames_without_truth: Count
    diagnoses: Count
    faults_detected: Count
    faults_located: Count
    faults_identified: Count
    faults_top1: Count
    t_detected_s: Amount | None
    t_located_s: Amount | None
    t_identified_s: Amount | None
    false_alarms: Count
    faultless_s: Amount
    brier: Share
    failures: tuple[Episode, ...] = ()
    executed: tuple[ExecutedAdaptation, ...] = ()
    outcomes: tuple[FaultOutcome, ...] = ()
    needless_adaptations: tuple[ExecutedAdaptation, ...] = ()
    tokens_in: Tokens | None = None
    tokens_out: Tokens | None = None
    price: Amount | None = None
    think_s: Amount | None = None
    models_asked: tuple[str, ...] = ()

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Return the names of the figures: all fields but the lists."""
        return tuple(field.name for field in fields(cls) if field.default != ())

    def to_json(self) -> dict[str, float | None]:
        """Return the figures by name."""
        return {name: getattr(self, name) for name in self.names()}


def utility_of(iou_all: float, cost_frames: float, iou_healthy: float, frames: int) -> float:
    """Return IoU_all less the cost of adaptations: their prices in frames, each of which is worth the healthy IoU.

    >>> utility_of(0.4, 10, 0.5, 200)
    0.375
    """
    return iou_all - cost_frames * iou_healthy / frames


def score(timeline: Timeline) -> RunMetrics:
    """Compute the figures of a run from its record."""
    executed = executed_adaptations(timeline.commands, until_s=timeline.duration_s)
    parts = [part for call in executed for part in call.parts]
    failures = failure_episodes(timeline, executed)
    faults = faults_of(timeline)
    sent = timeline.message_times.get(RESULT_TOPIC, np.empty(0))
    down_s = downtime(sent, period_s=timeline.period_s, duration_s=timeline.duration_s)
    cost = _cost(executed)
    quality = _quality_figures(timeline, faults, cost)
    outcomes, masked_s = fault_outcomes(timeline, faults, failures, parts, quality["iou_healthy"])
    needless = tuple(part for part in parts if not any(treats(part, fault) for fault in faults))
    frames, taken = timeline.frames, _is_measured(timeline.frames.times, timeline)
    return RunMetrics(
        **quality,
        miou=accumulated_iou(frames.intersection[taken], frames.predicted[taken], frames.truth[taken]),
        cost_frames=cost,
        t_down_s=down_s,
        availability=1.0 - down_s / timeline.duration_s,
        faults_injected=len(outcomes),
        faults_cured=sum(outcome.cured is not None for outcome in outcomes) if outcomes else None,
        faults_masked=None if masked_s is None else sum(bool(outcome.masked_s) for outcome in outcomes),
        masked_s=masked_s,
        uncured_s=_mean(outcome.uncured_s for outcome in outcomes),
        needless=len(needless),
        **_episode_figures(failures, executed),
        redeploys_unnecessary=len(unnecessary_redeploys(executed, timeline.injections)),
        adaptations=len(executed),
        **_diagnosis_figures(timeline, faults),
        **_cost_figures(timeline),
        failures=failures,
        executed=executed,
        outcomes=outcomes,
        needless_adaptations=needless,
    )


def utility(timeline: Timeline) -> float | None:
    """Return a run's utility as `score` does, without the other figures; counts of pixels may be missing."""
    executed = executed_adaptations(timeline.commands, until_s=timeline.duration_s)
    value: float | None = _quality_figures(timeline, faults_of(timeline), _cost(executed))["utility"]
    return value


def _cost(executed: Iterable[ExecutedAdaptation]) -> float:
    """Return the sum of the prices of adaptations, in frames."""
    return sum(current_system().price(part.kind) for call in executed for part in call.parts)


def downtime(times: npt.NDArray[np.float64], *, period_s: float, duration_s: float) -> float:
    """Return the total time in [0, `duration_s`] without messages at the expected rate.

    Every gap of more than two periods counts whole, as far as it lies in the experiment, also before the first message
    and after the last. The last message before 0 begins the first gap, which begins at 0 without such a message.

    Args:
        times: (N,) ascending, when messages left [s].
        period_s: the expected time between two messages.
        duration_s: the end of the experiment.

    Source: the paper, section 4, on the system's downtime.

    >>> downtime(np.array([0.0, 0.1, 0.2, 0.7, 0.8]), period_s=0.1, duration_s=2.0)
    1.7
    """
    before = times[times < 0]
    within = times[(times >= 0) & (times <= duration_s)]
    start = before[-1] if before.size else 0.0
    moments = np.concatenate([[start], within, [duration_s]])
    gaps = np.diff(moments)
    inside = np.diff(np.maximum(moments, 0.0))
    return round(float(inside[gaps > _GAP_PERIODS * period_s + TOLERANCE_S].sum()), 9)


def _quality_figures(timeline: Timeline, faults: Sequence[Injection], cost: float) -> dict[str, Any]:
    """Return the figures of the frames taken in [0, duration), and the healthy IoU."""
    frames = timeline.frames
    taken, unknown = (_is_measured(times, timeline) for times in (frames.times, timeline.without_truth))
    count, without_truth = int(taken.sum()), int(unknown.sum())
    # live, a frame's truth may be lost
    expected = max(timeline.expected_frames - without_truth, count) if timeline.has_truth else 0
    total = float(frames.iou[taken].sum())
    whole = total / expected if expected else None
    before = frames.iou[frames.times < faults[0].time] if faults else frames.iou
    before = before if len(before) else frames.iou
    healthy = float(before.mean()) if len(before) else None
    return {
        "iou": total / count if count else None,
        "iou_all": whole,
        "frames_without_truth": without_truth,
        "iou_healthy": healthy,
        "utility": None
        if whole is None or healthy is None
        else utility_of(whole, cost, healthy, timeline.expected_frames),
    }


def _is_measured(times: npt.NDArray[np.float64], timeline: Timeline) -> npt.NDArray[np.bool_]:
    return (times >= -TOLERANCE_S) & (times < timeline.duration_s - TOLERANCE_S)


def _episode_figures(failures: Sequence[Episode], executed: Sequence[ExecutedAdaptation]) -> dict[str, Any]:
    resolved = [episode for episode in failures if episode.resolved]
    return {
        "f_resolved_per_adaptation": len(resolved) / len(executed) if executed else None,
        "t_react_s": _mean(episode.t_react for episode in resolved),
        "t_detect_s": _mean(episode.t_detect for episode in resolved),
        "t_decide_s": _mean(episode.t_decide for episode in resolved),
        "t_repair_s": _mean(episode.t_repair for episode in resolved),
        "episodes": len(failures),
        "episodes_resolved": len(resolved),
        "episodes_unresolved": len(failures) - len(resolved),
        "episodes_subsided": sum(episode.subsided for episode in failures),
    }


def _diagnosis_figures(timeline: Timeline, faults: Sequence[Injection]) -> dict[str, Any]:
    """Return the figures of a run's diagnoses.

    A diagnosis holds until the next diagnosis; before the first, all probabilities are 0. `faults` has each fault, each
    time that it came.
    """
    catalogue = current_system().faults
    delays: list[dict[str, float]] = [{} for _ in faults]  # level that a fault reached → time since its onset
    alarms, faultless_s, squares, is_alarmed = 0, 0.0, 0.0, False
    for start, stop, named in _stretches(timeline, faults):
        present = [
            (fault, delay) for fault, delay in zip(faults, delays, strict=True) if fault.is_there(start)
        ]
        names = {fault.fault for fault, _ in present}
        squares += (stop - start) * sum((named.get(name, 0.0) - (name in names)) ** 2 for name in catalogue)
        was_alarmed, is_alarmed = is_alarmed, _reports(named.values())
        if not present:
            faultless_s += stop - start
            alarms += is_alarmed and not was_alarmed
        for fault, delay in present:
            if start < fault.time + _WINDOW_S:
                reached = dict.fromkeys(_levels(fault, named, len(names)), start - fault.time)
                known = {level: after for level, after in delay.items() if level in reached}
                delay.clear()  # a level counts if it is kept to the end of the window
                delay.update(reached | known)
    times = {level: [delay[level] for delay in delays if level in delay] for level in _LEVELS}
    return {
        "diagnoses": sum(diagnosis.time < timeline.duration_s for diagnosis in timeline.diagnoses),
        **{f"faults_{level}": len(reached) for level, reached in times.items()},
        **{f"t_{level}_s": _mean(times[level]) for level in _LEVELS[:-1]},
        "false_alarms": alarms,
        "faultless_s": round(faultless_s, 9),
        "brier": min(1.0, squares / timeline.duration_s / len(catalogue)),
    }


def _cost_figures(timeline: Timeline) -> dict[str, Any]:
    """Return the sums of the costs of decisions; nothing if none was published."""
    costs = [cost for cost in timeline.costs if cost.time < timeline.duration_s]
    if not costs:
        return {}
    return {
        **{name: sum(getattr(cost, name) for cost in costs) for name in ("tokens_in", "tokens_out")},
        **{
            name: min(MOST, math.fsum(getattr(cost, name) for cost in costs)) for name in ("price", "think_s")
        },
        "models_asked": tuple(dict.fromkeys(cost.model for cost in costs if cost.model)),
    }


def _levels(fault: Injection, named: Mapping[str, float], number: int) -> Iterator[str]:
    """Return the levels that a diagnosis reaches for one of a number of present faults."""
    catalogue, node = current_system().faults, base_name(fault.node)
    probability = named.get(fault.fault, 0.0)
    reached = (
        _reports(named.values()),
        _reports(sure for name, sure in named.items() if catalogue[name].node == node),
        _reports([probability]),
        probability > 0 and sum(other >= probability for other in named.values()) <= number,
    )
    return itertools.compress(_LEVELS, reached)


def _stretches(
    timeline: Timeline, faults: Sequence[Injection]
) -> Iterator[tuple[float, float, Mapping[str, float]]]:
    """Yield the stretches of time in which nothing changes, with their probabilities."""
    catalogue, end = current_system().faults, timeline.duration_s
    times = [diagnosis.time for diagnosis in timeline.diagnoses]
    moments = {0.0, end, *times}
    for fault in faults:
        moments |= {fault.time, fault.time + _WINDOW_S, end if fault.ended is None else fault.ended}
    for start, stop in itertools.pairwise(sorted(moment for moment in moments if 0 <= moment <= end)):
        place = bisect_right(times, start)
        published = timeline.diagnoses[place - 1].probabilities if place else {}
        # other publishers may send unknown names and numbers that are not probabilities
        named = {name: sure for name, sure in published.items() if name in catalogue and 0 <= sure <= 1}
        yield start, stop, named


def _reports(probabilities: Iterable[float]) -> bool:
    """Return whether a diagnosis reports a set of faults with these probabilities, as if they were independent.

    >>> _reports([0.3, 0.3]), _reports([0.3, 0.2]), _reports([])
    (True, False, False)
    """
    return 1 - math.prod(1 - probability for probability in probabilities) >= _SURE


def _mean(values: Iterable[float | None]) -> float | None:
    """Return the mean of the known values, rounded to nanoseconds; None without a value."""
    known = [value for value in values if value is not None]
    return round(sum(known) / len(known), 9) if known else None
