"""Finding a managing system, and what is said when there is none."""

import hashlib
import os
import sys
from pathlib import Path
from typing import Any

import pytest

from sunset.errors import ManagerError
from sunset.managing import (
    MANAGERS,
    Baseline,
    Diagnosing,
    Inspecting,
    ManagingSystem,
    NoAdaptation,
    Oracle,
    RandomAdaptation,
    Reactive,
    checksum,
    load_manager,
    split_label,
)
from sunset.managing.sources import source_files

MINE = """\
from sunset.managing import ManagingSystem, Symptoms


class Mine(ManagingSystem):
    def adapt(self, symptoms: Symptoms) -> None:
        pass
"""


def write(folder: Path, text: str) -> str:
    file = folder / "mine.py"
    file.write_text(text, encoding="utf-8")
    return str(file)


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("mine=mine.py:Mine", ("mine", "mine.py:Mine")),
        ("v2.1_a+b-c=baseline", ("v2.1_a+b-c", "baseline")),
        ("9=a=b.py:Mine", ("9", "a=b.py:Mine")),
        ("baseline", ("", "baseline")),
        ("folder/mine.py:Mine", ("", "folder/mine.py:Mine")),
        ("./a=b/mine.py:Mine", ("", "./a=b/mine.py:Mine")),
        ("mine.py:Mi=ne", ("", "mine.py:Mi=ne")),
    ],
)
def test_a_label_stands_before_the_first_equals_sign(text: str, parts: tuple[str, str]) -> None:
    assert split_label(text) == parts


@pytest.mark.parametrize("label", ["", " ", "-x", "a b", "ä", "a,b", "a\n", "x" * 41])
def test_a_label_that_is_none_is_refused(label: str) -> None:
    with pytest.raises(ManagerError, match="must be 1 to 40 of the letters"):
        split_label(f"{label}=mine.py:Mine")


@pytest.mark.parametrize("label", ["none", "baseline", "reactive", "external"])
def test_nobody_goes_by_the_name_of_a_shipped_one(label: str) -> None:
    with pytest.raises(ManagerError, match=f"'{label}' is the name of a managing system that comes with"):
        split_label(f"{label}=mine.py:Mine")


def test_the_registered_ones_are_found_by_name() -> None:
    assert dict(MANAGERS) == {
        "none": NoAdaptation,
        "random": RandomAdaptation,
        "baseline": Baseline,
        "reactive": Reactive,
        "diagnosing": Diagnosing,
        "inspecting": Inspecting,
        "oracle": Oracle,
    }
    assert load_manager("none") is NoAdaptation
    assert load_manager("baseline") is Baseline


def test_each_describes_itself_in_its_first_line() -> None:
    for manager in MANAGERS.values():
        assert (manager.__doc__ or "").splitlines()[0].endswith(".")


def test_a_class_of_a_module_is_found() -> None:
    assert load_manager("sunset.managing.baseline:Baseline") is Baseline


def test_a_class_of_a_file_is_found(tmp_path: Path) -> None:
    manager = load_manager(f"{write(tmp_path, MINE)}:Mine")
    assert issubclass(manager, ManagingSystem)
    assert manager.__name__ == "Mine"


def test_a_module_beside_a_file_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.path", [*sys.path])
    (tmp_path / "a_helper_of_mine.py").write_text("from sunset.managing import NoAdaptation\n")
    (tmp_path / "mine.py").write_text("from a_helper_of_mine import NoAdaptation as Mine\n")
    assert issubclass(load_manager(f"{tmp_path / 'mine.py'}:Mine"), ManagingSystem)


def test_a_managing_systems_sources_are_those_beside_it_that_it_imports(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("policy_of_mine", "unused"):
        (tmp_path / f"{name}.py").write_text("")
    mine = write(tmp_path, f"import math, numpy, policy_of_mine\n{MINE}")
    assert source_files(f"{mine}:Mine") == (tmp_path / "mine.py", tmp_path / "policy_of_mine.py")
    (package := tmp_path / "package_of_mine").mkdir()
    (package / "__init__.py").write_text("")
    (package / "managers.py").write_text(MINE)
    (package / "policy.py").write_text("")  # it may be imported when it is needed
    names = ("__init__", "managers", "policy")
    found = source_files("package_of_mine.managers:Mine")
    assert found == tuple(package / f"{name}.py" for name in names)
    assert [path.name for path in source_files("baseline")] == ["baseline.py"]
    assert [path.name for path in source_files("sunset.managing.baseline:Baseline")] == ["baseline.py"]


def test_a_file_is_read_anew_each_time(tmp_path: Path) -> None:
    first = load_manager(f"{write(tmp_path, MINE)}:Mine")
    second = load_manager(f"{write(tmp_path, MINE.replace('pass', 'return'))}:Mine")
    assert first is not second
    assert first.__module__ == second.__module__


def test_what_runs_is_what_stands_in_the_files_even_if_bytecode_seems_as_new(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.path", [*sys.path])
    monkeypatch.setattr("sys.dont_write_bytecode", False)
    mine = f"{tmp_path / 'mine.py'}:Mine"
    (tmp_path / "policy_of_mine").mkdir()
    names = ("mine.py", "policy_of_mine/__init__.py", "policy_of_mine/gains.py")
    for gain in (2, 3):
        write(tmp_path, f"from policy_of_mine import NEAR, FAR\n{MINE}    gains = NEAR, FAR, {gain}\n")
        (tmp_path / names[1]).write_text(f"from policy_of_mine.gains import FAR\nNEAR = {gain}\n")
        (tmp_path / names[2]).write_text(f"FAR = {gain}\n")
        for name in names:
            os.utime(tmp_path / name, (1, 1))
        for module in ("policy_of_mine", "policy_of_mine.gains"):  # as in a new process
            sys.modules.pop(module, None)
        manager: Any = load_manager(mine)
        assert manager.gains == (gain, gain, gain)
    assert not [*tmp_path.rglob("__pycache__")]


def test_what_is_below_the_folder_but_not_a_module_of_it_keeps_its_bytecode(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (installed := tmp_path / ".venv" / "packages").mkdir(parents=True)
    (installed / "installed_beside_mine.py").write_text("")
    monkeypatch.setattr("sys.path", [*sys.path, str(installed)])
    monkeypatch.setattr("sys.dont_write_bytecode", False)
    load_manager(f"{write(tmp_path, f'import installed_beside_mine{chr(10)}{MINE}')}:Mine")
    assert [path.parent for path in tmp_path.rglob("__pycache__")] == [installed]


def test_the_checksum_of_a_file_and_its_neighbours_is_that_of_their_checksums(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.path", [*sys.path])
    (tmp_path / "beside_mine.py").write_text("GAIN = 2\n")
    mine = f"{write(tmp_path, f'import beside_mine{chr(10)}{MINE}')}:Mine"
    files = [tmp_path / "beside_mine.py", tmp_path / "mine.py"]
    digests = b"".join(hashlib.sha256(file.read_bytes()).digest() for file in files)
    assert checksum(mine) == hashlib.sha256(digests).hexdigest()


def test_a_name_that_no_record_can_hold_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "d\udcff"
    folder.mkdir()
    with pytest.raises(ManagerError, match="contains an unprintable character"):
        load_manager(f"{write(folder, MINE)}:Mine")


@pytest.mark.parametrize("spec", ["basline", "", ":", "Mine:", ":Mine"])
def test_an_unknown_name_is_answered_with_the_known_ones(spec: str) -> None:
    with pytest.raises(
        ManagerError,
        match="name none, random, baseline, reactive, diagnosing, inspecting, oracle, or your own as module:Class",
    ):
        load_manager(spec)


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        ("no_such_module:Mine", "There is no module 'no_such_module'"),
        (
            "sunset.no_such_module:Mine",
            "There is no module 'sunset.no_such_module'; .* such as sunset/no_such_module.py:Class",
        ),
        ("mine.py", "is a file: name its class too, as mine.py:Class"),
        (
            "sunset.managing:Mine",
            "There is no class Mine in sunset.managing: name one of Baseline, NoAdaptation, RandomAdaptation",
        ),
        (
            "sunset.managing:Basline",
            "no class Basline in sunset.managing: did you mean 'Baseline', or name one of",
        ),
        ("sunset.managing:load_manager", "is not a managing system: it must be a subclass"),
        ("pathlib:Path", "is not a managing system: it must be a subclass"),
        ("sunset.managing:ManagingSystem", "has no method adapt"),
        ("no/such/file.py:Mine", "There is no file no/such/file.py"),
        (".relative:Mine", "is not a module name"),
        ("a b:Mine", "is not a module name"),
    ],
)
def test_what_cannot_be_found_is_named(spec: str, said: str) -> None:
    with pytest.raises(ManagerError, match=said):
        load_manager(spec)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("int('ten')", "raised ValueError: invalid literal"),
        ("len(10)", "raised TypeError: object of type 'int' has no len"),
        ("raise SystemExit(3)", "raised SystemExit: 3"),
        (
            "import no_such_module",
            r"raised ModuleNotFoundError: .* \(module_that_raises\.py, line 1, in <module>\)\.$",
        ),
    ],
)
def test_what_a_module_raises_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, said: str
) -> None:
    name = "module_that_raises"
    (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ManagerError, match=f"Importing {name} {said}"):
        load_manager(f"{name}:Mine")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("def broken(:\n", "mine.py, line 1: this is not valid Python"),
        (
            "\nimport no_such_module\n",
            r"raised ModuleNotFoundError: No module named 'no_such_module' \(mine\.py, line 2, in <module>\)\.$",
        ),
        (
            "import json\ndef read():\n    json.loads('{')\nread()\n",
            r"\(char 1\) \(mine\.py, line 3, in read\)\.$",
        ),
        (
            "compile('x = (', 'other.py', 'exec')\n",
            r"never closed \(other\.py, line 1\) \(mine\.py, line 1, in <mod",
        ),
        ("raise RuntimeError\n", r"raised RuntimeError \(mine\.py, line 1, in <module>\)\.$"),
        ("raise SystemExit(3)\n", "raised SystemExit: 3"),
        ("1 / 0\n", "raised ZeroDivisionError: division by zero"),
        ("\x00", "not valid Python|raised"),
        (MINE.replace("(ManagingSystem)", ""), "must be a subclass of ManagingSystem"),
        (MINE.replace("class Mine", "class Other"), r"There is no class Mine in .*mine\.py: name Other\.$"),
        (MINE.replace("adapt", "adopt"), "has no method adapt"),
        (MINE.replace("pass", "yield self.redeploy('camera')"), "adapt of .* contains yield"),
        (MINE.replace(", symptoms: Symptoms", ""), "must accept one argument, symptoms"),
        (
            MINE.replace("    def", "    def __init__(self) -> None:\n        super().__init__()\n\n    def"),
            "override on_start instead",
        ),
    ],
)
def test_a_bad_file_is_answered_with_what_is_wrong(tmp_path: Path, text: str, said: str) -> None:
    spec = f"{write(tmp_path, text)}:Mine"
    with pytest.raises(ManagerError, match=said) as caught:
        load_manager(spec)
    assert "\n" not in str(caught.value)
