"""From the record of a run to the JSON that the page's scripts read.

Times are in seconds from the injection, negative before it; spans are pairs of times.
"""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final, NamedTuple

import numpy as np
import numpy.typing as npt

from sunset.metrics import Samples, Settings
from sunset.metrics.timeline import TOLERANCE_S
from sunset.recording import RecordedMessage, RunRecord, StoredRun
from sunset.recording.story import Event, cause_of, figures_of, remarks_of
from sunset.recording.timelines import content_of, start_of
from sunset.system import (
    BAG_PLAYER,
    EVALUATION_TOPIC,
    GAP_S,
    RESULT_TOPIC,
    SENSOR_TOPICS,
    STATE,
    TRUTH_TOPIC,
    MovingMean,
    current_system,
    find_fault,
    full_name,
    short_name,
)
from sunset.system_interfaces.msg import FrameEvaluation, ImageDigest
from sunset.viewing.pictures import LABELS, Placed
from sunset.viewing.words import described, outcome_of, story
from sunset_ros.interfaces.stamps import ns_of
from sunset_ros.texts import printable, shorten

_FUSED: Final = full_name("sensors_fused")
_NOT_SHOWN: Final = frozenset({*SENSOR_TOPICS, full_name("rgb_enhanced")})
"""Topics before the sensors' faults, and the enhanced images, which the fusion passes on."""


class _Words(NamedTuple):
    """The description of a panel, the topic of its picture, and the topic of a picture beside it."""

    title: str
    explanation: str
    kind: str
    topic: str = ""
    beside: str = ""


_WORDS: Final[Mapping[str, _Words]] = MappingProxyType(
    {
        "camera": _Words(
            "Camera",
            "What the node camera sends. Faults of F1 stop it; darker, blurred or discoloured pictures are faults "
            "of F4 and F5.",
            "colour",
            full_name("rgb_camera"),
        ),
        "depth": _Words(
            "Depth",
            "What the node depth sends: the distance to what is seen, light where it is near.",
            "depth",
            full_name("depth_camera"),
        ),
        "given": _Words(
            "Network's input",
            "What the sensor fusion sends: the camera's picture, enhanced or not, with the depth in the corner. With "
            "another modality it is one of the two. Faults of F2 stop it.",
            "given",
            f"{_FUSED}/rgb",
            f"{_FUSED}/depth",
        ),
        "labels": _Words(
            "Segmentation",
            "The class that the network gave every pixel. Faults of F3 stop it.",
            "labels",
            RESULT_TOPIC,
        ),
        "truth": _Words(
            "Truth",
            "The class that every pixel has. No node of the managed system and no managing system sees it.",
            "labels",
            TRUTH_TOPIC,
        ),
        "difference": _Words(
            "Difference",
            "Where segmentation and truth disagree. The IoU says how well they agree, from 0 to 1.",
            "difference",
        ),
    }
)
"""The panels of every run, by name and in their order."""


def is_shown(topic: str) -> bool:
    """Return whether images of a topic are shown."""
    return topic not in _NOT_SHOWN


def frames_view(
    messages: Iterable[RecordedMessage], start_ns: int, run: RunRecord, placed: Sequence[Placed]
) -> dict[str, object]:
    """Return the frames of a run and their panels.

    Stamps are texts, since scripts lack such large numbers.

    Args:
        messages: of the record.
        start_ns: the time of the injection.
        run: the record.
        placed: the places of the images' pictures; may be empty.
    """
    taken: dict[int, int] = {}
    iou: dict[int, float] = {}
    for recorded in messages:
        if recorded.topic == TRUTH_TOPIC:
            taken.setdefault(ns_of(content_of(recorded, ImageDigest).header.stamp), recorded.time_ns)
        elif recorded.topic == EVALUATION_TOPIC:
            evaluation = content_of(recorded, FrameEvaluation)
            if evaluation.truth.any():
                iou[ns_of(evaluation.header.stamp)] = evaluation.iou
    stamps = sorted(
        (stamp for stamp, time in taken.items() if time - start_ns <= run.duration_s * 1e9),
        key=taken.__getitem__,
    )
    return {
        "times": [round((taken[stamp] - start_ns) / 1e9, 6) for stamp in stamps],
        "stamps": [str(stamp) for stamp in stamps],
        "iou": [round(iou[stamp], 5) if stamp in iou else None for stamp in stamps],
        "panels": _panels(placed, _by_topic(placed, stamps, run.period_s)) if placed else [],
    }


def _by_topic(placed: Sequence[Placed], stamps: Sequence[int], period: float) -> dict[str, list[int]]:
    """Return the place of each frame's picture, the picture with the nearest stamp, by topic; -1 without a picture."""
    order = np.argsort(stamps)
    known = np.array(stamps, dtype=np.int64)[order]
    places: dict[str, list[int]] = {}
    for image in placed:
        after = int(np.searchsorted(known, image.stamp_ns))
        near = min(
            (number for number in (after - 1, after) if 0 <= number < len(known)),
            key=lambda number: abs(int(known[number]) - image.stamp_ns),
            default=None,
        )
        if near is not None and abs(int(known[near]) - image.stamp_ns) < period * 5e8:
            places.setdefault(image.topic, [-1] * len(stamps))[order[near]] = image.place
    return places


def _panels(placed: Sequence[Placed], places: Mapping[str, list[int]]) -> list[dict[str, object]]:
    """Return the panels of `_WORDS`, and a panel for each other topic with images."""
    labels = {image.topic for image in placed if image.encoding == LABELS}
    known = {topic for words in _WORDS.values() for topic in (words.topic, words.beside)}
    panels = dict(_WORDS)
    for topic in places:
        if topic not in known:
            node = current_system().publishers.get(topic, "")
            text = f"What {f'the node {node}' if node else 'a node'} sends on {topic}."
            kind = "labels" if topic in labels else "colour"
            panels[topic] = _Words(short_name(topic), text, kind, topic)
    return [
        {
            "name": name,
            "title": words.title,
            "explanation": words.explanation,
            "kind": words.kind,
            "pictures": places.get(words.topic, []),
            "beside": places.get(words.beside, []),
        }
        for name, words in panels.items()
    ]


View = dict[str, Any]
"""An object of the JSON."""

_DIGITS: Final = 6  # digits of times in seconds, to the microsecond


def run_view(
    run: StoredRun, messages: Sequence[RecordedMessage], placed: Sequence[Placed], note: str
) -> View:
    """Return the view of a run, whose extensions the managed system of this process has.

    Args:
        run: the run.
        messages: all messages of the record.
        placed: the places of its images' pictures.
        note: a remark about its pictures.
    """
    record = run.record
    start_ns = start_of(messages)
    first_ns = next((recorded.time_ns for recorded in messages if recorded.topic == TRUTH_TOPIC), None)
    start = -(record.warm_up_s or 0.0) if first_ns is None else min((first_ns - start_ns) / 1e9, 0.0)
    events = [_event(event) for event in run.events]
    return {
        "manager": record.manager,
        "described": described(record),
        "story": story(run),
        "remark": " ".join(filter(None, (*remarks_of(record, run.differing), note))),
        "start": round(start, _DIGITS),
        "end": record.duration_s,
        "period": record.period_s,
        "faults": _faults(run),
        "failures": _failures(run),
        "adaptations": _adaptations(run),
        "log": [event for event in events if event["kind"] == "log"],
        "signals": _signals(run),
        "topics": _topics(messages, start_ns),
        "nodes": [{"name": name, "states": _states(run, name, start)} for name in current_system().nodes],
        "events": events,
        "figures": [
            {"name": name, "value": value, "remark": remark}
            for name, value, remark in figures_of(run.metrics)
        ],
        "iou": (_rounded(run.timeline.frames.times), _digits(run.timeline.frames.iou)),
        "frames": frames_view(messages, start_ns, record, placed),
    }


def _event(event: Event) -> View:
    time, kind, text = event
    return {"time": time, "kind": kind, "text": printable(shorten(text))}


def _states(run: StoredRun, node: str, start: float) -> list[View]:
    """Return the lifecycle states of a managed node in order of time; may be empty."""
    end = run.record.duration_s
    changes = [
        setting
        for setting in run.timeline.settings
        if setting.name == STATE and short_name(setting.node) == node
    ]
    states: list[View] = []
    ends = [*(change.time for change in changes[1:]), end]
    for change, until in zip(changes, ends, strict=False):
        first, last = max(change.time, start), min(until, end)
        if first < last and states and states[-1]["state"] == change.value:
            first = states.pop()["since"]
        if first < last:
            states.append({"since": first, "until": last, "state": change.value})
    return states


def _faults(run: StoredRun) -> list[View]:
    """Return each fault with the spans in which it was there, and in which adaptations worked around it."""
    views, settings, end = [], Settings(run.timeline.settings), run.record.duration_s
    for name in dict.fromkeys(injection.fault for injection in run.timeline.injections):
        fault = find_fault(name)  # None if the record is of another version
        injections = [injection for injection in run.timeline.injections if injection.fault == name]
        spans = [
            (injection.time, end if injection.ended is None else min(injection.ended, end))
            for injection in injections
            if injection.time < end
        ]
        views.append(
            {
                "name": name,
                "description": fault.description if fault else "",
                "failure": injections[0].failure,
                "node": short_name(injections[0].node),
                "spans": spans,
                "around": sorted(stretch for span in spans for stretch in settings.in_place(name, *span)),
            }
        )
    return views


def _failures(run: StoredRun) -> list[View]:
    return [
        {
            "name": failure.name,
            "description": failure.description,
            "symptom": failure.symptom,
            "topic": full_name(failure.topic) if failure.topic else "",
            "episodes": [
                {
                    "began": episode.began,
                    "holds": episode.holds,
                    "ended": episode.ended,
                    "cause": cause_of(episode),
                    "outcome": outcome_of(episode),
                }
                for episode in run.episodes
                if episode.failure == failure.name
            ],
        }
        for failure in current_system().failures.values()
    ]


def _adaptations(run: StoredRun) -> list[View]:
    return [
        {
            "time": adaptation.time,
            "text": str(adaptation),
            "node": adaptation.node,
            "resolved": [episode.failure for episode in run.episodes if episode.adaptation == adaptation],
        }
        for adaptation in run.adaptations
    ]


def _signals(run: StoredRun) -> list[View]:
    failures = {failure.signal: failure.name for failure in current_system().failures.values()}
    views = []
    for name, signal in current_system().signals.items():
        samples = run.timeline.samples.get(name, Samples())
        moving = MovingMean(GAP_S + TOLERANCE_S)
        pairs = zip(samples.times.tolist(), samples.values.tolist(), strict=True)
        means = [moving.add(*pair) for pair in pairs]
        views.append(
            {
                "name": name,
                "unit": signal.unit,
                "threshold": run.timeline.thresholds.get(signal.threshold_name),
                "below": signal.below,
                "failure": failures.get(name, ""),
                "times": _rounded(samples.times),
                "values": _digits(samples.values),
                "means": [None if mean is None else float(f"{mean:.5g}") for mean in means],
            }
        )
    return views


def _topics(messages: Sequence[RecordedMessage], start_ns: int) -> list[View]:
    system = current_system()
    times: dict[str, list[float]] = {full_name(name): [] for name in system.topics}
    for recorded in messages:
        if recorded.topic in times:
            times[recorded.topic].append(round((recorded.time_ns - start_ns) / 1e9, _DIGITS))
    return [
        {"name": topic, "node": system.publishers.get(topic, BAG_PLAYER), "times": sent}
        for topic, sent in times.items()
    ]


def _rounded(times: npt.NDArray[np.float64]) -> list[float]:
    return [round(time, _DIGITS) for time in times.tolist()]


def _digits(values: npt.NDArray[np.float64]) -> list[float]:
    return [float(f"{value:.5g}") for value in values.tolist()]
