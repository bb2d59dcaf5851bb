"""The source of a generated message class."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import groupby
from keyword import iskeyword
from typing import Final, TypeAlias

from sunset_ros.errors import InterfaceError
from sunset_ros.generator.definitions import Definition, Field, FieldType

__all__ = ["Structs", "class_text"]

_FORMATS: Final = {
    "bool": ("?", 1),
    "byte": ("c", 1),
    "int8": ("b", 1),
    "uint8": ("B", 1),
    "int16": ("h", 2),
    "uint16": ("H", 2),
    "int32": ("i", 4),
    "uint32": ("I", 4),
    "int64": ("q", 8),
    "uint64": ("Q", 8),
    "float32": ("f", 4),
    "float64": ("d", 8),
}
"""Primitive type → its letter in a struct format; its size, which is its alignment, in bytes."""

_PYTHON: Final = {"bool": ("bool", "False"), "byte": ("bytes", r'b"\x00"'), "string": ("str", '""')}
"""Primitive type → its Python type and default; a number is an int or a float."""

_ALIGN: Final = {
    2: "position = (position + 1) & -2",
    4: "position = (position + 3) & -4",
    8: "position = ((position + 3) & -8) + 4",
}
_RESERVED: Final = frozenset({"self", "copy", "encode_into", "decode_from"})


@dataclass
class Structs:
    """The packed formats of a module; each gets a name on first use."""

    formats: list[str] = field(default_factory=list)

    def name(self, letters: str) -> str:
        """Return the name of a format's `Struct`."""
        if letters not in self.formats:
            self.formats.append(letters)
        return f"_STRUCT_{self.formats.index(letters)}"

    def lines(self) -> Iterator[str]:
        """Return the lines that define the names."""
        for index, letters in enumerate(self.formats):
            yield f'_STRUCT_{index} = Struct("<{letters}")'
        if self.formats:
            yield ""


@dataclass
class _Run:
    """Primitive numbers that lie side by side, packed at once, with the padding between them."""

    align: int
    letters: str = ""
    size: int = 0
    fields: list[Field] = field(default_factory=list)

    def add(self, member: Field) -> bool:
        """Take another field, unless its padding depends on where the run starts."""
        letter, align = _FORMATS[member.type.base]
        if align > self.align:
            return False
        padding = -self.size % align
        self.letters += "x" * padding + letter
        self.size += padding + align
        self.fields.append(member)
        return True


@dataclass
class _Sequences:
    """Sequences of any length that lie side by side, of which mostly all are empty."""

    fields: list[Field]

    @property
    def nothing(self) -> str:
        """The bytes of all of them where they are empty."""
        return f'b"\\0" * {4 * len(self.fields)}'


_Part: TypeAlias = Field | _Run | _Sequences


def class_text(definition: Definition, structs: Structs, name: str | None = None) -> str:
    """Return the source of a message's class.

    Args:
        definition: the message.
        structs: the packed formats of the module; the class adds those that it needs.
        name: the name of the class, if it is not the message's own.

    Raises:
        InterfaceError: a field has a name that Python or the base class needs.
    """
    for member in definition.fields:
        if iskeyword(member.name) or member.name in _RESERVED:
            raise InterfaceError(
                f"{definition.name} has a field {member.name!r}, which cannot be an attribute."
            )
    parts = list(_parts(definition.fields))
    methods = (
        _constructor(definition),
        _copy(definition),
        _encoder(parts, structs),
        _decoder(parts, structs),
    )
    lines = [*_head(definition, name or definition.name.rpartition("/")[2])]
    for method in methods:
        lines.append("")
        lines.extend(f"    {line}" for line in method)
    return "\n".join(lines) + "\n"


def _parts(fields: tuple[Field, ...]) -> Iterator[_Part]:
    """Yield groups of fields that are packed at once."""
    for kind, group in groupby(fields, _kind):
        members = list(group)
        if kind == "numbers":
            yield from _runs(members)
        elif kind == "sequences" and len(members) > 1:
            yield _Sequences(members)
        else:
            yield from members


def _kind(member: Field) -> str:
    if member.type.is_array:
        return "sequences" if member.type.size is None else "array"
    return "numbers" if member.type.base in _FORMATS else "other"


def _runs(members: list[Field]) -> Iterator[_Run]:
    run: _Run | None = None
    for member in members:
        if run is None or not run.add(member):
            if run:
                yield run
            run = _Run(_FORMATS[member.type.base][1])
            run.add(member)
    if run:
        yield run


def _head(definition: Definition, name: str) -> Iterator[str]:
    yield f"class {name}(Message):"
    yield f'    """{definition.name}."""'
    yield ""
    names = [member.name for member in definition.fields]
    yield f"    __slots__ = {tuple(names)}"
    yield f'    __ros_name__ = "{definition.name}"'
    pairs = [f'"{member.name}": "{member.type}"' for member in definition.fields]
    yield from _exploded("    __ros_fields__ = MappingProxyType({", pairs, "})")
    if definition.constants:
        yield ""
    for constant in definition.constants:
        yield f"    {constant.name} = {_literal(constant.value)}"
    if names:
        yield ""
    for member in definition.fields:
        yield f"    {member.name}: {_annotation(member.type)}"


def _exploded(start: str, items: list[str], end: str) -> Iterator[str]:
    """Yield the lines of a list in brackets, an item a line."""
    indent = " " * (len(start) - len(start.lstrip()))
    yield start
    yield from (f"{indent}    {item}," for item in items)
    yield indent + end


def _constructor(definition: Definition) -> Iterator[str]:
    if not definition.fields:
        yield "def __init__(self) -> None:"
        yield "    pass"
        return
    yield from _exploded("def __init__(", ["self", "*", *map(_parameter, definition.fields)], ") -> None:")
    for member in definition.fields:
        name, kind = member.name, member.type
        if not kind.is_message and not kind.is_array:
            yield f"    self.{name} = {name}"
        else:
            given = f"array_of({name}, {kind.base.upper()})" if kind.is_numpy else name
            yield f"    self.{name} = {_default(member)} if {name} is None else {given}"


def _parameter(member: Field) -> str:
    if member.type.is_numpy:
        return f"{member.name}: npt.ArrayLike | None = None"
    if member.type.is_message or member.type.is_array:
        return f"{member.name}: {_annotation(member.type)} | None = None"
    return f"{member.name}: {_annotation(member.type)} = {_default(member)}"


def _copy(definition: Definition) -> Iterator[str]:
    yield "def copy(self) -> Self:"
    if not definition.fields:
        yield "    return object.__new__(self.__class__)"
        return
    yield "    new = object.__new__(self.__class__)"
    guarded = any(member.type.is_message or member.type.is_array for member in definition.fields)
    indent = "        " if guarded else "    "
    if guarded:
        yield "    try:"
    for member in definition.fields:
        yield f"{indent}new.{member.name} = {_copied(member)}"
    if guarded:
        yield "    except (AttributeError, TypeError, InterfaceError) as error:"
        yield "        raise misfit(self, error) from error"
    yield "    return new"


def _copied(member: Field) -> str:
    kind, value = member.type, f"self.{member.name}"
    if kind.is_numpy:
        return f"frozen({value}, {kind.base.upper()})"
    if kind.is_message:
        element = _python(kind)
        return f"[{element}.copy(item) for item in {value}]" if kind.is_array else f"{element}.copy({value})"
    return f"list({value})" if kind.is_array else value


def _encoder(parts: list[_Part], structs: Structs) -> Iterator[str]:
    yield "def encode_into(self, out: bytearray) -> None:"
    for part in parts:
        yield from (f"    {line}" for line in _encode(part, structs))
    if not parts:
        yield "    out.append(0)"


def _encode(part: _Part, structs: Structs) -> Iterator[str]:
    if isinstance(part, _Run):
        yield from _encode_run(part, structs)
    elif isinstance(part, _Sequences):
        yield f"if {' or '.join(f'len(self.{member.name})' for member in part.fields)}:"
        yield from (f"    {line}" for member in part.fields for line in _encode_field(member))
        yield "else:"
        yield f"    out += PAD4[len(out) & 3] + {part.nothing}"
    else:
        yield from _encode_field(part)


def _encode_run(run: _Run, structs: Structs) -> Iterator[str]:
    values = [
        f"BOOLS[self.{member.name}]" if member.type.base == "bool" else f"self.{member.name}"
        for member in run.fields
    ]
    if run.align > 1:
        yield f"out += PAD{run.align}[len(out) & {run.align - 1}]"
    yield from _exploded(f"out += {structs.name(run.letters)}.pack(", values, ")")


def _encode_field(member: Field) -> Iterator[str]:
    kind, value = member.type, f"self.{member.name}"
    bound = f", {kind.string_bound}" if kind.string_bound else ""
    if not kind.is_array:
        if kind.is_message:
            yield f"{_python(kind)}.encode_into({value}, out)"
        else:
            yield f"write_string(out, {value}{bound})"
        return
    if kind.size is not None:
        value = f"exactly({value}, {kind.size})"
    elif kind.limit is not None:
        value = f"at_most({value}, {kind.limit})"
    if kind.is_numpy:
        yield f"write_{'array' if kind.size is None else 'numbers'}(out, {value}, {kind.base.upper()})"
        return
    if kind.size is None:
        yield f"write_size(out, len(self.{member.name}))"
    elements = f", {_python(kind)}" if kind.is_message else bound
    yield f"write_{_plural(kind)}(out, {value}{elements})"


def _decoder(parts: list[_Part], structs: Structs) -> Iterator[str]:
    yield "@classmethod"
    yield "def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:"
    if not parts:
        yield "    return cls(), read_dummy(raw, position)"
        return
    yield "    new = object.__new__(cls)"
    for part in parts:
        yield from (f"    {line}" for line in _decode(part, structs))
    yield "    return new, position"


def _decode(part: _Part, structs: Structs) -> Iterator[str]:
    if isinstance(part, _Run):
        yield from _decode_run(part, structs)
    elif isinstance(part, _Sequences):
        yield _ALIGN[4]
        yield f"if raw.startswith({part.nothing}, position):"
        yield from (f"    new.{member.name} = {_nothing(member.type)}" for member in part.fields)
        yield f"    position += {4 * len(part.fields)}"
        yield "else:"
        yield from (f"    {line}" for member in part.fields for line in _decode_field(member))
    else:
        yield from _decode_field(part)


def _decode_run(run: _Run, structs: Structs) -> Iterator[str]:
    if run.align > 1:
        yield _ALIGN[run.align]
    targets = [f"new.{member.name}" for member in run.fields]
    yield from _exploded("(", targets, f") = {structs.name(run.letters)}.unpack_from(raw, position)")
    yield f"position += {run.size}"


def _decode_field(member: Field) -> Iterator[str]:
    kind, target = member.type, f"new.{member.name}, position = "
    if not kind.is_array:
        read = f"{_python(kind)}.decode_from" if kind.is_message else "read_string"
        yield f"{target}{read}(raw, position)"
        return
    if kind.is_numpy and kind.size is None:
        yield f"{target}read_array(raw, position, {kind.base.upper()})"
        return
    size = "size" if kind.size is None else str(kind.size)
    if kind.size is None:
        yield "size, position = read_size(raw, position)"
    if kind.is_numpy:
        yield f"{target}read_numbers(raw, position, {kind.base.upper()}, {size})"
    else:
        elements = f", {_python(kind)}" if kind.is_message else ""
        yield f"{target}read_{_plural(kind)}(raw, position, {size}{elements})"


def _plural(kind: FieldType) -> str:
    return (
        "messages" if kind.is_message else {"bool": "bools", "byte": "bytes", "string": "strings"}[kind.base]
    )


def _python(kind: FieldType) -> str:
    """Return the Python type of an element."""
    if kind.is_message:
        return kind.base.rpartition("/")[2]
    return _PYTHON[kind.base][0] if kind.base in _PYTHON else "float" if "float" in kind.base else "int"


def _annotation(kind: FieldType) -> str:
    if kind.is_numpy:
        return f"npt.NDArray[np.{kind.base}]"
    return f"list[{_python(kind)}]" if kind.is_array else _python(kind)


def _default(member: Field) -> str:
    kind = member.type
    if member.default is not None:
        value = _literal(member.default)
        return f"array_of({value}, {kind.base.upper()})" if kind.is_numpy else value
    if kind.is_array and kind.size is None:
        return _nothing(kind)
    if kind.is_numpy:
        return f"zeros({kind.base.upper()}, {kind.size})"
    if kind.is_array:
        return f"[{_default_element(kind)} for _ in range({kind.size})]"
    return _default_element(kind)


def _nothing(kind: FieldType) -> str:
    """Return the source of an empty sequence."""
    return f"empty({kind.base.upper()})" if kind.is_numpy else "[]"


def _default_element(kind: FieldType) -> str:
    if kind.is_message:
        return f"{_python(kind)}()"
    return _PYTHON[kind.base][1] if kind.base in _PYTHON else "0.0" if "float" in kind.base else "0"


def _literal(value: object) -> str:
    """Return the source of a constant; a byte by its number, as the definition gives it."""
    if isinstance(value, list):
        return f"[{', '.join(map(_literal, value))}]"
    return f"bytes([{value[0]}])" if isinstance(value, bytes) else repr(value)
