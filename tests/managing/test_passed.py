"""Managing systems that are passed as classes and functions: what their checksum tells apart."""

import importlib
import linecache
import os
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from sunset.errors import ManagerError
from sunset.managing import ManagingSystem, checksum, load_manager, register_manager, sources_digest

MINE = """
from sunset.managing import ManagingSystem

class Other(ManagingSystem):
    def adapt(self, symptoms): ...

class Mine(ManagingSystem):
    gain = 2

    def __init__(self, *, limit=0, **options):
        super().__init__(**options)

    def adapt(self, symptoms):
        pass
"""


class Mine(ManagingSystem):
    func = "not a function"

    def __init__(self, *, limit: object = 0, **options: Any) -> None:
        super().__init__(**options)
        self.limit = limit

    def adapt(self, symptoms: object) -> None:
        pass


def make(**options: Any) -> Mine:
    return Mine(**options)


def summed(manager: Callable[..., ManagingSystem]) -> str:
    return checksum(register_manager(manager))


def defined_in_cell(text: str) -> Any:
    """Return the class Mine of a notebook's cell."""
    cell = "<cell 1>"
    linecache.cache[cell] = (len(text), None, text.splitlines(keepends=True), cell)
    space: dict[str, Any] = {"__name__": "notebook"}
    exec(compile(text, cell, "exec"), space)  # noqa: S102  as a notebook does
    return space["Mine"]


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """A module of the user's that Python itself has imported."""
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "module_of_mine.py").write_text(MINE)
    yield importlib.import_module("module_of_mine")
    del sys.modules["module_of_mine"]


def test_an_attribute_named_func_does_not_make_another_manager() -> None:
    assert load_manager(register_manager(Mine)) is Mine


def test_the_arguments_of_a_partial_are_part_of_the_checksum() -> None:
    plain: list[object] = [0, 9, 9.0, "9", None, (1, 2), [1, 2], {"a": [b"x"]}]
    sums = [summed(partial(Mine, limit=value)) for value in plain]
    assert len({*sums, summed(Mine)}) == len(plain) + 1
    assert sums == [summed(partial(Mine, limit=value)) for value in plain]
    assert summed(partial(Mine)) == summed(Mine)


@pytest.mark.parametrize("value", [object(), {1, 2}, Path("x"), [make]])
def test_an_argument_that_is_not_a_plain_value_leaves_no_checksum(value: object) -> None:
    assert not summed(partial(Mine, limit=value))


def test_the_checksum_of_a_function_and_of_a_class_is_that_of_their_file() -> None:
    assert summed(make) == summed(Mine) == sources_digest([Path(__file__).read_bytes()])


def test_the_file_of_a_base_class_is_part_of_the_checksum(module: ModuleType) -> None:
    class_of_here = type("Derived", (module.Mine,), {"__module__": __name__, "__qualname__": "Derived"})
    texts = [Path(__file__).read_bytes(), Path(str(module.__file__)).read_bytes()]
    assert summed(class_of_here) in {sources_digest(texts), sources_digest(texts[::-1])}


def test_a_closure_a_lambda_an_object_and_a_class_made_in_a_function_have_no_checksum() -> None:
    limit = 3

    def enclosing(**options: Any) -> Mine:
        return Mine(limit=limit, **options)

    class Local(Mine):
        gain = limit

    class Maker:
        def __call__(self, **options: Any) -> Mine:
            return Mine(**options)

    managers: list[Callable[..., ManagingSystem]] = [
        enclosing,
        lambda **options: Mine(limit=limit, **options),
        Local,
        Maker(),
    ]
    assert [summed(manager) for manager in managers] == [""] * 4


@pytest.mark.parametrize("base", ["ManagingSystem", "Other"])
def test_a_class_of_a_cell_and_a_class_with_such_a_base_have_no_checksum(base: str) -> None:
    assert summed(defined_in_cell(MINE.replace("Mine(ManagingSystem)", f"Mine({base})"))) == ""


def test_a_class_whose_source_python_does_not_have_has_no_checksum() -> None:
    space: dict[str, Any] = {"__name__": __name__}
    exec(MINE, space)  # noqa: S102  what this is about
    assert not summed(space["Mine"])


def test_an_edit_between_two_calls_is_refused_until_the_class_is_loaded_anew(module: ModuleType) -> None:
    before = summed(module.Mine)
    for _ in range(1000):  # Python specialises what it runs often
        module.Mine.adapt(None, None)
    assert summed(module.Mine) == before
    file = Path(str(module.__file__))
    file.write_text(MINE.replace("gain = 2", "gain = 3"))
    os.utime(file, (1, 1))  # another time than that of the bytecode, if there is any
    with pytest.raises(ManagerError, match="was edited after it was imported"):
        summed(module.Mine)
    importlib.reload(module)
    assert summed(module.Mine) not in {"", before}
