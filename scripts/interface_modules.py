"""Writes the typed Python modules from the .msg and .srv files; `scripts/generate_interfaces` runs it."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Final

from scripts.interface_classes import Structs, class_text

from sunset.interfaces._definition import DEFINITIONS, Definition, parse_message, parse_service

__all__ = ["generate"]

_WORDS: Final = {"msg": "messages", "srv": "services"}
_HELPERS: Final = "_check", "_codec", "_message", "_values"
"""The modules that generated code is made of."""


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
            files = sorted((folder / kind).glob(f"*.{kind}"))
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
    head = [
        f'"""The {_WORDS[kind]} of `{package}`, written by scripts/generate_interfaces."""\n',
        _imports(f"{package}/{kind}", definitions),
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


def _imports(own: str, definitions: Iterable[Definition]) -> str:
    lines = [
        "from struct import Struct",
        "from types import MappingProxyType",
        "from typing import Self\n",
        "import numpy as np",
        "import numpy.typing as npt\n",
        "from sunset.errors import InterfaceError",
        *(f"from sunset.interfaces.{module} import *" for module in _HELPERS),
    ]
    kinds = {field.type.base for definition in definitions for field in definition.fields}
    for kind in sorted(kinds):
        module, _, name = kind.rpartition("/")
        if module not in {"", own}:
            lines.append(f"from sunset.interfaces.{module.replace('/', '.')} import {name}")
    return "\n".join(lines) + "\n"


def _dependencies_first(definitions: Sequence[Definition]) -> Iterator[Definition]:
    waiting = {definition.name: definition for definition in definitions}

    def emit(definition: Definition) -> Iterator[Definition]:
        for field in definition.fields:
            if field.type.base in waiting:
                yield from emit(waiting.pop(field.type.base))
        yield definition

    while waiting:
        yield from emit(waiting.pop(next(iter(waiting))))
