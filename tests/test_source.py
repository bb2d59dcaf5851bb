"""What holds for every module: it exports what it says, and the examples in its docstrings are true."""

import doctest
import importlib
import re
from pathlib import Path
from types import ModuleType

import pytest

import sunset

SOURCE = Path(sunset.__file__).parent
EXTRAS = {"matplotlib", "onnx", "torch"}


def _name(path: Path) -> str:
    parts = ("sunset", *path.relative_to(SOURCE).with_suffix("").parts)
    return ".".join(parts).removesuffix(".__init__")


def _is_generated(path: Path) -> bool:
    return path.parent.name in {"msg", "srv"}


MODULES = sorted(_name(path) for path in SOURCE.rglob("*.py") if not _is_generated(path))
WITH_EXAMPLES = sorted(_name(path) for path in SOURCE.rglob("*.py") if ">>> " in path.read_text("utf-8"))


def _imported(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name not in EXTRAS:
            raise
        pytest.skip(f"needs the extra that installs {error.name}")


@pytest.mark.parametrize("name", MODULES)
def test_every_module_exports_what_it_says(name: str) -> None:
    module = _imported(name)
    if name.rpartition(".")[2] != "__main__":
        missing = [exported for exported in module.__all__ if not hasattr(module, exported)]
        assert missing == []


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_the_examples_in_docstrings_are_true(name: str) -> None:
    results = doctest.testmod(_imported(name))
    assert results.attempted > 0
    assert results.failed == 0


def test_nothing_below_the_command_line_starts_it() -> None:
    by_name = re.compile(r"""sunset\.cli|["']-m["'],\s*["']sunset["']""")
    below = [
        path
        for path in SOURCE.rglob("*.py")
        if path.relative_to(SOURCE).parts[0] not in {"cli", "__main__.py"}
    ]
    assert [_name(path) for path in below if by_name.search(path.read_text("utf-8"))] == []
