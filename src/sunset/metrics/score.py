"""The figures of a run (paper, section 4; `docs/metrics.md`)."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Annotated, Any, Final

import numpy as np
import numpy.typing as npt
from msgspec import Meta

from sunset.metrics.adaptations import ExecutedAdaptation, executed_adaptations, unnecessary_redeploys
from sunset.metrics.confusion import accumulated_iou
from sunset.metrics.diagnoses import diagnosis_figures, mean
from sunset.metrics.episodes import Episode, failure_episodes
from sunset.metrics.timeline import MOST, TOLERANCE_S, Amount, Count, Injection, Share, Timeline
from sunset.metrics.treatments import FaultOutcome, fault_outcomes, faults_of, needless_adaptations
from sunset.system import RESULT_TOPIC, current_system

_GAP_PERIODS: Final = 2  # a gap up to this many periods is the expected rate, with jitter


@dataclass(frozen=True, slots=True, kw_only=True)
class RunMetrics:
    """The figures of a run; None where a figure is not applicable. `docs/metrics.md` defines each by its name.

    Attributes:
        failures: the episodes, in order of time.
        executed: the adaptations, in order of time.
        outcomes: the outcome of each fault, in order of time.
        needless_adaptations: in order of time.
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
    cost = sum(current_system().price(part.kind) for part in parts)
    quality = _quality_figures(timeline, faults, cost)
    outcomes, masked_s = fault_outcomes(timeline, faults, failures, parts, quality["iou_healthy"])
    needless = needless_adaptations(parts, faults)
    return RunMetrics(
        **quality,
        cost_frames=cost,
        t_down_s=down_s,
        availability=1.0 - down_s / timeline.duration_s,
        faults_injected=len(outcomes),
        faults_cured=sum(outcome.cured is not None for outcome in outcomes) if outcomes else None,
        faults_masked=None if masked_s is None else sum(bool(outcome.masked_s) for outcome in outcomes),
        masked_s=masked_s,
        uncured_s=mean(outcome.uncured_s for outcome in outcomes),
        needless=len(needless),
        **_episode_figures(failures, executed),
        redeploys_unnecessary=len(unnecessary_redeploys(executed, timeline.injections)),
        adaptations=len(executed),
        **diagnosis_figures(timeline, faults),
        failures=failures,
        executed=executed,
        outcomes=outcomes,
        needless_adaptations=needless,
    )


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
    taken, unknown = (
        (times >= -TOLERANCE_S) & (times < timeline.duration_s - TOLERANCE_S)
        for times in (frames.times, timeline.without_truth)
    )
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
        "miou": accumulated_iou(frames.intersection[taken], frames.predicted[taken], frames.truth[taken]),
        "frames_without_truth": without_truth,
        "iou_healthy": healthy,
        "utility": None
        if whole is None or healthy is None
        else utility_of(whole, cost, healthy, timeline.expected_frames),
    }


def _episode_figures(failures: Sequence[Episode], executed: Sequence[ExecutedAdaptation]) -> dict[str, Any]:
    resolved = [episode for episode in failures if episode.resolved]
    return {
        "f_resolved_per_adaptation": len(resolved) / len(executed) if executed else None,
        "t_react_s": mean(episode.t_react for episode in resolved),
        "t_detect_s": mean(episode.t_detect for episode in resolved),
        "t_decide_s": mean(episode.t_decide for episode in resolved),
        "t_repair_s": mean(episode.t_repair for episode in resolved),
        "episodes": len(failures),
        "episodes_resolved": len(resolved),
        "episodes_unresolved": len(failures) - len(resolved),
        "episodes_subsided": sum(episode.subsided for episode in failures),
    }
