"""A file is written whole, or not at all."""

from pathlib import Path

import pytest

from sunset.errors import OutputError
from sunset.files.outputs import draft_of, draft_of_folder, write_text


def begin(file: Path) -> None:
    with draft_of(file) as draft:
        draft.write_text("half", encoding="utf-8")
        raise ZeroDivisionError


def test_what_goes_wrong_leaves_the_file_as_it_was_and_no_other(tmp_path: Path) -> None:
    file = tmp_path / "table.csv"
    write_text(file, "before")

    with pytest.raises(ZeroDivisionError):
        begin(file)
    assert file.read_text(encoding="utf-8") == "before"
    with pytest.raises(OutputError, match=r"The table .* cannot be written: No such file"):
        write_text(tmp_path / "none" / "table.csv", "after", "table")
    with pytest.raises(OutputError, match=r"cannot be written: Not a directory; name another place\."):
        write_text(file / "table.csv", "after")
    with pytest.raises(OutputError, match="A file to write to must have a name, got /"):
        write_text(Path("/"), "after")

    assert [path.name for path in tmp_path.iterdir()] == ["table.csv"]
    write_text(file, "after")
    assert file.read_text(encoding="utf-8") == "after"


def begin_folder(folder: Path) -> None:
    with draft_of_folder(folder, "site") as draft:
        (draft / "one").write_text("one")
        raise ZeroDivisionError


def test_what_goes_wrong_leaves_no_half_of_a_folder(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        begin_folder(tmp_path / "new")
    assert list(tmp_path.iterdir()) == []

    with draft_of_folder(tmp_path / "new") as draft:
        (draft / "one").write_text("one")
        assert not (tmp_path / "new").exists()
    assert [file.name for file in tmp_path.rglob("*")] == ["new", "one"]

    with pytest.raises(OutputError, match=r"The site .*new exists already; remove it or name another folder"):
        begin_folder(tmp_path / "new")
