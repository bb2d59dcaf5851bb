"""A part of a managed system, as the author of an extension writes it."""

from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from typing import Annotated, TypeAlias, get_args, get_origin

from msgspec import Meta

from sunset.errors import ExtensionError
from sunset.files.schemas import convert, fields_of
from sunset.system.description import (
    Adaptation,
    Failure,
    Fault,
    KindOfAdaptation,
    Name,
    NodeDescription,
    Signal,
    Topic,
    View,
)
from sunset_ros.texts import shorten

Suite: TypeAlias = Annotated[
    tuple[tuple[str, ...], ...] | str, Meta(description="tuples of faults or a YAML text")
]
"""Scenarios, each the faults that are injected together, as `fault` or `fault=value`; or a YAML list of scenarios."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Extension:
    """A part of a managed system, such as the parts that a file adds to the paper's.

    Attributes:
        nodes: managed nodes.
        node_classes: node of another part → the class that runs in place of its own, a subclass of it.
        topics: topics that the monitor watches.
        signals: numbers that nodes report.
        failures: how faults show.
        faults: causes of failures.
        adaptations: adaptations to offer besides the restart and the redeploy of every node and the steps of cures.
        exclusive: pairs of faults that cannot be there at the same time: each would be the other's cure.
        views: the values of the parameter that chooses the sensors of the pipeline; the first has all of them.
        suites: name → its scenarios, each the faults that are injected together, as `fault` or `fault=value`; or a YAML
            text, a list of scenarios as in scenario files, whose names lack the suite's name.
        prices: kind of adaptation → its price in `utility`, in frames of healthy output.
    """

    nodes: tuple[NodeDescription, ...] = ()
    node_classes: Mapping[str, type] = field(default_factory=dict)
    topics: tuple[Topic, ...] = ()
    signals: tuple[Signal, ...] = ()
    failures: tuple[Failure, ...] = ()
    faults: tuple[Fault, ...] = ()
    adaptations: tuple[Adaptation, ...] = ()
    exclusive: tuple[tuple[str, str], ...] = ()
    views: tuple[View, ...] = ()
    suites: Mapping[Name, Suite] = field(default_factory=dict)
    prices: Mapping[KindOfAdaptation, Annotated[float, Meta(ge=0, le=100_000)]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, kind in fields_of(Extension).items():
            values, item = getattr(self, name), get_args(kind)[0]
            if get_origin(kind) is not tuple:
                where = f"the {name} of an extension"
                convert(values, kind, where, ExtensionError, remedy="change it there")
                continue
            item = get_origin(item) or item
            if not isinstance(values, tuple | list) or not all(isinstance(value, item) for value in values):
                raise ExtensionError(
                    f"The {name} of an extension must be a tuple of {item.__name__}, got {shorten(repr(values), 100)}."
                )

        for name, scenarios in self.suites.items():
            if any(isinstance(scenario, AbstractSet) for scenario in (scenarios, *scenarios)):
                raise ExtensionError(
                    f"The suite {name} must be tuples of faults: a set does not have an order."
                )

    @property
    def named_adaptations(self) -> tuple[Adaptation, ...]:
        """The adaptations that it offers, of its views, and of its faults' injections and cures."""
        steps = (step for fault in self.faults for steps in (fault.injection, *fault.cures) for step in steps)
        return (*self.adaptations, *(view.setting for view in self.views), *steps)
