"""What a campaign would be, before it is run."""

import json
import os
from pathlib import Path

import pytest
from tests.evaluation.test_scores import campaign

import sunset
from sunset.api import planning
from sunset.cli import main
from sunset.evaluation.differences import VARIANCES


@pytest.fixture
def untried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the trial runs, which no number but the time comes from."""
    monkeypatch.setattr(planning, "_trial_pace", lambda *_: None)


@pytest.mark.usefixtures("untried")
def test_a_plan_counts_the_runs_and_says_which_difference_they_detect() -> None:
    found = sunset.plan_bench(managers=("baseline", "reactive"), flights=("panel",), repetitions=3)
    assert found.design is not None
    assert (found.design.alike, found.design.flights, found.design.repetitions) == (9, 8, 3)
    assert list(found.runs.values())[:2] == [2 * 54 * 8 * 3] * 2
    assert found.total == sum(found.runs.values())
    assert found.duration_s is None
    assert {one.pair for one in found.prospects} == set(VARIANCES)
    for one in found.prospects:
        assert one.power is not None
        assert one.detectable is not None
        assert (one.power >= 0.8) == (one.detectable <= 0.02)
    assert "detected with this probability" in str(found)


@pytest.mark.usefixtures("untried")
def test_a_plan_counts_over_what_the_runs_are_spread() -> None:
    assert "over 1 different degradation, 1 flight and 2 repetitions." in str(
        sunset.plan_bench("nofault", repetitions=2)
    )


@pytest.mark.usefixtures("untried")
def test_a_plan_of_two_repetitions_detects_no_difference() -> None:
    found = sunset.plan_bench(repetitions=2)
    assert all((one.power, one.detectable, one.repetitions) == (None,) * 3 for one in found.prospects)
    assert "They detect no difference" in str(found)


def test_an_earlier_campaign_gives_variances_and_says_where_they_do_not_reach(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(planning, "load_results", lambda _: campaign(half=0.5, most=0.9))
    here = sunset.plan_bench(like=tmp_path)
    assert len(here.prospects) == 3
    assert all(one.power is not None for one in here.prospects)
    elsewhere = sunset.plan_bench(like=tmp_path, flights=("panel",))
    assert all(one.power is None for one in elsewhere.prospects)
    assert "not known on 8 flights" in str(elsewhere)


def test_an_earlier_campaign_without_variances_still_says_how_long_runs_take(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(
        planning, "load_results", lambda _: [one for one in campaign() if one.manager == "none"]
    )
    for second in (10, 12):
        (tmp_path / str(second)).mkdir()
        (tmp_path / str(second) / "run.json").touch()
        os.utime(tmp_path / str(second) / "run.json", (second, second))
    found = sunset.plan_bench(like=tmp_path)
    assert found.pace_s == 2
    assert {one.pair for one in found.prospects} == set(VARIANCES)
    assert f"since {tmp_path} has no two managing systems with 3 repetitions" in str(found)


@pytest.mark.usefixtures("flight")
def test_without_an_earlier_campaign_two_trial_runs_say_how_long_it_takes(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["bench", "--plan", "--json", "--suite", "degraded", "--duration", "1", "--jobs", "1"]) in {
        0,
        None,
    }
    document = json.loads(capsys.readouterr().out)
    assert document["pace_s"] > 0
    assert document["duration_s"] == pytest.approx(document["pace_s"] * document["total"])

    found = sunset.plan_bench("degraded", duration=1.0)
    assert found.trial
    assert " s a run, as measured in two trial runs." in str(found)


@pytest.mark.usefixtures("untried")
def test_the_command_line_prints_a_plan_as_text_or_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--plan", "--repetitions", "3"]) in {0, None}
    assert "In all: 516 runs" in capsys.readouterr().out
    assert main(["bench", "--plan", "--json"]) in {0, None}
    document = json.loads(capsys.readouterr().out)
    assert document["total"] == 516
    assert document["design"] == {"alike": 9, "flights": 1, "repetitions": 3}
    assert document["chance"] == 0.8
