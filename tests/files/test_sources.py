"""What is installed, and what is the user's own."""

from pathlib import Path

import pytest

from sunset.files.sources import is_installed


@pytest.mark.parametrize(
    ("folder", "note", "expected"),
    [
        ("lib/site-packages", "rclpy-7.1-py3.12.egg-info", True),
        ("target", "numpy-2.4.dist-info", True),
        ("src", "mine.egg-info", False),
    ],
)
def test_libraries_on_the_path_are_not_taken_for_the_users_own(
    folder: str, note: str, expected: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / folder / note).mkdir(parents=True)
    assert not is_installed(tmp_path / folder / "module.py")
    monkeypatch.syspath_prepend(tmp_path / folder)
    assert is_installed(tmp_path / folder / "module.py") is expected
