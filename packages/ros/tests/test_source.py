"""What holds for every module: what it exports, and that the examples in its docstrings are true."""

import ast
import doctest
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import sunset_ros

SOURCE = Path(sunset_ros.__file__).parent
FILES = [path for path in SOURCE.rglob("*.py") if path.parent.name not in {"msg", "srv"}]


def _name(path: Path) -> str:
    parts = (SOURCE.name, *path.relative_to(SOURCE).with_suffix("").parts)
    return ".".join(parts).removesuffix(".__init__")


@pytest.mark.parametrize("path", FILES, ids=_name)
def test_a_package_exports_what_it_says_and_a_module_what_has_no_underscore(path: Path) -> None:
    module = importlib.import_module(_name(path))
    assert [exported for exported in getattr(module, "__all__", ()) if not hasattr(module, exported)] == []
    assert _private_names_of_others(path) == [], "a name with an underscore is its module's own"


def _private_names_of_others(path: Path) -> list[str]:
    return [
        f"{node.module}.{alias.name}"
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("sunset_ros")
        for alias in node.names
        if alias.name.startswith("_")
        and not (SOURCE.parent / node.module.replace(".", "/") / f"{alias.name}.py").exists()
    ]


@pytest.mark.parametrize("path", [path for path in FILES if ">>> " in path.read_text("utf-8")], ids=_name)
def test_the_examples_in_docstrings_are_true(path: Path) -> None:
    results = doctest.testmod(importlib.import_module(_name(path)))
    assert results.attempted > 0
    assert results.failed == 0


def test_the_library_imports_no_package_of_sunset_and_no_dds() -> None:
    modules = "{name.partition('.')[0] for name in sys.modules}"
    command = f"import sys, sunset_ros.testing, sunset_ros.commands; print(*{modules})"
    done = subprocess.run([sys.executable, "-c", command], check=True, capture_output=True, text=True)
    assert {"sunset", "cyclonedds"} & set(done.stdout.split()) == set()
