"""Writes the typed Python modules from the .msg and .srv files; `scripts/generate_interfaces` runs it.

The text that it writes is what the formatter would leave unchanged.
"""

import builtins
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Final

from sunset.interfaces._class_text import Structs, class_text, natural
from sunset.interfaces._definition import DEFINITIONS, Definition, parse_message, parse_service

__all__ = ["generate"]

_WORDS: Final = {"msg": "messages", "srv": "services"}
_HELPERS: Final = {
    "_check": ("misfit",),
    "_codec": (
        *(
            "BOOLS",
            "PAD2",
            "PAD4",
            "PAD8",
            "read_array",
            "read_bools",
            "read_bytes",
            "read_dummy",
            "read_messages",
        ),
        *(
            "read_numbers",
            "read_size",
            "read_string",
            "read_strings",
            "write_array",
            "write_bools",
            "write_bytes",
        ),
        *("write_messages", "write_numbers", "write_size", "write_string", "write_strings"),
    ),
    "_message": ("Message", "Service"),
    "_values": (
        *("FLOAT32", "FLOAT64", "INT8", "INT16", "INT32", "INT64", "UINT8", "UINT16", "UINT32", "UINT64"),
        *("array_of", "at_most", "empty", "exactly", "frozen", "zeros"),
    ),
}
"""Module → what generated code may use of it, in the order in which imports are sorted."""


def generate(definitions: Path = DEFINITIONS) -> dict[str, str]:
    """Return the text of every generated module by its path below the `interfaces` package.

    Raises:
        InterfaceError: a definition is malformed.
    """
    modules = {}
    for folder in sorted(path for path in definitions.iterdir() if path.is_dir()):
        package = folder.name
        kinds = [kind for kind in _WORDS if any((folder / kind).glob(f"*.{kind}"))]
        for kind in kinds:
            files = sorted((folder / kind).glob(f"*.{kind}"), key=lambda path: natural(path.stem))
            modules[f"{package}/{kind}/__init__.py"] = _module(package, kind, files)
        names = ", ".join(f'"{kind}"' for kind in kinds)
        modules[f"{package}/__init__.py"] = (
            f'"""The interfaces of the ROS package `{package}`."""\n\n'
            f"from sunset.interfaces.{package} import {', '.join(kinds)}\n\n__all__ = [{names}]\n"
        )
    return modules


def _module(package: str, kind: str, files: Sequence[Path]) -> str:
    structs = Structs()
    definitions: list[Definition] = []
    bodies: list[str] = []
    if kind == "msg":
        parsed = [parse_message(path.read_text(), f"{package}/msg/{path.stem}") for path in files]
        definitions = list(_dependencies_first(parsed))
        bodies = [class_text(definition, structs) for definition in definitions]
    else:
        for path in files:
            name = f"{package}/srv/{path.stem}"
            parts = parse_service(path.read_text(), name)
            definitions += parts
            bodies.append(_service(name, parts, structs))
    code = "\n\n".join(bodies)
    exports = "".join(f'    "{path.stem}",\n' for path in files)
    fields = chain.from_iterable(definition.fields for definition in definitions)
    shadows = any(hasattr(builtins, field.name) for field in fields)
    head = [
        *(["# ruff: noqa: A002  a parameter has the name of its ROS field"] if shadows else []),
        f'"""The {_WORDS[kind]} of `{package}`, written by scripts/generate_interfaces."""\n',
        _imports(code, f"{package}/{kind}", definitions),
        f"__all__ = [\n{exports}]\n",
    ]
    return "\n".join([*head, *structs.lines(), "", code])


def _service(name: str, parts: tuple[Definition, Definition], structs: Structs) -> str:
    lines = [
        f"class {name.rpartition('/')[2]}(Service):",
        f'    """{name}."""',
        "",
        "    __slots__ = ()",
        f'    __ros_name__ = "{name}"',
    ]
    for part, short in zip(parts, ("Request", "Response"), strict=True):
        lines.append("")
        text = class_text(part, structs, short)
        lines.extend(f"    {line}" if line else "" for line in text.splitlines())
    return "\n".join(lines) + "\n"


def _imports(code: str, own: str, definitions: Iterable[Definition]) -> str:
    standard = ["from types import MappingProxyType\n", "from typing import Self\n"]
    if "_STRUCT_" in code:
        standard.insert(0, "from struct import Struct\n")
    numpy = "import numpy as np\nimport numpy.typing as npt\n\n" if "npt." in code else ""
    lines = ["from sunset.errors import InterfaceError\n"] if "InterfaceError" in code else []
    for module, names in _HELPERS.items():
        used = [name for name in names if re.search(rf"\b{name}\b", code)]
        if used:
            lines.append(_import(f"sunset.interfaces.{module}", used))
    foreign: dict[str, set[str]] = {}
    for field in chain.from_iterable(definition.fields for definition in definitions):
        module, _, name = field.type.base.rpartition("/")
        if name and module and module != own:
            foreign.setdefault(module, set()).add(name)
    lines += [
        _import(f"sunset.interfaces.{module.replace('/', '.')}", sorted(foreign[module], key=natural))
        for module in sorted(foreign)
    ]
    return f"{''.join(standard)}\n{numpy}{''.join(lines)}"


def _import(module: str, names: Sequence[str]) -> str:
    if len(names) == 1:
        return f"from {module} import {names[0]}\n"
    return f"from {module} import (\n{''.join(f'    {name},{chr(10)}' for name in names)})\n"


def _dependencies_first(definitions: Sequence[Definition]) -> Iterator[Definition]:
    waiting = {definition.name: definition for definition in definitions}

    def emit(definition: Definition) -> Iterator[Definition]:
        for field in definition.fields:
            if field.type.base in waiting:
                yield from emit(waiting.pop(field.type.base))
        yield definition

    while waiting:
        yield from emit(waiting.pop(next(iter(waiting))))
