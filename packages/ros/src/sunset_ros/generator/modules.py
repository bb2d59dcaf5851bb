"""Generates the typed Python modules of .msg and .srv files."""

from collections.abc import Iterable, Mapping, Sequence
from graphlib import TopologicalSorter
from pathlib import Path
from typing import Final

from sunset_ros.generator.classes import Structs, class_text
from sunset_ros.generator.definitions import PARTS, Definition, parse_message, split_service

_WORDS: Final = {"msg": "messages", "srv": "services"}
_LIBRARY: Final = "sunset_ros.interfaces"
_HELPERS: Final = "_codec", "_message", "_serialization"
"""The modules that generated code is made of."""


def generate(definitions: Path, python_package: str) -> dict[str, str]:
    """Return the text of every module of a Python package's interfaces, by its path in the package.

    Args:
        definitions: the folder of the files, `<package>/msg/<Name>.msg` and `<package>/srv/<Name>.srv`.
        python_package: the Python package that the modules belong to, such as `my_nodes`.

    Raises:
        InterfaceError: a definition is malformed.
    """
    files: dict[str, dict[str, list[Path]]] = {}
    for kind in _WORDS:
        for path in sorted(definitions.glob(f"*/{kind}/*.{kind}")):
            files.setdefault(path.parts[-3], {}).setdefault(kind, []).append(path)
    homes = {package: f"{python_package}.{package}" for package in files}
    modules = {}
    for package, kinds in sorted(files.items()):
        for kind, paths in kinds.items():
            modules[f"{package}/{kind}/__init__.py"] = _module(package, kind, paths, homes)
        names = ", ".join(f'"{kind}"' for kind in kinds)
        modules[f"{package}/__init__.py"] = (
            f'"""The interfaces of the ROS package `{package}`."""\n\n'
            f"from {homes[package]} import {', '.join(kinds)}\n\n__all__ = [{names}]\n"
        )
    return modules


def _module(package: str, kind: str, files: Sequence[Path], homes: Mapping[str, str]) -> str:
    structs = Structs()
    definitions: list[Definition] = []
    bodies: list[str] = []
    if kind == "msg":
        parsed = [
            parse_message(path.read_text(encoding="utf-8"), f"{package}/msg/{path.stem}") for path in files
        ]
        definitions = _dependencies_first(parsed)
        bodies = [class_text(definition, structs) for definition in definitions]
    else:
        for path in files:
            name = f"{package}/srv/{path.stem}"
            texts = split_service(path.read_text(encoding="utf-8"), name)
            parts = [parse_message(text, f"{name}_{part}") for text, part in zip(texts, PARTS, strict=True)]
            definitions += parts
            bodies.append(_service(name, parts, structs))
    code = "\n\n".join(bodies)
    exports = "".join(f'    "{path.stem}",\n' for path in files)
    head = [
        f'"""The {_WORDS[kind]} of `{package}`, generated from their definitions."""\n',
        _imports(f"{package}/{kind}", definitions, homes),
        f"__all__ = [\n{exports}]\n",
    ]
    packed = [f'{name} = Struct("<{letters}")' for letters, name in structs.items()]
    return "\n".join([*head, *packed, *([""] if packed else []), "", code])


def _service(name: str, parts: Sequence[Definition], structs: Structs) -> str:
    lines = [
        f"class {name.rpartition('/')[2]}(Service):",
        f'    """{name}."""',
        "",
        "    __slots__ = ()",
        f'    __ros_name__ = "{name}"',
    ]
    for part, short in zip(parts, PARTS, strict=True):
        lines.append("")
        text = class_text(part, structs, short)
        lines.extend(f"    {line}" if line else "" for line in text.splitlines())
    return "\n".join(lines) + "\n"


def _imports(own: str, definitions: Iterable[Definition], homes: Mapping[str, str]) -> str:
    lines = [
        "from struct import Struct",
        "from types import MappingProxyType",
        "from typing import Self\n",
        "import numpy as np",
        "import numpy.typing as npt\n",
        "from sunset_ros.errors import InterfaceError",
        *(f"from {_LIBRARY}.{module} import *" for module in _HELPERS),
    ]
    kinds = {field.type.base for definition in definitions for field in definition.fields}
    for kind in sorted(kinds):
        module, _, name = kind.rpartition("/")
        if module not in {"", own}:
            package, _, part = module.partition("/")
            lines.append(f"from {homes.get(package, f'{_LIBRARY}.{package}')}.{part} import {name}")
    return "\n".join(lines) + "\n"


def _dependencies_first(definitions: Sequence[Definition]) -> list[Definition]:
    by_name = {definition.name: definition for definition in definitions}
    uses = {
        definition.name: [field.type.base for field in definition.fields if field.type.base in by_name]
        for definition in definitions
    }
    return [by_name[name] for name in TopologicalSorter(uses).static_order()]
