"""What happened in a run, in sentences for a reader who sees SUNSET for the first time."""

from collections.abc import Iterator, Sequence
from typing import Final

from sunset.metrics import Episode, ExecutedAdaptation, RunMetrics
from sunset.recording import RunRecord, StoredRun
from sunset.system import current_system
from sunset.texts import counted, listed, shorten

_AT_ONCE_S: Final = 0.1
"""Faults that come within so long were injected together."""
_MOST: Final = 4
"""Adaptations that are listed; of more, only the number is given."""
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
    """Return what was run, in a line, but the managing system."""
    return f"seed {run.seed} · model {run.model} · middleware {run.middleware} · {run.duration_s:g} s"


def story(run: StoredRun) -> list[str]:
    """Return what happened, a sentence each: what was injected, what was done about it, and what came of it."""
    return [*_injected(run), *_adapted(run), *_outcome(run)]


def remark(run: StoredRun) -> str:
    """Return how a managing system failed, why a run does not count, and which figures are stored otherwise."""
    parts = []
    if run.record.manager_failed is not None:
        parts.append(f"{shorten(run.record.manager_failed)} The run went on without it.")
    if not run.valid:
        parts.append(f"This run does not count: {shorten(run.reason)}.")
    if run.differing:
        parts.append(
            f"Stored otherwise than the messages give, and computed here: {', '.join(run.differing)}."
        )
    return " ".join(parts)


def compared(one: StoredRun, other: StoredRun) -> list[str]:
    """Return what differs between two runs of the same scenario and seed."""
    first, second = f"A ({one.record.manager})", f"B ({other.record.manager})"
    ours, theirs = one.metrics, other.metrics
    sentences = [
        f"The same faults, flight and seed, managed by {first} and by {second}.",
        _difference(ours.iou_all, theirs.iou_all, first, second),
        f"No segmentation came for {ours.t_down_s:.1f} s of A, and for {theirs.t_down_s:.1f} s of B.",
        f"A resolved {_resolved(ours)}, B {_resolved(theirs)}.",
    ]
    if ours.episodes != theirs.episodes:
        sentences.append(
            "The same faults gave different numbers of failures, since one failure may hide or bring about another."
        )
    if one.record.model != other.record.model:
        sentences.append(f"The models differ, too: {one.record.model} and {other.record.model}.")
    return sentences


def _difference(ours: float | None, theirs: float | None, first: str, second: str) -> str:
    if ours is None or theirs is None:
        return "The flight has no labels, so that there is no IoU to compare."
    meaning = "the IoU, which says how well labels agree with the truth and is 0 for a lost frame,"
    if round(ours, 2) == round(theirs, 2):
        return f"In both, {meaning} is {ours:.2f}."
    better = first if ours > theirs else second
    return f"With {better}, {meaning} is higher: {max(ours, theirs):.2f} against {min(ours, theirs):.2f}."


def _resolved(metrics: RunMetrics) -> str:
    episodes, adaptations = (
        counted(metrics.episodes, "failure episode"),
        counted(metrics.adaptations, "adaptation"),
    )
    return f"{metrics.episodes_resolved} of {episodes} with {adaptations}"


def outcome_of(episode: Episode) -> str:
    """Return what became of an episode."""
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
    verb = "fault was" if len(injections) == 1 else "faults were"
    number = _number(len(injections))
    if injections[-1].time - injections[0].time < _AT_ONCE_S:
        names = listed([f"{injection.fault} ({injection.failure})" for injection in injections])
        yield f"{number} {verb} injected {_when([injections[0].time])}: {names}."
    else:
        came: dict[str, list[float]] = {}
        for injection in injections:
            came.setdefault(f"{injection.fault} ({injection.failure})", []).append(injection.time)
        yield f"{number} {verb} injected: {listed([f'{fault} {_when(times)}' for fault, times in came.items()])}."
    healed: dict[str, list[float]] = {}
    for injection in injections:
        if injection.healed is not None:
            healed.setdefault(injection.fault, []).append(injection.healed)
    if healed:
        yield f"{listed([f'{fault} healed by itself {_when(times)}' for fault, times in healed.items()])}."
    for injection in injections:
        if injection.cured_away is not None:
            yield f"{injection.fault} was cured {_when([injection.cured_away])}, while it was away."


def _number(count: int) -> str:
    return _NUMBERS[count] if count < len(_NUMBERS) else str(count)


def _when(times: Sequence[float]) -> str:
    """Return when something came: how often, and at which times to a tenth of a second.

    >>> _when([2.5004]), _when([2.0, 7.0])
    ('at 2.5 s', 'two times, at 2 and 7 s')
    """
    often = "" if len(times) == 1 else f"{_number(len(times)).lower()} times, "
    return f"{often}at {listed([f'{time:.1f}'.removesuffix('.0') for time in times])} s"


def _adapted(run: StoredRun) -> Iterator[str]:
    who = f"The managing system {run.record.manager}"
    done: dict[str, list[float]] = {}
    for adaptation in run.adaptations:
        done.setdefault(_past(adaptation), []).append(adaptation.time)
    if not done:
        failed = run.record.manager_failed is not None
        yield f"{who} {'failed before it did anything' if failed else 'did nothing'}."
    elif len(done) <= _MOST:
        yield f"{who} {listed([f'{words} {_times(times)}' for words, times in done.items()])}."
    else:
        first, last = run.adaptations[0].time, run.adaptations[-1].time
        count = counted(len(run.adaptations), "adaptation")
        yield f"{who} carried out {count}, from {first:.2f} s to {last:.2f} s."


def _past(adaptation: ExecutedAdaptation) -> str:
    if not adaptation.parameters:
        return f"{_DONE.get(adaptation.kind, adaptation.kind)} {adaptation.node}"
    return str(adaptation)  # 'set' is its own past


def _times(times: Sequence[float]) -> str:
    if len(times) <= _MOST:
        return f"at {listed([f'{time:.2f}' for time in times])} s"
    return f"{len(times)} times from {times[0]:.2f} s on"


def _outcome(run: StoredRun) -> Iterator[str]:
    metrics, duration = run.metrics, run.record.duration_s
    if metrics.episodes:
        yield f"{metrics.episodes_resolved} of {counted(metrics.episodes, 'failure episode')} {_was(metrics)} resolved."
        failures = current_system().failures
        still = sorted({episode.failure for episode in metrics.failures if episode.ended is None})
        if still:
            names = listed([f"{name} ({failures[name].description})" for name in still])
            yield f"Still there at the end: {names}."
    else:
        yield "No failure was seen."
    down = (
        f"no segmentation came for {metrics.t_down_s:.1f} of {duration:g} s"
        if metrics.t_down_s
        else "segmentations came all the time"
    )
    quality = "there is no IoU, since the flight has no labels"
    if metrics.iou_all is not None:
        count = metrics.frames_without_truth
        unknown = f" and {counted(count, 'frame')} without labels for nothing" if count else ""
        quality = f"the IoU was {metrics.iou_all:.2f}, if a lost frame counts as 0{unknown}"
    yield f"{down[:1].upper()}{down[1:]}; {quality}."


def _was(metrics: RunMetrics) -> str:
    return "was" if metrics.episodes == 1 else "were"
