"""One run's figures (paper, section 4; `docs/metrics.md`): what the table is made of."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from typing import Annotated

import numpy as np
from msgspec import Meta

from sunset.metrics.adaptations import ExecutedAdaptation, executed_adaptations, unnecessary_redeploys
from sunset.metrics.confusion import accumulated_iou
from sunset.metrics.diagnoses import DiagnosisFigures, diagnosis_figures, mean
from sunset.metrics.downtime import TOLERANCE_S, downtime
from sunset.metrics.episodes import Episode, failure_episodes
from sunset.metrics.limits import MOST, Amount, Count, Share
from sunset.metrics.timeline import Injection, Timeline
from sunset.metrics.treatments import FaultOutcome, fault_outcomes, faults_of, needless_adaptations
from sunset.system import RESULT_TOPIC, current_system


@dataclass(frozen=True, slots=True, kw_only=True)
class RunMetrics(DiagnosisFigures):
    """The figures of one run, those of its diagnoses included; None where there is nothing to take one of.

    Attributes:
        f_resolved_per_adaptation: resolved episodes over executed adaptations; None without adaptation.
        t_react_s: mean over resolved episodes, from when the failure began to the command [s].
        t_detect_s: likewise, from when it began to when its symptom held.
        t_decide_s: likewise, from when its symptom held to the command.
        t_repair_s: likewise, from the command to when the symptom was gone.
        redeploys_unnecessary: redeploys of a node that had no fault only a redeploy cures.
        t_down_s: time without segmentation at the expected rate [s].
        availability: the share of the experiment that is not `t_down_s`, in [0, 1].
        iou: mean over evaluated frames of each frame's IoU.
        iou_all: the same over all frames of the experiment that have a truth, those that never came being 0.
        miou: of the counts of all evaluated frames added up.
        episodes: how many episodes of failures there were.
        episodes_resolved: those that an adaptation ended.
        episodes_unresolved: all others.
        episodes_subsided: those of the others that ended by themselves.
        adaptations: how many adaptations were executed.
        faults_injected: how many faults came.
        faults_cured: how many of them were cured; None without a fault.
        faults_masked: how many were masked for some time; None without a fault, and without a truth.
        masked_s: time in which any fault was masked [s]; likewise.
        uncured_s: mean over faults of the time in which they were there without a cure in place [s].
        needless: the adaptations that are no step of a cure of a fault that was there.
        cost_frames: the prices of all adaptations, in frames.
        iou_healthy: mean over the frames before the first fault of each frame's IoU.
        utility: `iou_all` less the share of `cost_frames` in all frames, times `iou_healthy`: scores are made of it.
        frames_without_truth: how many frames have no pixel of a known class, and count for no figure of quality.
        failures: the episodes, in order of time.
        executed: the adaptations, in order of time.
        outcomes: what became of each fault, in order of time.
        needless_adaptations: the needless ones, in order of time.
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
    failures: tuple[Episode, ...] = ()
    executed: tuple[ExecutedAdaptation, ...] = ()
    outcomes: tuple[FaultOutcome, ...] = ()
    needless_adaptations: tuple[ExecutedAdaptation, ...] = ()

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Return the names of the figures: all fields but the lists of episodes, adaptations and outcomes."""
        figures = [field.name for field in fields(cls) if field.default != ()]
        others = len(fields(DiagnosisFigures))
        return (*figures[others:], *figures[:others])

    def to_json(self) -> dict[str, float | None]:
        """Return the figures by name."""
        return {name: getattr(self, name) for name in self.names()}


def utility_of(iou_all: float, cost_frames: float, iou_healthy: float, frames: int) -> float:
    """Return IoU_all less what adaptations cost: their prices in frames, each worth the healthy IoU.

    >>> utility_of(0.4, 10, 0.5, 200)
    0.375
    """
    return iou_all - cost_frames * iou_healthy / frames


def score(timeline: Timeline) -> RunMetrics:
    """Compute the figures of one run from what was recorded from outside."""
    executed = executed_adaptations(timeline.commands, until_s=timeline.duration_s)
    failures = failure_episodes(timeline, executed)
    resolved = [episode for episode in failures if episode.resolved]
    down = downtime(
        timeline.message_times.get(RESULT_TOPIC, np.empty(0)),
        period_s=timeline.period_s,
        duration_s=timeline.duration_s,
    )
    iou, iou_all, miou, without_truth = _frame_figures(timeline)
    faults = faults_of(timeline)
    healthy = _healthy_iou(timeline, faults)
    parts = [part for call in executed for part in call.parts]
    found, masked_s = fault_outcomes(timeline, faults, failures, parts, healthy)
    needless = needless_adaptations(parts, faults)
    cost = sum(current_system().price(part.kind) for part in parts)
    return RunMetrics(
        f_resolved_per_adaptation=len(resolved) / len(executed) if executed else None,
        t_react_s=mean([episode.t_react for episode in resolved]),
        t_detect_s=mean([episode.t_detect for episode in resolved]),
        t_decide_s=mean([episode.t_decide for episode in resolved]),
        t_repair_s=mean([episode.t_repair for episode in resolved]),
        redeploys_unnecessary=len(unnecessary_redeploys(executed, timeline.injections)),
        t_down_s=down,
        availability=1.0 - down / timeline.duration_s,
        iou=iou,
        iou_all=iou_all,
        miou=miou,
        episodes=len(failures),
        episodes_resolved=len(resolved),
        episodes_unresolved=len(failures) - len(resolved),
        episodes_subsided=sum(episode.subsided for episode in failures),
        adaptations=len(executed),
        faults_injected=len(found),
        faults_cured=sum(outcome.cured is not None for outcome in found) if found else None,
        faults_masked=None if masked_s is None else sum(bool(outcome.masked_s) for outcome in found),
        masked_s=masked_s,
        uncured_s=mean([outcome.uncured_s for outcome in found]),
        needless=len(needless),
        cost_frames=cost,
        iou_healthy=healthy,
        utility=None
        if iou_all is None or healthy is None
        else utility_of(iou_all, cost, healthy, timeline.expected_frames),
        **asdict(diagnosis_figures(timeline, faults)),
        frames_without_truth=without_truth,
        failures=failures,
        executed=executed,
        outcomes=found,
        needless_adaptations=needless,
    )


def _healthy_iou(timeline: Timeline, faults: Sequence[Injection]) -> float | None:
    """Return the mean IoU of the frames before the first fault, the warm-up's included; of all, if it has none."""
    frames = timeline.frames
    before = frames.iou[frames.times < faults[0].time] if faults else frames.iou
    return float(before.mean()) if len(before) else float(frames.iou.mean()) if len(frames.iou) else None


def _frame_figures(timeline: Timeline) -> tuple[float | None, float | None, float | None, int]:
    """Return IoU, IoU_all and mIoU of the frames taken in [0, duration), and how many of those lack a truth."""
    frames = timeline.frames
    taken, unknown = (
        (times >= -TOLERANCE_S) & (times < timeline.duration_s - TOLERANCE_S)
        for times in (frames.times, timeline.without_truth)
    )
    count, without_truth = int(taken.sum()), int(unknown.sum())
    expected = max(timeline.expected_frames - without_truth, count)
    if not timeline.has_truth:
        expected = 0  # live, a frame's truth may be lost
    total = float(frames.iou[taken].sum())
    return (
        total / count if count else None,
        total / expected if expected else None,
        accumulated_iou(frames.intersection[taken], frames.predicted[taken], frames.truth[taken]),
        without_truth,
    )
