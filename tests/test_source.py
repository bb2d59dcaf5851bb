"""What holds for every module: what it exports, and that the examples in its docstrings are true."""

import ast
import doctest
import importlib
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import sunset
import sunset_ros
import sunset_town

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
def test_a_package_exports_what_it_says_and_a_module_what_has_no_underscore(name: str) -> None:
    module = _imported(name)
    path = Path(module.__file__ or "")
    listed = getattr(module, "__all__", None)
    if listed is not None:
        assert [exported for exported in listed if not hasattr(module, exported)] == []
    assert _private_names_of_others(path) == [], "a name with an underscore is its module's own"


def _private_names_of_others(path: Path) -> list[str]:
    """Return what a module imports by a name with an underscore, unless it is a module itself."""
    return [
        f"{node.module}.{alias.name}"
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("sunset.")
        for alias in node.names
        if alias.name.startswith("_")
        and not (SOURCE.parent / node.module.replace(".", "/") / f"{alias.name}.py").exists()
    ]


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


def test_the_version_is_of_what_stands_in_the_files(tmp_path: Path) -> None:
    for package in (SOURCE, *(Path(str(other.__file__)).parent for other in (sunset_ros, sunset_town))):
        shutil.copytree(
            package, tmp_path / package.name, ignore=shutil.ignore_patterns("__pycache__", "models")
        )
    command = "from sunset.files.sources import package_version as version; print(version())"

    def version() -> str:
        called = [sys.executable, "-c", command]
        return subprocess.run(called, cwd=tmp_path, check=True, capture_output=True, text=True).stdout.strip()

    first = version()
    assert re.fullmatch(rf"{re.escape(sunset.__version__)}\+[0-9a-f]{{8}}", first)
    (tmp_path / "sunset/notes.txt").write_text("not code")
    (tmp_path / "sunset/system/__pycache__").mkdir(exist_ok=True)
    (tmp_path / "sunset/system/__pycache__/old.py").write_text("not code, either")
    assert version() == first
    versions = {first}
    for file in ("sunset/system/suite_files/calm.yaml", "sunset_ros/node.py", "sunset_town/light.py"):
        with (tmp_path / file).open("a") as opened:
            opened.write("# changed\n")
        versions.add(version())
    assert len(versions) == 4
