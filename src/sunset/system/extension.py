"""A part of a managed system, as the author of an extension writes it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Annotated

from msgspec import Meta

from sunset.errors import ExtensionError
from sunset.schemas import convert, fields_of
from sunset.system.description import (
    Adaptation,
    Failure,
    Fault,
    KindOfAdaptation,
    NodeDescription,
    Signal,
    Topic,
    View,
)
from sunset.system.suites import Suite
from sunset.texts import shorten


@dataclass(frozen=True, kw_only=True, eq=False)
class Extension:
    """A part of a managed system, such as what a file adds to the paper's.

    Attributes:
        nodes: managed nodes.
        node_classes: node of another part → the class that runs in place of its own, of which it should be a subclass.
        topics: those that the monitor watches.
        signals: what nodes report.
        failures: what is observed when something is wrong.
        faults: what can go wrong.
        adaptations: those that the system offers besides the restart and the redeploy of every node and the steps of
            cures.
        exclusive: pairs of faults that cannot be there at the same time: each would be the other's cure.
        views: the values of the parameter that chooses the sensors which the pipeline works with; the first has all of
            them.
        suites: name → its scenarios, each the faults that are injected together, as `fault` or `fault=value`; or a YAML
            text, a list of scenarios as in scenario files, whose names are without that of the suite.
        prices: kind of adaptation → what each costs in `utility`, in frames of healthy output.
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
    suites: Mapping[str, Suite] = field(default_factory=dict)
    prices: Mapping[KindOfAdaptation, Annotated[float, Meta(ge=0, le=100_000)]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the types, since an extension's author may not check them.

        Raises:
            ExtensionError: one is not as it must be.
        """
        for name, kind in _KINDS.items():
            values = getattr(self, name)
            if not isinstance(values, tuple | list) or not all(isinstance(value, kind) for value in values):
                raise ExtensionError(
                    f"The {name} of an extension must be a tuple of {kind.__name__}, got {shorten(repr(values), 100)}."
                )
        for name in ("node_classes", "suites", "prices"):
            if not isinstance(values := getattr(self, name), Mapping):
                raise ExtensionError(
                    f"The {name} of an extension must be a dictionary, got {shorten(repr(values), 100)}."
                )
        where = "the prices of an extension"
        convert(self.prices, fields_of(Extension)["prices"], where, ExtensionError, remedy="change it there")
        for name, scenarios in self.suites.items():
            if isinstance(scenarios, str):
                continue
            if not _is_list(scenarios, lambda faults: _is_list(faults, lambda fault: isinstance(fault, str))):
                raise ExtensionError(
                    f"The scenarios of the suite {name} must be tuples of faults or a YAML text, got "
                    f"{shorten(repr(scenarios), 100)}."
                )

    @property
    def named_adaptations(self) -> tuple[Adaptation, ...]:
        """The adaptations that it offers, those of its views, and those of its faults' injections and cures."""
        steps = (step for fault in self.faults for steps in (fault.injection, *fault.cures) for step in steps)
        return (*self.adaptations, *(view.setting for view in self.views), *steps)


def _is_list(value: object, is_item: Callable[[object], bool]) -> bool:
    """Return whether a value is a list or tuple, which have an order as sets have not, of such items."""
    return isinstance(value, tuple | list) and all(map(is_item, value))


_KINDS = MappingProxyType(
    {
        "nodes": NodeDescription,
        "topics": Topic,
        "signals": Signal,
        "failures": Failure,
        "faults": Fault,
        "adaptations": Adaptation,
        "exclusive": tuple,
        "views": View,
    }
)
