import csv
import json
from collections.abc import Callable
from pathlib import Path

from sunset.evaluation.report import render_runs

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


def test_a_row_says_how_long_was_measured_and_on_what(store: Store, tmp_path: Path) -> None:
    store("run", duration_s=24.0, bag_looped=True, bag_checksum="3c" * 32)
    (row,) = json.loads(render_runs(tmp_path, "json"))["runs"]
    (line,) = csv.DictReader(render_runs(tmp_path, "csv").splitlines())
    names = ("model", "duration_s", "bag_looped", "bag_checksum")
    assert [row[name] for name in names] == ["lite", 24.0, True, "3c" * 32]
    assert [line[name] for name in names] == ["lite", "24.0", "true", "3c" * 32]
