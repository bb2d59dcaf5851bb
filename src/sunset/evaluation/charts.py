"""What a figure shows before it is drawn: panels, and its data as a table."""

from collections.abc import Sequence
from dataclasses import dataclass

from sunset.texts import csv_text


@dataclass(frozen=True, slots=True, kw_only=True)
class Mark:
    """A value with its interval, on a line of its own.

    Attributes:
        label: what the line is called.
        system: the managing system whose colour and marker it has.
        value: of the mark.
        low: lower end of the interval; None where there is none.
        high: its upper end.
    """

    label: str
    system: str
    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Intervals:
    """Marks beneath one another over one axis.

    Attributes:
        title: of the panel.
        label: of the axis.
        marks: from top to bottom.
        guides: values at which a line stands, and what it is called.
    """

    title: str
    label: str
    marks: tuple[Mark, ...]
    guides: tuple[tuple[float, str], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Shares of one managing system: each from its x to the next.

    Attributes:
        system: the managing system.
        x: (N,) ascending.
        shares: (N,) from 0 to 1.
        mean: told below the axis; None where there is none.
    """

    system: str
    x: Sequence[float]
    shares: Sequence[float]
    mean: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Curves:
    """Curves over one axis.

    Attributes:
        title: of the panel.
        label: of the axis.
        share_label: of what the shares are.
        end: of the axis, which begins at 0.
        curves: by managing system.
    """

    title: str
    label: str
    share_label: str
    end: float
    curves: tuple[Curve, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Shares:
    """A heat map of shares.

    Attributes:
        title: of the panel.
        is_good: whether more is better.
        lines: what the lines are called, from top to bottom.
        columns: what the columns are called.
        shares: line by line, from 0 to 1; None where there is nothing to share.
    """

    title: str
    is_good: bool
    lines: tuple[str, ...]
    columns: tuple[str, ...]
    shares: tuple[tuple[float | None, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """A managing system between two axes, with an interval on each.

    Attributes:
        system: the managing system.
        x: on the first axis.
        y: on the second.
        x_interval: on the first axis; None where there is none.
        y_interval: on the second; None likewise.
    """

    system: str
    x: float
    y: float
    x_interval: tuple[float, float] | None
    y_interval: tuple[float, float] | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Points:
    """Points between two axes, and the front of those that no other one beats.

    Attributes:
        title: of the panel.
        x_label: of the axis on which less is better.
        y_label: of the axis on which more is better.
        points: one a managing system.
    """

    title: str
    x_label: str
    y_label: str
    points: tuple[Point, ...]

    @property
    def front(self) -> tuple[Point, ...]:
        """The points that no other one beats, from left to right."""
        found: list[Point] = []
        for point in sorted(self.points, key=lambda point: (point.x, -point.y)):
            if not found or point.y > found[-1].y:
                found.append(point)
        return tuple(found)


Panel = Intervals | Curves | Shares | Points


@dataclass(frozen=True, slots=True, kw_only=True)
class Chart:
    """A figure of a report.

    Attributes:
        name: of its files.
        title: above it.
        meaning: how it is read, in sentences.
        panels: what is drawn; empty if there is nothing to draw.
        missing: what is not shown and why, a sentence each.
        head: the names of the columns of its data.
        lines: its data.
    """

    name: str
    title: str
    meaning: str
    panels: tuple[Panel, ...]
    missing: tuple[str, ...]
    head: tuple[str, ...]
    lines: tuple[tuple[object, ...], ...]

    @property
    def legend(self) -> tuple[str, ...]:
        """The managing systems that are drawn without their names beside them, in the order in which they come."""
        return tuple(
            dict.fromkeys(
                drawn.system
                for panel in self.panels
                if isinstance(panel, Curves | Points)
                for drawn in (panel.curves if isinstance(panel, Curves) else panel.points)
            )
        )

    @property
    def systems(self) -> tuple[str, ...]:
        """All managing systems that are drawn in a style of their own."""
        marks = [mark.system for panel in self.panels if isinstance(panel, Intervals) for mark in panel.marks]
        return tuple(dict.fromkeys((*self.legend, *marks)))

    def as_csv(self) -> str:
        """Return its data as CSV."""
        return csv_text([self.head, *self.lines])
