"""The .msg and .srv language: text in, frozen values out.

Source: https://design.ros2.org/articles/legacy_interface_definition.html. Comments are dropped, `wstring`
is not supported, and `char` is read as `uint8`, as on ROS 2's wire. All else is an `InterfaceError`.
"""

import ast
import re
from dataclasses import dataclass
from functools import cache
from typing import Final

from sunset_ros.errors import InterfaceError

NUMERIC: Final = (
    *(f"{sign}int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "u")),
    "float32",
    "float64",
)
"""The primitive types whose arrays are numpy arrays."""

PRIMITIVES: Final = (*NUMERIC, "bool", "byte", "string")
"""All primitive types that a field may have after `char` was read as `uint8`."""

PARTS: Final = ("Request", "Response")
"""The messages of a service."""

DUMMY_FIELD: Final = "structure_needs_at_least_one_member"
"""The name of the octet in a message without fields."""

_TYPE = re.compile(
    r"(?P<base>[A-Za-z]\w*(?:/[A-Za-z]\w*)?)(?:<=(?P<bound>\d+))?"
    r"(?P<array>\[(?:(?P<size>\d+)|<=(?P<limit>\d+))?\])?"
)
_CODE = re.compile(r"""(?:[^#'"]|'[^']*'|"[^"]*"|['"].*)*""")
"""All of a line but its comment."""
_LINE = re.compile(r"(?P<type>\S+)\s+(?P<name>[A-Za-z]\w*)\s*(?P<rest>.*)")


@dataclass(frozen=True, slots=True)
class FieldType:
    """The type of a field."""

    base: str  #: a primitive, or the full name of a message, such as `std_msgs/msg/Header`
    string_bound: int = 0  #: the most bytes that a string may have, 0 for no bound
    is_array: bool = False  #: whether it is an array or a sequence
    size: int | None = None  #: the exact number of elements of an array, None for a sequence
    limit: int | None = None  #: the most elements that a sequence may have, None for no limit

    @property
    def is_message(self) -> bool:
        """Whether the elements are messages."""
        return "/" in self.base

    @property
    def is_numpy(self) -> bool:
        """Whether the value is a numpy array."""
        return self.is_array and self.base in NUMERIC

    def __str__(self) -> str:
        """Return the type as it is written in a .msg file."""
        package, _, name = self.base.partition("/msg/")
        text = f"{package}/{name}" if name else self.base
        if self.string_bound:
            text += f"<={self.string_bound}"
        if not self.is_array:
            return text
        bound = self.size if self.size is not None else f"<={self.limit}" if self.limit is not None else ""
        return f"{text}[{bound}]"


@dataclass(frozen=True, slots=True)
class Field:
    """A field: its type, its name and its default (None where the type's own default holds)."""

    type: FieldType
    name: str
    default: object = None


@dataclass(frozen=True, slots=True)
class Constant:
    """A constant of a message."""

    type: str
    name: str
    value: bool | int | float | str | bytes


@dataclass(frozen=True, slots=True)
class Definition:
    """A message: its full name, such as `std_msgs/msg/Header`, its constants and its fields."""

    name: str
    constants: tuple[Constant, ...]
    fields: tuple[Field, ...]


@cache
def parse_type(text: str, package: str) -> FieldType:
    """Return the type that `text` names in a definition of `package`.

    >>> parse_type("Parameter[<=3]", "rcl_interfaces")
    FieldType(base='rcl_interfaces/msg/Parameter', string_bound=0, is_array=True, size=None, limit=3)
    """
    match = _TYPE.fullmatch(text)
    base = match["base"] if match else ""
    if match is None or base == "wstring" or (match["bound"] and base != "string"):
        raise InterfaceError(f"The field type {text!r} in package {package!r} is not supported.")
    if base == "char":
        base = "uint8"
    if base not in PRIMITIVES:
        owner, _, name = base.rpartition("/")
        base = f"{owner or package}/msg/{name}"
    return FieldType(
        base=base,
        string_bound=int(match["bound"] or 0),
        is_array=match["array"] is not None,
        size=int(match["size"]) if match["size"] else None,
        limit=int(match["limit"]) if match["limit"] else None,
    )


def parse_message(text: str, name: str) -> Definition:
    """Return the definition in the text of a .msg file, by the message's full name, such as `std_msgs/msg/Header`."""
    package = name.partition("/")[0]
    constants: list[Constant] = []
    fields: list[Field] = []
    for number, line in enumerate(text.splitlines(), 1):
        code = _CODE.match(line)[0].strip()  # type: ignore[index]  # it matches any line
        if not code:
            continue
        match = _LINE.fullmatch(code)
        if match is None:
            raise InterfaceError(f"Line {number} of {name} is neither a field nor a constant: {line!r}.")
        kind, rest = parse_type(match["type"], package), match["rest"]
        if rest.startswith("="):
            constants.append(Constant(kind.base, match["name"], _scalar(rest[1:].strip(), kind.base)))
        else:
            fields.append(Field(kind, match["name"], _default(rest, kind) if rest else None))
    return Definition(name, tuple(constants), tuple(fields))


def split_service(text: str, name: str) -> tuple[str, str]:
    """Return the texts of request and response in the text of a .srv file, which a line of three dashes separates."""
    request, *others = re.split(r"^---[ \t]*(?:\n|\Z)", text, flags=re.MULTILINE)
    if len(others) != 1:
        raise InterfaceError(f"{name} needs one line '---' between request and response, got {len(others)}.")
    return request, others[0]


def _scalar(text: str, base: str) -> bool | int | float | str | bytes:
    try:
        if base == "string":
            return str(ast.literal_eval(text)) if text[:1] in {"'", '"'} else text
        if base == "bool":
            return {"true": True, "1": True, "false": False, "0": False}[text.lower()]
        if base == "byte":
            return bytes([int(text, 0)])
        return float(text) if base.startswith("float") else int(text, 0)
    except (KeyError, ValueError, SyntaxError) as error:
        raise InterfaceError(f"{text!r} is not a value of type {base}.") from error


def _default(text: str, kind: FieldType) -> object:
    if not kind.is_array:
        return _scalar(text, kind.base)
    items = text.strip("[] \t")
    return [_scalar(item.strip(), kind.base) for item in items.split(",")] if items else []
