"""The page about data: its program prints what it says, its commands do what they say, its table is ours."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from tests.data.material import FLIGHT, make_frames, put_frame, put_pictures, record, rows_of

from sunset.classes import CARLA_IDS
from sunset.cli import main

pytestmark = pytest.mark.thorough

PAGE = (Path(__file__).parents[2] / "docs" / "data.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    found = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)
    return [text for name, text in found if name == language]


def test_the_program_of_the_page_prints_what_the_page_says(tmp_path: Path) -> None:
    (source,) = blocks("python")
    (expected,) = [text for text in blocks("text") if text.startswith("230 frames")]

    done = subprocess.run(
        [sys.executable, "-c", source], cwd=tmp_path, capture_output=True, text=True, check=False
    )

    assert (done.stderr, done.stdout) == ("", expected)


def test_the_commands_of_the_page_do_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for number in range(2):
        put_frame(tmp_path / "syndrone" / FLIGHT, number)
    record(tmp_path / "my_recording", rows_of(make_frames()))
    put_pictures(tmp_path / "my_pictures", "000", make_frames(1, (90, 160))[0], colour=".jpg")
    lines = [line for block in blocks("") for line in block.splitlines()]
    for line in lines:
        name, verb, *arguments = shlex.split(line)
        assert name == "sunset"
        if verb == "run":
            continue  # flown in the tests of the command line
        if "--out" in arguments:
            (tmp_path / "flight.mcap").unlink(missing_ok=True)
        # one frame is rendered here for the hundreds of the page
        assert main([verb, *("1" if argument == "230" else argument for argument in arguments)]) == 0
        capsys.readouterr()
    assert sum("data" in line for line in lines) == 6


def test_the_table_of_ids_is_that_of_the_classes() -> None:
    rows = [line for line in PAGE.splitlines() if re.match(r"\| (\d|\|)", line) or line.startswith("| | |")]
    cells = [cell.strip() for row in rows for cell in row.strip("|").split("|")]
    pairs = zip(cells[::2], cells[1::2], strict=True)
    assert {name: int(number) for number, name in pairs if name} == dict(CARLA_IDS)
