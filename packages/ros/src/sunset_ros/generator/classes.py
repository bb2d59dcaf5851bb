"""The source of a generated message class."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain, groupby
from keyword import iskeyword
from struct import calcsize
from typing import Final, TypeAlias

from sunset_ros.errors import InterfaceError
from sunset_ros.generator.definitions import NUMERIC, Definition, Field, FieldType

_LETTERS: Final = dict(zip(NUMERIC, "bBhHiIqQfd", strict=True)) | {"bool": "?", "byte": "c"}
"""Primitive type → its letter in a struct format."""

_PYTHON: Final = {"bool": ("bool", "False"), "byte": ("bytes", r'b"\x00"'), "string": ("str", '""')}
"""Primitive type → its Python type and default; a number is an int or a float."""

_ALIGN: Final = {
    2: "position = (position + 1) & -2",
    4: "position = (position + 3) & -4",
    8: "position = ((position + 3) & -8) + 4",
}
_RESERVED: Final = frozenset({"self", "copy", "encode_into", "decode_from"})


class Structs(dict[str, str]):
    """The packed formats of a module → the names of their `Struct`, made on first use."""

    def __missing__(self, letters: str) -> str:
        name = self[letters] = f"_STRUCT_{len(self)}"
        return name


@dataclass
class _Run:
    """Primitive numbers that lie side by side, packed at once, with the padding between them."""

    align: int
    letters: str = ""
    size: int = 0
    fields: list[Field] = field(default_factory=list)

    def add(self, member: Field) -> bool:
        """Take another field, unless its padding depends on where the run starts."""
        letter = _LETTERS[member.type.base]
        align = calcsize(letter)
        if align > self.align:
            return False
        padding = -self.size % align
        self.letters += "x" * padding + letter
        self.size += padding + align
        self.fields.append(member)
        return True


_Part: TypeAlias = Field | _Run


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
    parts = _parts(definition.fields)
    lines = [*_head(definition, name or definition.name.rpartition("/")[2])]
    for method in (
        _constructor(definition),
        _copy(definition),
        _encoder(parts, structs),
        _decoder(parts, structs),
    ):
        lines.append("")
        lines.extend(f"    {line}" for line in method)
    return "\n".join(lines) + "\n"


def _parts(fields: tuple[Field, ...]) -> list[_Part]:
    """Return the fields, numbers in runs."""
    parts: list[_Part] = []
    for member in fields:
        if member.type.is_array or member.type.base not in _LETTERS:
            parts.append(member)
            continue
        if not parts or not isinstance(run := parts[-1], _Run) or not run.add(member):
            parts.append(run := _Run(calcsize(_LETTERS[member.type.base])))
            run.add(member)
    return parts


def _head(definition: Definition, name: str) -> Iterator[str]:
    yield f"class {name}(Message):"
    yield f'    """{definition.name}."""'
    yield ""
    names = [member.name for member in definition.fields]
    yield f"    __slots__ = {tuple(names)}"
    yield f'    __ros_name__ = "{definition.name}"'
    pairs = ", ".join(f'"{member.name}": "{member.type}"' for member in definition.fields)
    yield f"    __ros_fields__ = MappingProxyType({{{pairs}}})"
    if definition.constants:
        yield ""
    for constant in definition.constants:
        yield f"    {constant.name} = {_literal(constant.value)}"
    if names:
        yield ""
    for member in definition.fields:
        yield f"    {member.name}: {_annotation(member.type)}"


def _constructor(definition: Definition) -> Iterator[str]:
    if not definition.fields:
        yield "def __init__(self) -> None:"
        yield "    pass"
        return
    yield f"def __init__(self, *, {', '.join(map(_parameter, definition.fields))}) -> None:"
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
    yield "    try:"
    yield from (f"        new.{member.name} = {_copied(member)}" for member in definition.fields)
    yield "    except (AttributeError, TypeError, InterfaceError) as error:"
    yield "        raise misfit(self, error) from error"
    yield "    return new"


def _copied(member: Field) -> str:
    kind, value = member.type, f"self.{member.name}"
    if kind.is_numpy:
        return f"frozen({value}, {kind.base.upper()})"
    if kind.is_message:
        element = _python(kind)
        return (
            f"[copied(item, {element}) for item in {value}]"
            if kind.is_array
            else f"copied({value}, {element})"
        )
    return f"list({value})" if kind.is_array else value


def _groups(parts: list[_Part]) -> Iterator[list[_Part]]:
    """Yield the parts, of several sequences side by side all at once: as a rule they are all empty."""
    for are_sequences, group in groupby(parts, _is_sequence):
        members = list(group)
        yield from [members] if are_sequences else ([part] for part in members)


def _is_sequence(part: _Part) -> bool:
    return isinstance(part, Field) and part.type.is_array and part.type.size is None


def _sizes(sequences: list[_Part]) -> str:
    """Return the source of the sizes of empty sequences, as they are encoded."""
    return rf'b"\0" * {4 * len(sequences)}'


def _either(condition: str, lines: list[str], others: list[str]) -> list[str]:
    indented = [f"    {line}" for line in lines], [f"    {line}" for line in others]
    return [f"if {condition}:", *indented[0], "else:", *indented[1]]


def _encoder(parts: list[_Part], structs: Structs) -> Iterator[str]:
    yield "def encode_into(self, out: bytearray) -> None:"
    for group in _groups(parts):
        encoded = (
            _encode_run(part, structs) if isinstance(part, _Run) else _encode_field(part) for part in group
        )
        lines = list(chain.from_iterable(encoded))
        if len(group) > 1:
            sizes = " or ".join(f"len(self.{part.name})" for part in group if isinstance(part, Field))
            empty = f"out += PAD4[len(out) & 3] + {_sizes(group)}"
            lines = _either(sizes, lines, [empty])
        yield from (f"    {line}" for line in lines)
    if not parts:
        yield "    out.append(0)"


def _encode_run(run: _Run, structs: Structs) -> Iterator[str]:
    plain = ((f"self.{member.name}", member.type.base) for member in run.fields)
    values = [f"BOOLS[{value}]" if base == "bool" else value for value, base in plain]
    if run.align > 1:
        yield f"out += PAD{run.align}[len(out) & {run.align - 1}]"
    yield f"out += {structs[run.letters]}.pack({', '.join(values)})"


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
    if kind.is_message:
        yield f"write_messages(out, {value}, {_python(kind)})"
    else:
        yield f"write_{kind.base}s(out, {value}{bound})"


def _decoder(parts: list[_Part], structs: Structs) -> Iterator[str]:
    yield "@classmethod"
    yield "def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:"
    if not parts:
        yield "    return cls(), read_dummy(raw, position)"
        return
    yield "    new = object.__new__(cls)"
    for group in _groups(parts):
        decoded = (
            _decode_run(part, structs) if isinstance(part, _Run) else _decode_field(part) for part in group
        )
        lines = list(chain.from_iterable(decoded))
        if len(group) > 1:
            yield f"    {_ALIGN[4]}"
            empty = [f"new.{part.name} = {_empty(part.type)}" for part in group if isinstance(part, Field)]
            empty.append(f"position += {4 * len(group)}")
            lines = _either(f"raw.startswith({_sizes(group)}, position)", empty, lines)
        yield from (f"    {line}" for line in lines)
    yield "    return new, position"


def _decode_run(run: _Run, structs: Structs) -> Iterator[str]:
    if run.align > 1:
        yield _ALIGN[run.align]
    targets = "".join(f"new.{member.name}, " for member in run.fields)
    yield f"({targets}) = {structs[run.letters]}.unpack_from(raw, position)"
    yield f"position += {run.size}"


def _decode_field(member: Field) -> Iterator[str]:
    kind, target = member.type, f"new.{member.name}, position = "
    read = f"{_python(kind)}.decode_from" if kind.is_message else "read_string"
    if not kind.is_array:
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
    elif kind.base in _LETTERS:
        yield f"{target}read_{kind.base}s(raw, position, {size})"
    else:
        yield f"{target}read_items(raw, position, {size}, {read})"


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
        return _empty(kind)
    if kind.is_numpy:
        return f"np.zeros({kind.size}, {kind.base.upper()})"
    if kind.is_array:
        return f"[{_default_element(kind)} for _ in range({kind.size})]"
    return _default_element(kind)


def _empty(kind: FieldType) -> str:
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
