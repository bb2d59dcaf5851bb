"""Whose failure a run of a campaign is."""

import sys
from pathlib import Path

import pytest

from sunset.errors import ManagerError, OutputError, SunsetError
from sunset.experiments import RunSpec, Settings, Timing
from sunset.experiments.run import run_of_campaign
from sunset.recording import read_run
from sunset.scenarios import load_scenario

pytestmark = pytest.mark.usefixtures("flight")

MINE = "from sunset.managing import ManagingSystem\n\n\nclass Mine(ManagingSystem):\n    adapt = print\n"


def failing(monkeypatch: pytest.MonkeyPatch, error: SunsetError) -> None:
    def run(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(sys.modules["sunset.experiments.run"], "run_prepared", run)


@pytest.fixture
def spec(tmp_path: Path) -> RunSpec:
    (tmp_path / "mine.py").write_text(MINE, encoding="utf-8")
    settings = Settings(timing=Timing(duration_s=1.0, warm_up_s=0.5))
    return RunSpec(
        scenario=load_scenario("nofault"), manager=f"{tmp_path / 'mine.py'}:Mine", settings=settings
    )


@pytest.mark.parametrize(
    "error", [OutputError("No space is left."), SunsetError("The process of the run was killed.")]
)
def test_what_the_computer_lacks_is_not_recorded_as_a_failure_of_the_managing_system(
    spec: RunSpec, error: SunsetError, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing(monkeypatch, error)

    with pytest.raises(type(error), match=str(error)):
        run_of_campaign(spec, tmp_path / "run", None)

    assert not (tmp_path / "run").exists()


def test_a_managing_system_that_keeps_the_system_from_coming_up_has_failed(
    spec: RunSpec, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing(monkeypatch, ManagerError("It sent 7 requests meanwhile."))

    run_of_campaign(spec, tmp_path / "run", None)

    assert read_run(tmp_path / "run").manager_failed == "It sent 7 requests meanwhile."
