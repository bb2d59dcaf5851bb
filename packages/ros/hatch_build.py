"""Generates the message classes from the .msg and .srv files when the package is built or installed for editing."""

import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class MessageClasses(BuildHookInterface):  # type: ignore[type-arg]  # its argument is the builder's configuration
    """Writes the modules beside their definitions."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Generate before anything is collected."""
        del version, build_data
        source = Path(self.root, "src")
        sys.path.insert(0, str(source))
        try:
            from sunset_ros.generator.modules import generate  # noqa: PLC0415  found by the path above
        finally:
            sys.path.remove(str(source))
        folder = source / "sunset_ros" / "interfaces"
        for path, text in generate(folder, "sunset_ros.interfaces").items():
            (folder / path).write_text(text, encoding="utf-8")
