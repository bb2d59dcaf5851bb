"""What a managing system needs is found without running any of it."""

import os
from pathlib import Path

import pytest

from sunset.errors import ManagerError
from sunset.managing.files import manager_code, manager_data


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
    assert manager_data("mine.py:Mine", tmp_path) == manager_data(spec)
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
