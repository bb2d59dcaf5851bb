"""What holds for every module: what the package exports, and that the examples in its docstrings are true."""

import doctest
import importlib
from pathlib import Path

import pytest

import sunset_town

SOURCE = Path(sunset_town.__file__).parent
WITH_EXAMPLES = sorted(path.stem for path in SOURCE.glob("*.py") if ">>> " in path.read_text("utf-8"))


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_the_examples_in_docstrings_are_true(name: str) -> None:
    results = doctest.testmod(importlib.import_module(f"sunset_town.{name}"))
    assert results.attempted > 0
    assert results.failed == 0
