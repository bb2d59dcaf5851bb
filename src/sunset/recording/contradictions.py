"""What a run's messages say of the run itself, against what `run.json` says."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from math import isclose, nan
from typing import Final

import numpy as np
from msgspec import UNSET

from sunset.interfaces.parameters import scalar_of
from sunset.interfaces.rcl_interfaces.msg import ParameterEvent
from sunset.interfaces.system_interfaces.msg import ExperimentLogging, FaultInjection, FrameEvaluation
from sunset.metrics import NUMBER_OF_CLASSES, ClassCounts, image_iou
from sunset.names import ros_text
from sunset.recording.schema import RunRecord
from sunset.recording.values import RecordedMessage
from sunset.seeding import drawn_seed
from sunset.system import (
    EVALUATION_TOPIC,
    EXPERIMENT,
    INJECTIONS_TOPIC,
    LOG_TOPIC,
    PARAMETER_EVENTS_TOPIC,
    current_system,
    full_name,
)

TELLING_TOPICS: Final = frozenset({EVALUATION_TOPIC, INJECTIONS_TOPIC, LOG_TOPIC, PARAMETER_EVENTS_TOPIC})
"""The full names of the topics whose messages say which run they are of, or the same twice."""

_MODEL: Final = full_name("segmentation"), "model"
_SHARPNESS: Final = full_name("camera"), "sharpness_threshold"


def contradictions(run: RunRecord, messages: Iterable[RecordedMessage]) -> Iterator[str]:
    """Yield in what the messages of a run contradict what is stored of it, each as a part of a sentence.

    They tell the scenario, the faults, the seed, the model, and when the experiment began and ended. So the messages of
    another run do not pass for this one's. Nor does a frame's IoU that is not that of the pixels counted beside it.

    Args:
        run: what is stored.
        messages: in order of time; those on topics that are not among `TELLING_TOPICS` do not matter.
    """
    told = [recorded.message for recorded in messages if recorded.topic in TELLING_TOPICS]
    log = [
        message for message in told if isinstance(message, ExperimentLogging) and message.source == EXPERIMENT
    ]
    moments = {entry.rule_name: entry.timestamp for entry in log}
    declared = dict(_declared([message for message in told if isinstance(message, ParameterEvent)]))
    injected = sorted(
        (message.fault, message.value)
        for message in told
        if isinstance(message, FaultInjection) and message.confirmed
    )
    uncertain = {(fault.name, ros_text(fault.value)) for fault in run.faults if not fault.is_certain}
    seeds = {(full_name(node), "seed"): drawn_seed(run.seed, node) for node in current_system().nodes}
    expected: dict[tuple[str, str], object] = {
        _MODEL: run.model,
        _SHARPNESS: run.sharpness_threshold,
        **seeds,
    }
    yield from _untold(run, {name for _, name in expected} - {name for _, name in declared}, moments.keys())
    for key, stored in expected.items():
        for value in declared.get(key, ()):
            if value != stored:
                told_of = f"{run.seed}, which gives {key[0]} {stored}" if key in seeds else stored
                yield f"its {key[1].replace('_', ' ')} is stored as {told_of}, and the messages say {value}"
                break
    for scenario in dict.fromkeys(entry.scenario for entry in log):
        if scenario != run.scenario:
            yield f"its scenario is stored as {run.scenario}, and the messages say {scenario}"
    stored_faults = sorted((fault.name, ros_text(fault.value)) for fault in run.faults)
    certain = sorted((fault.name, ros_text(fault.value)) for fault in run.faults if fault.is_certain)
    if run.valid and [fault for fault in injected if fault not in uncertain] != [
        fault for fault in certain if fault not in uncertain
    ]:
        yield f"its faults are stored as {_words(stored_faults)}, and the messages say {_words(injected)}"
    start, end = moments.get("start"), moments.get("end")
    if start is not None and run.start_ns not in {start, UNSET}:
        yield f"its injection is stored as {run.start_ns} ns, and the messages say {start} ns"
    if run.speed is UNSET and start is not None and end is not None:
        duration_s = (end - start) / 1e9
        if not isclose(duration_s, run.duration_s, abs_tol=1e-6):
            yield f"its duration is stored as {run.duration_s:g} s, and the messages say {duration_s:g} s"
    yield from _miscounted([message for message in told if isinstance(message, FrameEvaluation)])


def _miscounted(evaluations: Sequence[FrameEvaluation]) -> Iterator[str]:
    """Yield how many frames' IoU is not that of the pixels counted beside it, if any."""
    pairs = [(evaluation.iou, _iou_of(evaluation)) for evaluation in evaluations if evaluation.truth.any()]
    wrong = [(iou, counted) for iou, counted in pairs if not isclose(iou, counted, abs_tol=1e-9)]
    if wrong:
        iou, counted = wrong[0]
        yield (
            f"{len(wrong)} of its {len(pairs)} messages on {EVALUATION_TOPIC} contradict themselves: the iou of the "
            f"first is {iou:.6g}, and that of its counts {counted:.6g}"
        )


def _iou_of(evaluation: FrameEvaluation) -> float:
    counts = [evaluation.intersection, evaluation.predicted, evaluation.truth]
    if {len(count) for count in counts} != {NUMBER_OF_CLASSES}:
        return nan
    return image_iou(ClassCounts(*(count.astype(np.int64) for count in counts)))


def _untold(run: RunRecord, names: Iterable[str], moments: Collection[str]) -> Iterator[str]:
    """Yield what the messages of a run leave out: these parameters, and moments of the experiment."""
    if not run.valid or run.speed is not UNSET:  # live, a recorder may come too late
        return
    for name in sorted(names):
        yield f"the messages do not say its {name.replace('_', ' ')}"
    if not {"start", "end"} <= set(moments):
        yield "the messages do not say when its injection and its end were"


def _declared(events: Iterable[ParameterEvent]) -> Iterator[tuple[tuple[str, str], list[object]]]:
    """Yield node and parameter with the values with which it was declared, by each process that the node had."""
    values: dict[tuple[str, str], list[object]] = {}
    for event in events:
        for parameter in event.new_parameters:
            value = scalar_of(parameter.value)
            if value is not None:
                values.setdefault((event.node, parameter.name), []).append(value)
    yield from values.items()


def _words(faults: list[tuple[str, str]]) -> str:
    return " and ".join(f"{name} ({value})" for name, value in faults) or "none"
