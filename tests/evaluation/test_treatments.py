"""What reports say of the faults: cured, masked, missed, and how long a cure took."""

import csv
import io
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from tests.evaluation.test_report import row_of, run

from sunset.errors import RecordError
from sunset.evaluation import FORMATS, RunRow, format_report, load_results, render_report, summarise
from sunset.metrics import FaultOutcome

CURED = FaultOutcome("gpu_failure", "F3", 1.0, 3.0, cured=3.0)
MASKED = FaultOutcome("image_shift", "F4", 0.0, 20.0, masked_s=7.5)
HEALED = FaultOutcome("image_shift", "F4", 4.0, 9.0)


def rows(manager: str = "mine", **figures: float) -> list[RunRow]:
    """Return three runs, in which of nine faults three are cured."""
    runs = [run(manager, "artifact", seed, scenario=f"artifact/{seed}") for seed in (1, 2, 3)]
    figures = {"masked_s": 7.5, "adaptations_mistreated": 2, **figures}
    return [
        replace(one, metrics={**one.metrics, **figures}, outcomes=(CURED, MASKED, HEALED)) for one in runs
    ]


def test_text_tells_what_became_of_the_faults() -> None:
    _, _, told = format_report(summarise(rows())).partition("What became of the faults\n")
    faults, _, rest = told.partition("Time to cure by failure [s]\n")
    times, _, _ = rest.partition("More about")
    label = "mine (artifact)"
    assert row_of(faults, label)[1:] == ["3", "3/9 (33%)", "7.50 ± 0.00", "2.00 ± 0.00"]
    # F3: cured after 2 s. F4: not cured, and of one fault not known any longer after 5 s. All: 1/3 after 2 s.
    assert row_of(times, label)[1:] == ["3", "2.00", "20.00", "14.00"]


def test_json_has_the_curve_and_the_fates() -> None:
    (row,) = json.loads(format_report(summarise(rows()), "json"))["rows"]
    assert row["cured_rate"] == pytest.approx(1 / 3)
    assert list(row["time_to_cure"]) == ["F3", "F4", "all"]
    found = row["time_to_cure"]["all"]
    assert (found["faults"], found["cured"], found["horizon_s"]) == (9, 3, 20.0)
    assert (found["times_s"], found["not_cured"]) == ([2.0], [pytest.approx(2 / 3)])
    assert found["restricted_mean_s"] == pytest.approx(14.0)
    assert row["fates"] == {
        "gpu_failure": {"cured": 3, "masked": 0, "missed": 0},
        "image_shift": {"cured": 0, "masked": 3, "missed": 3},
    }
    assert row["masked_s"]["mean"] == 7.5


def test_csv_has_the_restricted_means() -> None:
    (line,) = csv.DictReader(io.StringIO(format_report(summarise(rows()), "csv")))
    assert (line["t_cure_F3_s"], line["t_cure_F4_s"]) == ("2.0", "20.0")
    assert float(line["t_cure_all_s"]) == pytest.approx(14.0)
    assert (line["masked_s_mean"], line["adaptations_mistreated_mean"]) == ("7.5", "2.0")


def test_reference_rows_judge_nobody() -> None:
    reference = [replace(run("none", "degraded", 1), outcomes=(MASKED,))]
    text = format_report(summarise(reference))
    assert "What became" not in text
    (row,) = json.loads(format_report(summarise(reference), "json"))["rows"]
    assert (row["cured_rate"], row["time_to_cure"], row["faults_cured"]) == (None, {}, None)


@pytest.mark.parametrize(("mistreated", "is_noted"), [(20, False), (21, True)])
def test_who_repairs_without_looking_is_noted(mistreated: int, is_noted: bool) -> None:
    told = " ".join(format_report(summarise(rows(adaptations_mistreated=mistreated))).split())
    assert ("mine (artifact): 21 adaptations of a run treated no fault that was there" in told) == is_noted
    assert ("may come of repairing without looking" in told) == is_noted


@pytest.mark.parametrize("form", FORMATS)
def test_runs_of_a_version_that_did_not_tell_have_no_figures_and_are_noted(
    store: Callable[..., Path], edit: Callable[..., None], tmp_path: Path, form: str
) -> None:
    whole = store("runs/1")
    told = render_report(tmp_path, form)
    metrics = json.loads((whole / "run.json").read_text())["metrics"]
    added = {"masked_s", "adaptations_mistreated"}
    older = {
        name: value for name, value in metrics.items() if name not in added and not name.startswith("faults_")
    }
    edit(whole, metrics=older, fault_outcomes=...)
    (row,) = load_results(tmp_path)
    assert (row.outcomes, row.metrics["faults_cured"], row.metrics["iou"]) == (None, None, metrics["iou"])
    untold = " ".join(render_report(tmp_path, form).split())
    if form not in {"csv", "json"}:
        assert "1 of 1 runs are of a version that did not say what became of the faults" in untold
    assert render_report(tmp_path, form, recompute=True) == told


@pytest.mark.parametrize(
    ("edited", "words"),
    [
        ({"began": 0.5, "cured": 0.1}, "from 0.5 to 20 s, was cured at 0.1 s, in 20 s"),
        ({"began": 3.0, "until": 2.0}, "from 3 to 2 s, in 20 s"),
        ({"cured": 21.0}, "from 2 to 20 s, was cured at 21 s, in 20 s"),
        ({"cured": 3.0}, "faults_cured is 0, and by fault_outcomes it is 1"),
    ],
)
def test_an_outcome_that_cannot_be_is_refused(
    store: Callable[..., Path],
    edit: Callable[..., None],
    edited: dict[str, float],
    words: str,
    tmp_path: Path,
) -> None:
    folder = store("runs/1")
    (outcome,) = json.loads((folder / "run.json").read_text())["fault_outcomes"]
    edit(folder, fault_outcomes=[outcome | edited])
    with pytest.raises(RecordError, match=rf"No run can have what .*run.json says: .*{words}; run it again"):
        load_results(tmp_path)


@pytest.mark.parametrize(
    ("edited", "words"),
    [
        ({"iou_net": 0.99}, "iou_net is 0.99, and by iou_all and adaptations_mistreated it is "),
        ({"faults_cured": 7}, "faults_cured is 7, and faults_injected is 1"),
        ({"episodes_resolved": 90}, "episodes_resolved is 90, and episodes is "),
        ({"t_down_s": 20.5}, "t_down_s is 20.5, and duration_s is 20"),
        ({"masked_s": 20.5}, "masked_s is 20.5, and duration_s is 20"),
    ],
)
def test_figures_that_contradict_each_other_are_refused(
    store: Callable[..., Path],
    edit: Callable[..., None],
    edited: dict[str, float],
    words: str,
    tmp_path: Path,
) -> None:
    folder = store("runs/1")
    edit(folder, metrics=json.loads((folder / "run.json").read_text())["metrics"] | edited)
    with pytest.raises(RecordError, match=words):
        load_results(tmp_path)
    (row,) = load_results(tmp_path, again=True)
    assert set(row.differing) == set(edited)


def test_recomputing_names_outcomes_that_were_edited(
    store: Callable[..., Path], edit: Callable[..., None], tmp_path: Path
) -> None:
    folder = store("runs/1")
    (outcome,) = json.loads((folder / "run.json").read_text())["fault_outcomes"]
    figures = json.loads((folder / "run.json").read_text())["metrics"] | {"faults_cured": 1}
    edit(folder, metrics=figures, fault_outcomes=[outcome | {"cured": 2.5, "until": 2.5}])
    (row,) = load_results(tmp_path)
    assert row.outcomes is not None
    assert row.outcomes[0].cured == 2.5
    (row,) = load_results(tmp_path, again=True)
    assert set(row.differing) == {"faults_cured", "fault_outcomes"}
    assert row.outcomes is not None
    assert row.outcomes[0].cured is None
