"""The paper's figures by the published script, of stored runs."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.evaluation.published.paper_script import evaluate_with_csv

import sunset
from sunset.cli import main
from sunset.errors import InvalidInputError, RecordError
from sunset.evaluation.published import PAPER_FORMATS, log_of_run, paper_report

Store = Callable[..., Path]
Rows = list[dict[str, str]]

COLUMNS = (
    *("timestamp", "scenario", "source", "rule_name", "strategy_name", "strategy_hash", "strategy_status"),
    *("adaptation_type", "adaptation_status", "success", "iou", "vehicle_iou", "road_iou"),
    *("gt_failure_name", "is_gt_failure"),
)
NAMES = {
    "f/a": "f_resolved_per_adaptation",
    "t_react": "t_react_s",
    "#redeploy_u": "redeploys_unnecessary",
    "t_down": "t_down_s",
    "IoU": "iou",
}
PUBLISHED = [
    "baseline, published",
    "0.89 ± 0.16",
    "1.44 ± 1.32",
    "2.02 ± 1.04",
    "6.52 ± 4.67",
    "0.30 ± 0.09",
]


def written(file: Path, rows: Rows) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    lines = [",".join(COLUMNS), *(",".join(row.get(name, "") for name in COLUMNS) for row in rows)]
    file.write_text("\n".join(lines) + "\n")


def lines_of(text: str, title: str) -> list[list[str]]:
    """Return the cells of a block's lines, below its head."""
    lines = text.partition(f"{title}\n\n")[2].partition("\n\n")[0].splitlines()[1:]
    return [re.split(r"\s{2,}", line.strip()) for line in lines if "──" not in line]


def test_runs_stand_above_the_papers_row(store: Store, tmp_path: Path) -> None:
    store("idle", manager="none", command_s=30.0)
    store("other", suite="artifact")
    store("invalid", seed=2, valid=False, reason="it read the truth")
    store("run")  # silent from 1.9 to 6.0, and its camera redeployed at 3.5
    text = paper_report(tmp_path)
    ours, papers = lines_of(text, "By the published script")
    assert ours[0].startswith("baseline")
    assert ours[1:] == ["1", "1.00 ± 0.00", "2.60 ± 0.00", "1.00 ± 0.00", "4.10 ± 0.00", "0.50 ± 0.00"]
    assert papers == PUBLISHED
    assert "none: the published script refuses 1 of 1 logs, but for their redeploys: no rule" in " ".join(
        text.split()
    )
    content = json.loads(paper_report(tmp_path, "json"))
    assert content["published"]["t_down_s"] == {"mean": 6.52, "std": 4.67}
    assert content["rows"][1]["t_down_s"] == {"mean": 4.1, "std": 0.0}
    assert content["rows"][0]["t_down_s"] is None
    assert r"\label{tab:sunset-paper}" in paper_report(tmp_path, "latex")
    assert "<td>4.10 ± 0.00</td>" in paper_report(tmp_path, "html")


def test_another_implementation_gives_the_same_from_the_logs_of_runs(store: Store, tmp_path: Path) -> None:
    commands = [(3.5, 0.25), (4.0, 0.5), (5.5, 0.75), (3.0, 1.0), (0.5, 0.5)]  # the last one is too early
    for seed, (command_s, iou) in enumerate(commands, 1):
        log = log_of_run(store(f"runs/{seed}", seed=seed, command_s=command_s, iou=iou))
        rows: Rows = [
            {
                "timestamp": str(row.time_ns),
                "source": row.source,
                "rule_name": row.rule,
                "strategy_name": row.strategy,
                "strategy_status": str(row.status),
                "iou": str(row.iou),
                "gt_failure_name": row.fault,
            }
            for row in log
        ]
        written(tmp_path / "logs" / f"{seed}.csv", rows)
    theirs = evaluate_with_csv(sorted((tmp_path / "logs").iterdir()))
    assert theirs["f/a"] == (1.0, 0.0)
    (row,) = json.loads(paper_report(tmp_path / "runs", "json"))["rows"]
    assert (row["logs"], row["logs_refused"]) == (5, 1)
    for name, pair in theirs.items():
        assert pair is not None
        assert (row[NAMES[name]]["mean"], row[NAMES[name]]["std"]) == pytest.approx(pair, abs=1e-9)


def test_runs_of_other_suites_have_no_figures_of_the_papers(store: Store, tmp_path: Path) -> None:
    store("run", suite="timed")
    with pytest.raises(RecordError, match="no valid run of the suite paper below"):
        paper_report(tmp_path)


def test_the_command_line_and_python_print_the_same(store: Store, capsys: pytest.CaptureFixture[str]) -> None:
    folder = str(store("runs/1").parent)
    assert main(["report", folder, "--paper"]) == 0
    assert capsys.readouterr().out == sunset.report(folder, paper=True)
    assert main(["report", folder, "--paper", "--json"]) == 0
    assert capsys.readouterr().out == paper_report(Path(folder), "json")
    assert main(["report", folder, "--paper", "--recompute"]) == 2
    assert "Leave out --runs, --site, --figures and --recompute with --paper." in capsys.readouterr().err
    assert main(["report", folder, "--paper", "--format", "csv"]) == 2
    assert f"must be one of {', '.join(PAPER_FORMATS)}, got 'csv'" in capsys.readouterr().err
    with pytest.raises(InvalidInputError, match="one of table, latex, html, json, got 'clay'"):
        sunset.report(folder, "clay", paper=True)
