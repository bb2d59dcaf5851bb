import csv
import json
from collections.abc import Callable
from pathlib import Path

from sunset.evaluation import render_runs

Store = Callable[..., Path]


def test_a_row_says_which_version_flew_the_run_and_what_was_stored_otherwise(
    store: Store, edit: Callable[..., None], tmp_path: Path
) -> None:
    folder = store("run", versions={"sunset": "0.9.0"})
    stored = json.loads((folder / "run.json").read_text())["metrics"]
    edit(folder, metrics=stored | {"t_down_s": 0.0, "iou": 0.9})
    (row,) = json.loads(render_runs(tmp_path, "json", recompute=True))["runs"]
    (line,) = csv.DictReader(render_runs(tmp_path, "csv", recompute=True).splitlines())
    assert (row["version"], row["differing"]) == ("0.9.0", ["t_down_s", "iou"])
    assert (line["version"], line["differing"]) == ("0.9.0", "t_down_s iou")


def test_csv_has_no_cell_that_a_spreadsheet_computes(store: Store, tmp_path: Path) -> None:
    store("run", manager="=1+1", valid=False, reason="@SUM(A1)")
    (line,) = csv.DictReader(render_runs(tmp_path, "csv").splitlines())
    assert (line["manager"], line["reason"]) == ("'=1+1", "'@SUM(A1)")
