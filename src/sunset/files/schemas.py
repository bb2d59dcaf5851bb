"""Validation of JSON files and of values from Python, with a sentence for each mismatch.

A schema is a dataclass or a `msgspec.Struct`. Its annotations have ranges, as in `Annotated[int, Meta(ge=1, le=4096)]`;
descriptions for messages where ranges do not suffice, as in `Meta(description=...)`; and other names of fields for
messages, as in `Meta(title=...)`.
"""

import json
from collections.abc import Iterator, Mapping
from enum import Enum
from functools import cache
from pathlib import Path
from types import MappingProxyType, NoneType, UnionType
from typing import Annotated, Final, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import msgspec
from msgspec.inspect import DataclassType, StructType, type_info

from sunset.errors import InvalidInputError, SunsetError
from sunset.files.inputs import read_text
from sunset.texts.sentences import printable_json
from sunset_ros.texts import shown

_T = TypeVar("_T")

_PLAIN: Final = {
    str: "a text",
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    NoneType: "null",
    list: "a list",
    tuple: "a list",
    Path: "a path",
}
"""Types in words; all others are objects."""
_MISSING: Final = object()


def read_json(file: Path, label: str, error: type[InvalidInputError], *, missing: str = "") -> object:
    """Return the content of a JSON file, with every text in it made printable.

    Args:
        file: the file.
        label: its kind in messages, such as `The model card`.
        error: the class of the exception.
        missing: the sentence for a missing file.

    Raises:
        InvalidInputError: of the class `error`: the file is missing, cannot be read, or is not JSON, as NaN is not.
    """
    try:
        content = json.loads(read_text(file))
        json.dumps(
            content, ensure_ascii=False, allow_nan=False
        ).encode()  # raises for NaN and lone surrogates
        return printable_json(content)
    except FileNotFoundError as cause:
        raise error(missing or f"{label} {file} is missing.") from cause
    except OSError as cause:
        raise error(f"{label} {file} cannot be read: {cause.strerror}.") from cause
    except (RecursionError, ValueError) as cause:
        raise error(f"{label} {file} is damaged and cannot be read as JSON: {cause}.") from cause


def convert(
    content: object,
    kind: type[_T],
    where: str,
    error: type[InvalidInputError],
    *,
    remedy: str,
    path: tuple[str, ...] = (),
) -> _T:
    """Return the content of a JSON file as a value of its schema; unknown keys are ignored.

    Args:
        content: a result of `read_json`, or a part of it.
        kind: the schema.
        where: the file in messages.
        error: the class of the exception.
        remedy: the end of the sentence.
        path: the keys that lead to this part of the file.

    Raises:
        InvalidInputError: of the class `error`, with a sentence: file, key, expected and actual value, remedy.
    """
    try:
        return msgspec.convert(content, kind)
    except msgspec.ValidationError as cause:
        keys, value, expected = _misfit(content, kind, path)
        got = "nothing" if value is _MISSING else shown(value)
        subject = f"The {'.'.join(keys)} in {where}" if keys else f"{where[:1].upper()}{where[1:]}"
        raise error(f"{subject} must be {_described(expected)}, got {got}; {remedy}.") from cause


def check_fields(instance: object, error: type[SunsetError] = InvalidInputError) -> None:
    """Check that the fields of a dataclass have the types and ranges of its annotations."""
    schema: type = type(instance)
    for name, kind in fields_of(schema).items():
        value = getattr(instance, name)
        if not _fits(value, kind):
            expected = _described(kind).removesuffix(" or null")
            raise error(f"The {_title(kind) or name} must be {expected}, got {shown(value)}.")


def document_text(document: object) -> str:
    """Return a value of a schema as JSON with sorted keys: the same value gives the same text.

    Raises:
        ValueError: JSON cannot represent a number in it, such as NaN.
        TypeError: JSON cannot represent another value in it.
    """
    plain = msgspec.to_builtins(document, str_keys=True)
    return json.dumps(plain, sort_keys=True, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


@cache
def fields_of(kind: type) -> Mapping[str, type]:
    """Return the annotations of a schema's fields by name, ranges included."""
    return MappingProxyType(get_type_hints(kind, include_extras=True))


def _misfit(value: object, kind: object, path: tuple[str, ...]) -> tuple[tuple[str, ...], object, object]:
    """Return the keys that lead to the innermost part that does not fit, the part, and its type."""
    for key, part, inner in _parts(value, kind):
        if part is _MISSING or not _fits(part, inner):
            return _misfit(part, inner, (*path, key))
    return path, value, kind


def _parts(value: object, kind: object) -> Iterator[tuple[str, object, object]]:
    """Yield keys, values and types of the parts of a value of this type; absent optional parts are left out."""
    if get_origin(kind) is Annotated:
        kind = get_args(kind)[0]
    origin, arguments = get_origin(kind), get_args(kind)
    if isinstance(value, dict) and origin in (dict, Mapping):
        for key, part in value.items():
            yield str(key), key, arguments[0]
            yield key.name.lower() if isinstance(key, Enum) else str(key), part, arguments[1]
    elif isinstance(value, list) and origin in (list, tuple):
        for place, part in enumerate(value):
            yield str(place), part, arguments[0]
    elif isinstance(value, dict) and isinstance(kind, type):
        types, info = fields_of(kind), type_info(kind)
        for field in info.fields if isinstance(info, StructType | DataclassType) else ():
            if field.required or field.name in value:
                yield field.name, value.get(field.name, _MISSING), types[field.name]


def _fits(value: object, kind: object) -> bool:
    try:
        msgspec.convert(value, kind)
    except msgspec.ValidationError:
        return False
    except TypeError:  # msgspec does not know the type, such as a class or a function
        return True
    return True


def _described(kind: object) -> str:
    """Return a type in words.

    >>> _described(Annotated[float, msgspec.Meta(ge=0, le=1)] | None)
    'a number from 0 to 1 or null'
    """
    origin, arguments = get_origin(kind), get_args(kind)
    if limits := _meta(kind):
        return limits.description or f"{_described(arguments[0])}{_range(limits)}"
    if origin in (Union, UnionType):
        return " or ".join(_described(part) for part in arguments if part is not msgspec.UnsetType)
    if origin is Literal:
        return " or ".join(map(repr, arguments))
    return next((words for known, words in _PLAIN.items() if known in (origin, kind)), "an object")


def _title(kind: object) -> str:
    """Return the name in messages of a field of this type; empty for the field's own name."""
    if get_origin(kind) in (Union, UnionType):
        return next(filter(None, map(_title, get_args(kind))), "")
    limits = _meta(kind)
    return (limits and limits.title) or ""


def _meta(kind: object) -> msgspec.Meta | None:
    remarks = get_args(kind)[1:] if get_origin(kind) is Annotated else ()
    return next((remark for remark in remarks if isinstance(remark, msgspec.Meta)), None)


def _range(limits: msgspec.Meta) -> str:
    match limits.ge, limits.gt, limits.le, limits.lt:
        case None, None, None, None:
            return ""
        case low, None, None, high:
            return f" from {low:g} to below {high:g}"
        case None, low, high, _:
            return f" above {low:g} and at most {high:g}"
        case low, _, high, _:
            return f" from {low:g} to {high:g}"
