"""The frames of a run, and which pictures belong to each."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np

from sunset.interfaces.stamps import ns_of
from sunset.interfaces.system_interfaces.msg import FrameEvaluation, ImageDigest
from sunset.recording import RecordedMessage, image_digests
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
from sunset.viewing.document import FramesView, Panel
from sunset.viewing.pictures import LABELS, Placed

_FUSED: Final = full_name("sensors_fused")
_GIVEN: Final = (f"{_FUSED}/rgb", f"{_FUSED}/depth")
_NOT_SHOWN: Final = frozenset({*SENSOR_TOPICS, full_name("rgb_enhanced")})
"""What comes before the sensors' faults, and what the fusion passes on."""


class _Words(NamedTuple):
    """What is said of a picture; `topics` are those that it is of, the second one beside the first."""

    title: str
    explanation: str
    kind: str
    topics: tuple[str, ...]


_WORDS: Final[Mapping[str, _Words]] = MappingProxyType(
    {
        "camera": _Words(
            "Camera",
            "What the node camera sends. Faults of F1 stop it; darker, blurred or discoloured pictures are faults "
            "of F4 and F5.",
            "colour",
            (full_name("rgb_camera"),),
        ),
        "depth": _Words(
            "Depth",
            "What the node depth sends: the distance to what is seen, light where it is near.",
            "depth",
            (full_name("depth_camera"),),
        ),
        "given": _Words(
            "Network's input",
            "What the sensor fusion sends: the camera's picture, enhanced or not, with the depth in the corner. With "
            "another modality it is one of the two. Faults of F2 stop it.",
            "given",
            _GIVEN,
        ),
        "labels": _Words(
            "Segmentation",
            "The class that the network gave every pixel. Faults of F3 stop it.",
            "labels",
            (RESULT_TOPIC,),
        ),
        "truth": _Words(
            "Truth",
            "The class that every pixel has. No node of the managed system and no managing system sees it.",
            "labels",
            (TRUTH_TOPIC,),
        ),
        "difference": _Words(
            "Difference",
            "Where segmentation and truth disagree. The IoU says how well they agree, from 0 to 1.",
            "difference",
            (),
        ),
    }
)
"""The pictures that are shown of every run, by name and in their order."""

_COMPARED: Final = {topic for words in _WORDS.values() for topic in words.topics} - set(_GIVEN)
"""The topics whose pictures are compared with the digests in messages; those of the fusion are of both together."""


def is_shown(topic: str) -> bool:
    """Return whether images of a topic are shown."""
    return topic not in _NOT_SHOWN


def frames_view(
    messages: Iterable[RecordedMessage], start_ns: int, end: float, placed: Sequence[Placed], period: float
) -> FramesView:
    """Return the frames of a run, with the pictures that were taken at the same moment.

    Args:
        messages: of the record.
        start_ns: when faults were injected.
        end: the duration; what was taken later is left out [s].
        placed: where the pictures of images are; empty if there are none.
        period: the time between two frames [s].
    """
    taken: dict[int, int] = {}
    iou: dict[int, float] = {}
    for one in messages:
        if one.topic == TRUTH_TOPIC:
            taken.setdefault(ns_of(content_of(one, ImageDigest).header.stamp), one.time_ns)
        elif one.topic == EVALUATION_TOPIC:
            evaluation = content_of(one, FrameEvaluation)
            if evaluation.truth.any():
                iou[ns_of(evaluation.header.stamp)] = evaluation.iou
    stamps = sorted(
        (stamp for stamp, time in taken.items() if time - start_ns <= end * 1e9), key=taken.__getitem__
    )
    return FramesView(
        times=[round((taken[stamp] - start_ns) / 1e9, 6) for stamp in stamps],
        stamps=[str(stamp) for stamp in stamps],
        iou=[round(iou[stamp], 5) if stamp in iou else None for stamp in stamps],
        panels=_panels(
            _by_topic(placed, stamps, period), {one.topic for one in placed if one.encoding == LABELS}
        )
        if placed
        else [],
    )


def foreign_pictures(messages: Iterable[RecordedMessage], placed: Iterable[Placed]) -> str:
    """Return a sentence if pictures are not those of a run, by the digests in its messages; empty if they are.

    Those of topics that every system has are compared: other publishers may fill the rows of an image, which its
    digest is of and its picture leaves out.
    """
    known = image_digests(messages)
    told = [one for one in placed if one.topic in _COMPARED]
    foreign = sum((one.topic, one.stamp_ns, one.digest) not in known for one in told)
    if not foreign:
        return ""
    return f"Pictures of another run are shown: {foreign} of {len(told)} are not those that the messages are about."


def _by_topic(placed: Sequence[Placed], stamps: Sequence[int], period: float) -> dict[str, list[int]]:
    """Return the place of each frame's picture, by topic; it is of the image whose stamp is nearest to the frame's."""
    order = np.argsort(stamps)
    known = np.array(stamps, dtype=np.int64)[order]
    found: dict[str, list[int]] = {}
    for topic, _, stamp, place, _ in placed:
        after = int(np.searchsorted(known, stamp))
        near = min(
            (one for one in (after - 1, after) if 0 <= one < len(known)),
            key=lambda one: abs(int(known[one]) - stamp),
            default=None,
        )
        if near is not None and abs(int(known[near]) - stamp) < period * 5e8:
            found.setdefault(topic, [-1] * len(stamps))[order[near]] = place
    return found


def _panels(places: Mapping[str, list[int]], labels: Collection[str]) -> list[Panel]:
    """Return the pictures of every frame: those of `_WORDS`, then those of other topics, some of which have labels."""
    panels = []
    for name, words in _WORDS.items():
        first, *others = (places.get(topic, []) for topic in words.topics or ("",))
        panels.append(
            Panel(name, words.title, words.explanation, words.kind, first, others[0] if others else [])
        )
    ours = {topic for words in _WORDS.values() for topic in words.topics}
    for topic, pictures in places.items():
        if topic not in ours:
            node = current_system().publishers.get(topic, "")
            kind = "labels" if topic in labels else "colour"
            text = f"What {f'the node {node}' if node else 'a node'} sends on {topic}."
            panels.append(Panel(topic, short_name(topic), text, kind, pictures))
    return panels
