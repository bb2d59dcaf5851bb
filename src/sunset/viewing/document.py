"""The schema of the JSON in a page.

Times are in seconds from the injection, negative before it. A span is a pair of times, from and to.
"""

import msgspec

Span = tuple[float, float]
"""From and to."""


class Happening(msgspec.Struct, frozen=True):
    """An event; its kind is `fault`, `healed`, `symptom`, `adaptation`, `cured`, `log` or `end`."""

    time: float
    kind: str
    text: str


class FaultView(msgspec.Struct, frozen=True):
    """A fault with its failure and node, when it was there, and when adaptations worked around it."""

    name: str
    description: str
    failure: str
    node: str
    spans: list[Span]
    around: list[Span]


class EpisodeView(msgspec.Struct, frozen=True):
    """An episode of a failure.

    Attributes:
        began: before the symptom held.
        ended: None if the episode lasted to the end.
        cause: `injected`, `ripple` or `not injected`.
        outcome: its end, in words.
    """

    began: float
    holds: float
    ended: float | None
    cause: str
    outcome: str


class FailureView(msgspec.Struct, frozen=True):
    """A failure with its episodes; `topic` is the full name of the topic that stops, if any."""

    name: str
    description: str
    symptom: str
    topic: str
    episodes: list[EpisodeView]


class AdaptationView(msgspec.Struct, frozen=True):
    """An executed adaptation, and the failures of the episodes that it resolved."""

    time: float
    text: str
    node: str
    resolved: list[str]


class SignalView(msgspec.Struct, frozen=True):
    """A signal over time.

    Attributes:
        threshold: the limit of the mean, beyond which there is a symptom.
        below: whether there is a symptom below the threshold.
        failure: the failure with this symptom; empty if there is none.
        means: of the last five samples; None for too few samples.
    """

    name: str
    unit: str
    threshold: float | None
    below: bool
    failure: str
    times: list[float]
    values: list[float]
    means: list[float | None]


class TopicView(msgspec.Struct, frozen=True):
    """The times of messages on a topic, and its publisher."""

    name: str
    node: str
    times: list[float]


class StateView(msgspec.Struct, frozen=True):
    """A lifecycle state of a node, from a time to another."""

    since: float
    until: float
    state: str


class NodeView(msgspec.Struct, frozen=True):
    """The lifecycle of a node."""

    name: str
    states: list[StateView]


class Figure(msgspec.Struct, frozen=True):
    """A figure at the end of the time line."""

    name: str
    value: str
    remark: str


class Panel(msgspec.Struct, frozen=True):
    """A place for a picture of every frame.

    Attributes:
        kind: `colour`, `depth`, `labels`, `given` or `difference`, which the page makes from labels and truth.
        pictures: the index of each frame's picture; -1 if it is missing.
        beside: likewise, of a second picture in the same place; may be empty.
    """

    name: str
    title: str
    explanation: str
    kind: str
    pictures: list[int]
    beside: list[int] = []


class FramesView(msgspec.Struct, frozen=True):
    """The frames of a run.

    Attributes:
        stamps: of their headers, in nanoseconds, as texts, since scripts lack such large numbers.
        iou: of each frame; None if it was not evaluated.
    """

    times: list[float]
    stamps: list[str]
    iou: list[float | None]
    panels: list[Panel]


class RunView(msgspec.Struct, frozen=True):
    """A run.

    Attributes:
        described: the run in a line, without the managing system.
        story: a summary, a sentence each.
        remark: why the run does not count, or lacks pictures; may be empty.
        start: the time of the first frame.
        end: the duration.
        iou: times and values of all evaluated frames.
    """

    manager: str
    described: str
    story: list[str]
    remark: str
    start: float
    end: float
    period: float
    faults: list[FaultView]
    failures: list[FailureView]
    adaptations: list[AdaptationView]
    log: list[Happening]
    signals: list[SignalView]
    topics: list[TopicView]
    nodes: list[NodeView]
    events: list[Happening]
    figures: list[Figure]
    iou: tuple[list[float], list[float]]
    frames: FramesView


class LabelClass(msgspec.Struct, frozen=True):
    """A class and its colour in CSS."""

    name: str
    colour: str


class DepthScale(msgspec.Struct, frozen=True):
    """The colours of depths from `near` to `far` [m], evenly spaced on a logarithmic scale."""

    near: float
    far: float
    colours: list[str]


class PicturesView(msgspec.Struct, frozen=True):
    """All pictures of the page, each once.

    Attributes:
        width: of the stored labels [pixels].
        height: likewise.
        note: the loss of the pictures.
        classes: the indices of the visible classes, the frequent classes first.
        data: WebP of colour and depth, packed class indices of labels; in base64.
    """

    width: int
    height: int
    note: str
    depth: DepthScale | None
    classes: list[int]
    data: list[str]


class Page(msgspec.Struct, frozen=True):
    """The content of a page.

    Attributes:
        comparison: the differences between two runs, a sentence each; empty for a single run.
        opening: the moment that is shown first.
    """

    title: str
    comparison: list[str]
    opening: float
    version: str
    runs: list[RunView]
    classes: list[LabelClass]
    pictures: PicturesView
