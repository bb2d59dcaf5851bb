"""What the page knows of runs: the schema of the JSON in it.

Times are seconds from the injection on, negative before it. A span is a pair of times, from and to.
"""

import msgspec

Span = tuple[float, float]
"""From and to."""


class Happening(msgspec.Struct, frozen=True):
    """Something at a moment.

    Attributes:
        time: when.
        kind: `fault`, `healed`, `symptom`, `adaptation`, `cured`, `log` or `end`.
        text: in words.
    """

    time: float
    kind: str
    text: str


class FaultView(msgspec.Struct, frozen=True):
    """An injected fault.

    Attributes:
        failure: what it shows as, such as `F1`.
        node: where it lives.
        spans: when it was there.
        around: when adaptations made up for it while it was there.
    """

    name: str
    description: str
    failure: str
    node: str
    spans: list[Span]
    around: list[Span]


class EpisodeView(msgspec.Struct, frozen=True):
    """An episode of a failure.

    Attributes:
        began: when the failure began, before its symptom held.
        holds: when its symptom began to hold.
        ended: when it stopped; None if it held to the end.
        cause: `injected`, `ripple` or `not injected`.
        outcome: who or what resolved it, in words.
    """

    began: float
    holds: float
    ended: float | None
    cause: str
    outcome: str


class FailureView(msgspec.Struct, frozen=True):
    """A failure, such as F1, with the episodes of a run; `topic` is the full name of the one that stops, if any."""

    name: str
    description: str
    symptom: str
    topic: str
    episodes: list[EpisodeView]


class AdaptationView(msgspec.Struct, frozen=True):
    """An executed adaptation; `resolved` are the failures of the episodes that it resolved."""

    time: float
    text: str
    node: str
    resolved: list[str]


class SignalView(msgspec.Struct, frozen=True):
    """A signal over time.

    Attributes:
        threshold: the mean beyond it is a symptom; None if there is none.
        below: whether the symptom is a mean below the threshold.
        failure: the failure that it shows; empty if none.
        means: of the last five samples; None where there are too few.
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
    """When messages left on a topic."""

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
    """A figure of a run, as the time line prints it."""

    name: str
    value: str
    remark: str


class Panel(msgspec.Struct, frozen=True):
    """One of the pictures that are shown of every frame.

    Attributes:
        kind: `colour`, `depth`, `labels` or `difference`, which is made of the labels and the truth.
        pictures: the place of each frame's picture among all; -1 where there is none.
        beside: likewise, of a second picture that is shown with it; empty if there is none.
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
        times: when each was taken.
        stamps: the stamps of their headers, in nanoseconds, as texts: they may be larger than a script's numbers.
        iou: of each; None where it was not evaluated.
    """

    times: list[float]
    stamps: list[str]
    iou: list[float | None]
    panels: list[Panel]


class RunView(msgspec.Struct, frozen=True):
    """One run.

    Attributes:
        described: what was run, in a line, but the managing system.
        story: what happened, in some sentences.
        start: the time of the first frame.
        end: the duration.
        remark: how the managing system failed, why the run does not count, why there are no pictures; empty if all is
            well.
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
    """A class and the colour in which it is shown, as CSS writes it."""

    name: str
    colour: str


class DepthScale(msgspec.Struct, frozen=True):
    """How depth is shown.

    Attributes:
        near: what is nearer has the first colour [m].
        far: what is further has the last one [m].
        colours: evenly spaced on a logarithmic scale.
    """

    near: float
    far: float
    colours: list[str]


class PicturesView(msgspec.Struct, frozen=True):
    """All pictures of the page, each once.

    Attributes:
        width: of the pictures as they are stored, in pixels.
        height: likewise.
        note: how they differ from the originals.
        classes: the indices of the classes that are seen, the frequent ones first.
        data: WebP of colour and depth, packed class indices of labels; in base64.
    """

    width: int
    height: int
    note: str
    depth: DepthScale | None
    classes: list[int]
    data: list[str]


class Page(msgspec.Struct, frozen=True):
    """All that the page knows.

    Attributes:
        title: what the page shows.
        comparison: what differs between two runs, in some sentences; empty if there is one.
        opening: the moment that is shown first.
    """

    title: str
    comparison: list[str]
    opening: float
    version: str
    runs: list[RunView]
    classes: list[LabelClass]
    pictures: PicturesView
