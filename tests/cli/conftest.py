"""What tests of the command line share."""

import re
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from sunset.cli import main

PROGRESS = re.compile(r"[A-Z]\w*( \w+)*: (\d+ of \d+, )?\d+ s(, \d+:\d\d:\d\d left)?")
"""A line of it, which what takes longer than half a second writes."""
_ASIDE = re.compile(rf"{PROGRESS.pattern}|Managing systems run without .*")
"""Progress, or which walls this system lacks."""


Complaint = Callable[[Sequence[str]], str]


@pytest.fixture
def complaint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Callable[[Sequence[str]], str]:
    """Call the command line in an empty folder; return its one sentence."""

    def call(arguments: Sequence[str]) -> str:
        monkeypatch.chdir(tmp_path)
        code: object
        try:
            code = main(arguments)
        except SystemExit as way_out:  # argparse's
            code = way_out.code
        out, err = capfd.readouterr()
        assert code == 2, (code, out, err)
        assert out == ""
        told = [line for line in err.strip().splitlines() if not _ASIDE.fullmatch(line)]
        (sentence,) = told
        assert sentence.startswith("sunset")
        assert sentence.endswith(".")
        return sentence

    return call
