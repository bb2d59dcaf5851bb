"""Variables of the user's environment that a managing system gets, such as the key of a service."""

import re
from pathlib import Path

import pytest

import sunset
from sunset.cli import main
from sunset.errors import InvalidInputError

pytestmark = pytest.mark.usefixtures("flight")

NAME, VALUE = "SUNSET_TEST_KEY", "sk-4f1d8e"

KEYED = """
import os
from sunset.managing import ManagingSystem

KEY = os.environ["SUNSET_TEST_KEY"]  # a client of a service often looks for its key when it is imported

class Keyed(ManagingSystem):
    def adapt(self, symptoms):
        if "SUNSET_OTHER" in os.environ:
            raise LookupError("a variable that was not named")
        raise PermissionError(f"the key {KEY} of {len(KEY)} characters was refused")
"""

PROGRAM = """
import os, sys
for number, line in enumerate(sys.stdin):
    if number:
        print("I have", os.environ["SUNSET_TEST_KEY"], flush=True)
"""


@pytest.fixture
def keyed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv(NAME, VALUE)
    monkeypatch.setenv("SUNSET_OTHER", "1")
    (tmp_path / "keyed.py").write_text(KEYED, encoding="utf-8")
    return f"{tmp_path / 'keyed.py'}:Keyed"


def _holds_value(folder: Path) -> list[Path]:
    return [file for file in folder.rglob("*") if file.is_file() and VALUE.encode() in file.read_bytes()]


def test_a_campaign_passes_a_variable_and_keeps_its_value_nowhere(
    keyed: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    out, site = tmp_path / "out", tmp_path / "site"
    choice = "--suite paper --scenarios paper/gpu_failure+image_shift+autofocus_needed --repetitions 1 --duration 1"
    bare = "--no-references --no-score"

    words = ["bench", *choice.split(), *bare.split(), "--managers", f"keyed={keyed}", "--manager-env", NAME]
    assert main([*words, "--out", str(out)]) == 1  # it failed in each of its runs
    assert main(["report", str(out), "--site", str(site)]) == 0

    (record,) = out.rglob("run.json")
    assert f"the key ${NAME} of 9 characters was refused" in record.read_text(encoding="utf-8")
    assert [*site.rglob("*.html")]
    assert _holds_value(out) == _holds_value(site) == []
    printed = capfd.readouterr()
    assert VALUE not in printed.out + printed.err


def test_a_program_has_the_variable_and_messages_have_its_name(
    keyed: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    del keyed
    (tmp_path / "mine.py").write_text(PROGRAM, encoding="utf-8")
    run = sunset.run(
        "nofault",
        manager=f"exec:python3 -S {tmp_path / 'mine.py'}",
        duration=1.0,
        manager_env=(NAME,),
        out=tmp_path / "run",
    )

    assert f"'I have ${NAME}'" in (run.record.manager_failed or "")
    assert _holds_value(tmp_path / "run") == []
    assert VALUE not in capfd.readouterr().err


def test_a_variable_that_is_not_set_is_named(keyed: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(
        InvalidInputError, match=f"The environment variable '{NAME}_2' for the managing system is not"
    ):
        sunset.check_manager(keyed, manager_env=f"{NAME}_2")

    assert main(["run", "nofault", "--manager", keyed, "--manager-env", f"{NAME}_2"]) == 2
    assert re.search(f"'{NAME}_2' .* is not set: export it", capsys.readouterr().err)
