"""What reports say of the faults: cured, masked or missed."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from tests.evaluation.test_report import row_of, run

from sunset.evaluation.report import format_report
from sunset.evaluation.results import RunRow, load_results
from sunset.evaluation.summary import summarise
from sunset.metrics import FaultOutcome

CURED = FaultOutcome("gpu_failure", "F3", 1.0, 3.0, cured=3.0, uncured_s=2.0)
MASKED = FaultOutcome("image_shift", "F4", 0.0, 20.0, masked_s=7.5)
HEALED = FaultOutcome("image_shift", "F4", 4.0, 9.0)


def rows(manager: str = "mine", **figures: float) -> list[RunRow]:
    """Return three runs, in which of nine faults three are cured."""
    runs = [run(manager, "artifact", seed, scenario=f"artifact/{seed}") for seed in (1, 2, 3)]
    figures = {"masked_s": 7.5, "uncured_s": 9.0, "needless": 2, "cost_frames": 12, **figures}
    return [
        replace(one, metrics={**one.metrics, **figures}, outcomes=(CURED, MASKED, HEALED)) for one in runs
    ]


def test_text_says_what_became_of_the_faults() -> None:
    _, _, faults = format_report(summarise(rows()), every=True).partition("What became of the faults\n")
    faults, _, _ = faults.partition("More about")
    assert row_of(faults, "mine (artifact)")[1:] == [
        "3",
        "3/9 (33%)",
        "9.00 ± 0.00",
        "7.50 ± 0.00",
        "2.00 ± 0.00",
        "12.00 ± 0.00",
    ]


def test_json_has_the_fates() -> None:
    (row,) = json.loads(format_report(summarise(rows()), "json"))["rows"]
    assert row["cured_rate"] == pytest.approx(1 / 3)
    assert row["fates"] == {
        "gpu_failure": {"cured": 3, "masked": 0, "missed": 0},
        "image_shift": {"cured": 0, "masked": 3, "missed": 3},
    }
    assert row["masked_s"]["mean"] == 7.5


def test_reference_rows_judge_no_managing_system() -> None:
    reference = [replace(run("none", "degraded", 1), outcomes=(MASKED,))]
    assert "What became" not in format_report(summarise(reference), every=True)
    (row,) = json.loads(format_report(summarise(reference), "json"))["rows"]
    assert (row["cured_rate"], row["faults_cured"]) == (None, None)


def test_recomputing_names_outcomes_that_were_edited(
    store: Callable[..., Path], edit: Callable[..., None], tmp_path: Path
) -> None:
    folder = store("runs/1")
    (outcome,) = json.loads((folder / "run.json").read_text())["fault_outcomes"]
    figures = json.loads((folder / "run.json").read_text())["metrics"] | {"faults_cured": 1}
    edit(folder, metrics=figures, fault_outcomes=[outcome | {"cured": 2.5, "until": 2.5}])
    (row,) = load_results(tmp_path)
    assert row.outcomes[0].cured == 2.5
    (row,) = load_results(tmp_path, again=True)
    assert set(row.differing) == {"faults_cured", "fault_outcomes"}
    assert row.outcomes[0].cured is None
