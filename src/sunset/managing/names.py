"""The names of managing systems: those that come with SUNSET, and labels."""

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from sunset.errors import ManagerError
from sunset.managing.base import ManagingSystem
from sunset.managing.baseline import Baseline
from sunset.managing.diagnosing import Diagnosing
from sunset.managing.inspecting import Inspecting
from sunset.managing.none import NoAdaptation
from sunset.managing.oracle import ORACLE, Oracle
from sunset.managing.random_adaptation import RandomAdaptation
from sunset.managing.reactive import Reactive

MANAGERS: Final[Mapping[str, type[ManagingSystem]]] = MappingProxyType(
    {
        "none": NoAdaptation,
        "random": RandomAdaptation,
        "baseline": Baseline,
        "reactive": Reactive,
        "diagnosing": Diagnosing,
        "inspecting": Inspecting,
        ORACLE: Oracle,
    }
)
"""The managing systems that come with SUNSET, by name."""

EXTERNAL: Final = "external"
"""The name of a managing system in another process on the graph, which its user starts."""

_LABEL: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]{0,39}")


def check_printable(spec: str) -> None:
    """Refuse a name that a record cannot hold.

    Raises:
        ManagerError: it contains an unprintable character.
    """
    if not spec.isprintable():
        raise ManagerError(f"The managing system {spec!r} contains an unprintable character.")


def split_label(text: str) -> tuple[str, str]:
    """Return the label and the managing system of `LABEL=MANAGER`; the label is empty if there is none.

    A path or a module before the first `=` is not a label: `a=b/mine.py:Mine` is a file in the folder `a=b`.

    Raises:
        ManagerError: the label is malformed or reserved, or the text contains an unprintable character.

    >>> split_label("mine-2=mine.py:Mine"), split_label("baseline")
    (('mine-2', 'mine.py:Mine'), ('', 'baseline'))
    """
    label, separator, manager = text.partition("=")
    if not separator or "/" in label or ":" in label:
        check_printable(text)
        return "", text
    if not _LABEL.fullmatch(label):
        raise ManagerError(
            f"The label of the managing system {text!r} must be 1 to 40 of the letters a to z and A to Z, digits, "
            f"'_', '.', '+' and '-', and begin with a letter or digit, got {label!r}."
        )
    if label in {*MANAGERS, EXTERNAL}:
        raise ManagerError(
            f"The label {label!r} is the name of a managing system that comes with SUNSET; choose another for "
            f"{manager}."
        )
    check_printable(manager)
    return label, manager
