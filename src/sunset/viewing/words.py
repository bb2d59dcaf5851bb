"""A run in sentences, for a reader who sees SUNSET for the first time."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from sunset.metrics import Episode, ExecutedAdaptation, RunMetrics
from sunset.recording import RunRecord, StoredRun
from sunset.recording.story import remaining_failures
from sunset.texts.sentences import counted, listed

_AT_ONCE_S: Final = 0.1  # faults within this time were injected together
_MOST: Final = 4  # adaptations that are listed
_DONE: Final = {
    "restart": "restarted",
    "redeploy": "redeployed",
    "activate": "activated",
    "deactivate": "deactivated",
    "configure": "configured",
    "cleanup": "cleaned up",
}
_NUMBERS: Final = ("No", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine", "Ten")


def described(run: RunRecord) -> str:
    """Return a run's settings in a line, without the managing system."""
    return f"seed {run.seed} · model {run.model} · middleware {run.middleware} · {run.duration_s:g} s"


def story(run: StoredRun) -> list[str]:
    """Return the faults, the adaptations and the results of a run, a sentence each."""
    return [*_injected(run), _adapted(run), *_results(run)]


def compared(first: StoredRun, second: StoredRun) -> list[str]:
    """Return the differences between two runs of the same scenario and seed, a sentence each."""
    names = f"A ({first.record.manager})", f"B ({second.record.manager})"
    metrics, others = first.metrics, second.metrics
    sentences = [
        f"The same faults, flight and seed, managed by {names[0]} and by {names[1]}.",
        _quality(metrics.iou_all, others.iou_all, names),
        f"No segmentation came for {metrics.t_down_s:.1f} s of A, and for {others.t_down_s:.1f} s of B.",
        f"A resolved {_resolved(metrics)}, B {_resolved(others)}.",
    ]
    if metrics.episodes != others.episodes:
        sentences.append(
            "The same faults gave different numbers of failures, since one failure may hide or bring about another."
        )
    if first.record.model != second.record.model:
        sentences.append(f"The models differ, too: {first.record.model} and {second.record.model}.")
    return sentences


def _quality(iou: float | None, other: float | None, names: tuple[str, str]) -> str:
    if iou is None or other is None:
        return "The flight has no labels, so that there is no IoU to compare."
    meaning = "the IoU, which says how well labels agree with the truth and is 0 for a lost frame,"
    if round(iou, 2) == round(other, 2):
        return f"In both, {meaning} is {iou:.2f}."
    better = names[0] if iou > other else names[1]
    return f"With {better}, {meaning} is higher: {max(iou, other):.2f} against {min(iou, other):.2f}."


def _resolved(metrics: RunMetrics) -> str:
    episodes = counted(metrics.episodes, "failure episode")
    return f"{metrics.episodes_resolved} of {episodes} with {counted(metrics.adaptations, 'adaptation')}"


def outcome_of(episode: Episode) -> str:
    """Return the end of an episode, in words."""
    if episode.ended is None:
        return "held to the end"
    if episode.adaptation is None:
        return f"ended by itself at {episode.ended:.2f} s"
    return (
        f"resolved by '{episode.adaptation}' at {episode.adaptation.time:.2f} s, "
        f"{episode.ended - episode.began:.2f} s after it began"
    )


def _injected(run: StoredRun) -> Iterator[str]:
    injections = run.timeline.injections
    if not injections:
        yield "No fault was injected."
        return
    times = [injection.time for injection in injections]
    names = [f"{injection.fault} ({injection.failure})" for injection in injections]
    number = f"{_number(len(times))} fault{' was' if len(times) == 1 else 's were'} injected"
    if times[-1] - times[0] < _AT_ONCE_S:
        yield f"{number} {_when(times[:1])}: {listed(names)}."
    else:
        came = _times_by_name(zip(names, times, strict=True))
        yield f"{number}: {listed([f'{name} {_when(its)}' for name, its in came.items()])}."
    healed = _times_by_name(
        (injection.fault, injection.healed) for injection in injections if injection.healed is not None
    )
    if healed:
        yield f"{listed([f'{name} healed by itself {_when(its)}' for name, its in healed.items()])}."
    for injection in injections:
        if injection.cured_away is not None:
            yield f"{injection.fault} was cured {_when([injection.cured_away])}, while it was away."


def _times_by_name(events: Iterable[tuple[str, float]]) -> dict[str, list[float]]:
    times: dict[str, list[float]] = {}
    for name, time in events:
        times.setdefault(name, []).append(time)
    return times


def _number(count: int) -> str:
    return _NUMBERS[count] if count < len(_NUMBERS) else str(count)


def _when(times: Sequence[float]) -> str:
    """Return the number of times, and the times to a tenth of a second.

    >>> _when([2.5004]), _when([2.0, 7.0])
    ('at 2.5 s', 'two times, at 2 and 7 s')
    """
    often = "" if len(times) == 1 else f"{_number(len(times)).lower()} times, "
    return f"{often}at {listed([f'{time:.1f}'.removesuffix('.0') for time in times])} s"


def _adapted(run: StoredRun) -> str:
    manager = f"The managing system {run.record.manager}"
    done = _times_by_name((_past(adaptation), adaptation.time) for adaptation in run.adaptations)
    if not done:
        has_failed = run.record.manager_failed is not None
        return f"{manager} {'failed before it did anything' if has_failed else 'did nothing'}."
    if len(done) <= _MOST:
        return f"{manager} {listed([f'{words} {_times(times)}' for words, times in done.items()])}."
    first, last = run.adaptations[0].time, run.adaptations[-1].time
    count = counted(len(run.adaptations), "adaptation")
    return f"{manager} carried out {count}, from {first:.2f} s to {last:.2f} s."


def _past(adaptation: ExecutedAdaptation) -> str:
    if not adaptation.parameters:
        return f"{_DONE.get(adaptation.kind, adaptation.kind)} {adaptation.node}"
    return str(adaptation)  # the past of 'set' is 'set'


def _times(times: Sequence[float]) -> str:
    if len(times) <= _MOST:
        return f"at {listed([f'{time:.2f}' for time in times])} s"
    return f"{len(times)} times from {times[0]:.2f} s on"


def _results(run: StoredRun) -> Iterator[str]:
    metrics, duration = run.metrics, run.record.duration_s
    if metrics.episodes:
        episodes = counted(metrics.episodes, "failure episode")
        yield f"{metrics.episodes_resolved} of {episodes} {'was' if metrics.episodes == 1 else 'were'} resolved."
        if remaining := remaining_failures(metrics):
            yield f"Still there at the end: {listed(remaining)}."
    else:
        yield "No failure was seen."
    down = "Segmentations came all the time"
    if metrics.t_down_s:
        down = f"No segmentation came for {metrics.t_down_s:.1f} of {duration:g} s"
    quality = "there is no IoU, since the flight has no labels"
    if metrics.iou_all is not None:
        count = metrics.frames_without_truth
        unknown = f" and {counted(count, 'frame')} without labels for nothing" if count else ""
        quality = f"the IoU was {metrics.iou_all:.2f}, if a lost frame counts as 0{unknown}"
    yield f"{down}; {quality}."
