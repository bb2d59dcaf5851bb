"""What a managing system needs is found without running any of it."""

import os
from pathlib import Path
from textwrap import dedent

import pytest

from sunset.errors import ManagerError
from sunset.experiments import Settings, manager_checksum
from sunset.managing import checksum
from sunset.managing.sources import manager_code, manager_data, source_files


def written(folder: Path, files: str) -> str:
    (folder / "mine.py").write_text(
        f"raise SystemExit('it ran')\n\nclass Mine:\n    {files}\n\nclass Other:\n    files = ('other',)\n",
        "utf-8",
    )
    return f"{folder / 'mine.py'}:Mine"


@pytest.mark.parametrize("files", ["files = ('a', 'b/c')", "files: ClassVar[list[str]] = ['a', 'b/c']"])
def test_a_class_names_the_files_that_it_reads(tmp_path: Path, files: str) -> None:
    spec = written(tmp_path, files)
    (tmp_path / "b").mkdir()
    for name in ("a", "b/c"):
        (tmp_path / name).touch()
    assert manager_data(spec) == (tmp_path / "a", tmp_path / "b/c")
    assert manager_data(spec.replace("Mine", "Absent")) == ()


@pytest.mark.parametrize(
    ("files", "message"),
    [
        (
            "files = NAMES",
            r"mine\.py, line 4: files of Mine must be a tuple of names, written out, .* got NAMES\.",
        ),
        ("files = 'a'", r"files of Mine must be a tuple of names, .* got 'a'\."),
        ("files = (1,)", r"files of Mine must be a tuple of names, .* got \(1,\)\."),
        ("files = ('absent',)", r"names a file absent in files, and .*absent is not a file\."),
    ],
)
def test_anything_else_is_one_sentence(tmp_path: Path, files: str, message: str) -> None:
    with pytest.raises(ManagerError, match=message):
        manager_data(written(tmp_path, files))


def test_the_code_of_one_is_what_is_beside_it(tmp_path: Path) -> None:
    real = tmp_path / "real"
    (real / "package").mkdir(parents=True)
    (real / "results").mkdir()
    spec = written(real, "pass")
    for name in ("beside.py", "package/__init__.py", "package/inner.py", "notes.txt", "results/stray.py"):
        (real / name).touch()
    found = [real / name for name in ("mine.py", "beside.py", "package/__init__.py", "package/inner.py")]
    folders, files = manager_code(spec)
    assert folders[0] == real
    assert [file for file in files if file.is_relative_to(tmp_path)] == found
    (tmp_path / "link").symlink_to(real)
    _, files = manager_code(f"{tmp_path}/link/mine.py:Mine")
    assert {tmp_path / "link/mine.py", *found} <= set(files)


@pytest.mark.parametrize(
    "spec", ["baseline", "exec:python3 x.py", "sunset.managing:Baseline", "json:dumps", "absent"]
)
def test_what_is_installed_names_none(spec: str) -> None:
    folders, _ = manager_code(spec)
    assert Path(os.__file__).parent not in folders
    assert manager_data(spec) == ()


FILES = {
    "mine.py": """
        from __future__ import annotations
        from typing import TYPE_CHECKING
        import helper, package.inner
        from sunset.managing import ManagingSystem
        if TYPE_CHECKING:
            import absent

        class Mine(ManagingSystem):
            files = ("weights.txt",)

            def adapt(self, symptoms):
                import late
        """,
    "helper.py": "import more",
    "more.py": "",
    "absent.py": "",
    "late.py": "",
    "weights.txt": "1",
    "package/__init__.py": "",
    "package/inner.py": "from . import beside\nfrom .deeper import value",
    "package/beside.py": "",
    "package/deeper.py": "from package import value",
    "package/value.py": "",
    "package/unused.py": "",
}


def test_the_files_of_a_managing_system_are_known_before_it_is_loaded(tmp_path: Path) -> None:
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(dedent(text))
    spec = f"{tmp_path / 'mine.py'}:Mine"

    names = {str(file.relative_to(tmp_path)) for file in source_files(spec)}

    assert names == FILES.keys() - {"package/unused.py"}
    assert manager_checksum(spec, Settings()) == checksum(spec)


def test_a_file_that_is_gone_is_said() -> None:
    with pytest.raises(ManagerError, match=r"There is no file gone\.py\."):
        source_files("gone.py:Mine")


def test_a_file_that_is_not_python_is_said(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("class Mine(:\n")
    with pytest.raises(ManagerError, match=r"The file .*mine\.py cannot be read as Python: invalid syntax"):
        source_files(f"{tmp_path / 'mine.py'}:Mine")
