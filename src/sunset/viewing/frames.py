"""The frames of a run and their pictures."""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np

from sunset.recording import RecordedMessage, RunRecord
from sunset.recording.timelines import content_of
from sunset.system import (
    EVALUATION_TOPIC,
    RESULT_TOPIC,
    SENSOR_TOPICS,
    TRUTH_TOPIC,
    current_system,
    full_name,
    short_name,
)
from sunset.system_interfaces.msg import FrameEvaluation, ImageDigest
from sunset.viewing.pictures import LABELS, Placed
from sunset_ros.interfaces.stamps import ns_of

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
