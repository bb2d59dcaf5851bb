"""What leads those on who do not know the command line by heart."""

import re

import pytest
from tests.cli.conftest import Complaint

from sunset.cli import main

ACTIONS = {
    "faults": {"list", "show", "figure"},
    "scenarios": {"list", "show", "generate", "check"},
    "managers": {"list", "check"},
    "models": {"list", "show", "import", "calibrate", "curves", "flights", "iou"},
    "data": {"render", "import", "info"},
}


@pytest.mark.parametrize("noun", ACTIONS)
def test_a_noun_without_an_action_lists_its_actions(noun: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([noun]) == 0

    out = capsys.readouterr().out
    assert ACTIONS[noun] == set(re.findall(r"^    ([a-z]+)", out, re.MULTILINE))


def test_the_help_of_all_verbs_names_the_actions_as_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0

    out = capsys.readouterr().out
    for noun, actions in ACTIONS.items():
        (line,) = re.findall(rf"^    {noun}\s+(.*(?:\n {{14}}.*)*)", out, re.MULTILINE)
        assert set(re.split(r"\W+", line)) >= actions


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("rnu", "run"),
        ("faults fgure", "figure"),
        ("run --middleware simm", "sim"),
        ("run gpu_failur", "gpu_failure"),
        ("run --manager basline", "baseline"),
        ("run --model lit", "lite"),
        ("faults show gpu_failur", "gpu_failure"),
        ("managers check basline", "baseline"),
        ("models show refrence", "reference"),
        ("bench --out x --suite papr", "paper"),
    ],
)
def test_what_was_mistyped_gets_a_suggestion(words: str, meant: str, complaint: Complaint) -> None:
    assert f"did you mean '{meant}', or " in complaint(words.split())


def test_the_help_of_an_action_has_the_extensions(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["managers", "check", "--help"])
    assert "--extension FILE.py|NAME" in capsys.readouterr().out


def test_what_is_like_nothing_gets_no_suggestion(complaint: Complaint) -> None:
    assert "did you mean" not in complaint(["faults", "show", "xyzzy"])


def test_the_faults_are_listed_with_strength_failure_and_cures(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["faults", "list"]) == 0

    header, *rows = (re.split(r"\s{2,}", line) for line in capsys.readouterr().out.splitlines())
    assert header == ["FAULT", "NODE", "KIND", "STRENGTH", "FAILURE", "CURED BY"]
    (shift,) = [dict(zip(header, row, strict=True)) for row in rows if row[0] == "image_shift"]
    assert shift["STRENGTH"].startswith("10, at most ")
    assert shift["FAILURE"].startswith("F4: ")
    assert shift["CURED BY"].endswith("redeploy sensor_fusion")


def test_the_models_are_listed_with_size_iou_and_speed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["models", "list"]) == 0

    header, *rows = (re.split(r"\s{2,}", line) for line in capsys.readouterr().out.splitlines())
    assert header == ["MODEL", "IMAGES", "WEIGHTS", "FILES", "IOU OVER TOWN 8", "A FRAME TAKES"]
    (lite,) = [row for row in rows if row[0] == "lite"]
    assert lite[1:3] == ["256x144", "3.2 million"]
    assert re.fullmatch(r"\d\.\d MB", lite[3])
    assert 0.3 < float(lite[4]) < 0.7
    assert re.fullmatch(r"\d+ ms", lite[5])
