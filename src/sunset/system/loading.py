"""Importing extensions of the managed system, from files and from installed packages."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Final

from sunset.errors import ExtensionError
from sunset.files.inputs import file_digest
from sunset.files.sources import compiled_checksum, import_file, import_place
from sunset.system.extension import Extension
from sunset.texts.sentences import described_error
from sunset_ros.texts import suggestion

_GROUP: Final = "sunset.extensions"
"""The group of entry points of installed extensions."""
_ATTRIBUTE: Final = "EXTENSION"
"""The variable of a file that holds its extension."""


@dataclass(frozen=True, slots=True)
class LoadedExtension:
    """An extension that is part of the managed system.

    Attributes:
        name: the file's name, or the entry point's.
        where: the file's absolute path, or the name of the entry point.
        checksum: the SHA-256 of the file with its source, in hexadecimal.
        source: the path of that file.
    """

    name: str
    where: str
    checksum: str
    source: str


def import_extension(place: str, *, is_file: bool) -> tuple[LoadedExtension, Extension]:
    """Import an extension from a Python file, or from the entry point of a name."""
    module, extension = _from_file(Path(place)) if is_file else _from_entry_point(place)
    if not isinstance(extension, Extension):
        raise ExtensionError(
            f"The extension {place} must have an Extension as {_ATTRIBUTE}, got {type(extension).__name__}."
        )
    source = Path(str(module.__file__))
    checksum = compiled_checksum(source) or file_digest(source)
    return LoadedExtension(Path(place).name, place, checksum, str(source)), extension


def _from_file(path: Path) -> tuple[ModuleType, object]:
    if not path.is_file():
        raise ExtensionError(f"There is no extension {path}: name a Python file.")
    if path.suffix != ".py":
        raise ExtensionError(f"The extension {path} is not a Python file.")
    with _translated(path):
        module = import_file(path, f"sunset_extension_{path.stem}")
    names = vars(module)
    if _ATTRIBUTE not in names:
        others = [name for name, value in names.items() if isinstance(value, Extension)]
        remedy = f"rename {others[0]}" if others else "assign it an Extension"
        raise ExtensionError(f"The extension {path} has no {_ATTRIBUTE}: {remedy}.")
    return module, names[_ATTRIBUTE]


def _from_entry_point(name: str) -> tuple[ModuleType, object]:
    from importlib.metadata import entry_points  # noqa: PLC0415  slow, and rarely needed

    installed = {point.name: point for point in entry_points(group=_GROUP)}
    if name not in installed:
        raise ExtensionError(
            f"There is no extension {name!r}: {suggestion(name, installed)}name a Python file, or an installed "
            f"extension ({', '.join(installed) or 'there is none'})."
        )
    with _translated(name):
        extension = installed[name].load()
    return sys.modules[installed[name].module], extension


@contextmanager
def _translated(where: object) -> Iterator[None]:
    """Turn an exception of an extension's import into an `ExtensionError`, and print its output to stderr."""
    with redirect_stdout(sys.stderr):
        try:
            yield
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise ExtensionError(
                f"The extension {where} cannot be imported: it raised {described_error(error)}{import_place(error)}."
            ) from error
