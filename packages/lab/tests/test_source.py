"""Every module of the lab exports the names that it lists, and the examples in its docstrings are true."""

import doctest
import importlib
from pathlib import Path
from types import ModuleType

import pytest

import sunset_lab

SOURCE = Path(sunset_lab.__file__).parent
EXTRAS = {"matplotlib", "onnx", "torch"}


def names(paths: list[Path]) -> list[str]:
    relative = [path.relative_to(SOURCE.parent).with_suffix("") for path in paths]
    return sorted(".".join(path.parts).removesuffix(".__init__") for path in relative)


MODULES = sorted(SOURCE.rglob("*.py"))
WITH_EXAMPLES = [path for path in MODULES if ">>> " in path.read_text("utf-8")]


def imported(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name not in EXTRAS:
            raise
        pytest.skip(f"needs the extra that installs {error.name}")


@pytest.mark.parametrize("name", names(MODULES))
def test_a_module_can_be_imported_and_has_the_names_that_it_lists(name: str) -> None:
    module = imported(name)
    assert [exported for exported in getattr(module, "__all__", []) if not hasattr(module, exported)] == []


@pytest.mark.parametrize("name", names(WITH_EXAMPLES))
def test_the_examples_in_docstrings_are_true(name: str) -> None:
    results = doctest.testmod(imported(name))
    assert results.attempted > 0
    assert results.failed == 0
