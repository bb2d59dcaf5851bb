"""Logs that are written of runs, read by an independent version of the paper's evaluation script."""

import csv
import json
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.evaluation.paper_script import Figures, evaluate_with_csv, evaluate_with_pandas

import sunset
from sunset.cli import main
from sunset.errors import OutputError, RecordError
from sunset.evaluation import LOG_COLUMNS, render_logs, render_report, write_logs

Store = Callable[..., Path]

NAMES = {
    "f/a": "f_resolved_per_adaptation",
    "t_react": "t_react_s",
    "#redeploy_u": "redeploys_unnecessary",
    "t_down": "t_down_s",
    "IoU": "iou",
}


@pytest.fixture
def logs(store: Store, tmp_path: Path) -> Path:
    """Return the logs of seven runs of the baseline, one of which adapts too early, and of one of another system."""
    for seed, (command_s, iou) in enumerate(
        [(3.5, 0.25), (4.0, 0.5), (5.5, 0.75), (3.0, 1.0), (3.3, 0.0)], 1
    ):
        store(f"runs/baseline-{seed}", seed=seed, command_s=command_s, iou=iou)
    store("runs/other", scenario='paper/it\'s, "quoted"', command_s=4.4)
    store("runs/early", seed=7, command_s=0.5)
    store("runs/mine", manager="mine.py:Mine", command_s=4.2)
    store("runs/none", manager="none", command_s=99.0)
    store("runs/invalid", seed=8, valid=False, reason="it read the truth")
    written = write_logs(tmp_path / "runs", tmp_path / "logs")
    assert len(written.files) == len(list((tmp_path / "logs").rglob("*.csv"))) == 8
    assert all(file.is_file() for file in written.files)
    assert str(written).startswith(f"{tmp_path}/logs has 8 logs. There is none of none: ")
    return tmp_path / "logs"


def block(folder: Path) -> dict[str, dict[str, dict[str, float] | int]]:
    rows = json.loads(render_report(folder, "json"))["rows"]
    return {row["system"]: row["by_paper_script"] for row in rows}


def check_agreement(logs: Path, evaluate: Callable[[list[Path]], Figures]) -> None:
    ours = block(logs.parent / "runs")
    folders = {"baseline": "baseline", "Mine": next(logs.glob("mine*")).name}
    for system, found in ((name, one) for name, one in ours.items() if not name.startswith("none")):
        place = logs / folders["Mine" if "mine" in system else system]
        theirs = evaluate(sorted(place.glob("*.csv")))
        for name, pair in theirs.items():
            figure = found[NAMES[name]]
            assert pair is not None
            assert isinstance(figure, dict)
            assert (figure["mean"], figure["std"]) == pytest.approx(pair, abs=1e-9)


def test_the_five_figures_of_written_logs_are_those_of_the_block(logs: Path) -> None:
    assert evaluate_with_csv(sorted((logs / "baseline").iterdir()))["f/a"] == (1.0, 0.0)
    check_agreement(logs, evaluate_with_csv)


@pytest.mark.thorough
def test_pandas_reads_the_same_from_written_logs(logs: Path) -> None:
    pd = pytest.importorskip("pandas")
    check_agreement(logs, lambda files: evaluate_with_pandas(files, pd))


def test_written_logs_that_are_read_again_give_the_same(logs: Path) -> None:
    rows = json.loads(render_logs(sorted(logs.rglob("*.csv")), "json"))["rows"]
    ours = block(logs.parent / "runs")["baseline"]
    (row,) = (row for row in rows if row["system"] == "baseline")
    assert {name: row[name] for name in ours} == ours


def test_a_log_has_the_published_columns_and_rows(logs: Path) -> None:
    with (logs / "baseline" / "camera_driver_issue-seed-1.csv").open(newline="") as text:
        header, *rows = csv.reader(text)
    assert tuple(header) == LOG_COLUMNS
    events = [dict(zip(header, row, strict=True)) for row in rows if row[2] != "/evaluator_log"]
    told = ("timestamp", "source", "rule_name", "strategy_name", "strategy_status", "gt_failure_name")
    assert [tuple(event[name] for name in told) for event in events] == [
        ("5000000000", "scenario_executor", "", "", "0", "camera_driver_issue"),
        ("6500000000", "analyzer", "redeploy_camera", "", "0", ""),
        ("6500000000", "planning", "", "redeploy_camera", "1", ""),
        ("9100000000", "analyzer", "redeploy_camera", "redeploy_camera", "3", ""),
    ]
    assert (events[0]["scenario"], events[0]["is_gt_failure"]) == ("paper/camera_driver_issue", "True")
    frame = dict(zip(header, rows[0], strict=True))
    assert {name: cell for name, cell in frame.items() if cell} == {
        "timestamp": "2000000000",
        "source": "/evaluator_log",
        "strategy_status": "0",
        "iou": "0.25",
    }


def test_runs_of_one_scenario_and_seed_have_a_log_each(store: Store, tmp_path: Path) -> None:
    store("runs/1")
    store("runs/2", command_s=4.0)
    store("runs/3", command_s=4.5)
    written = write_logs(tmp_path / "runs", tmp_path / "logs")
    assert [file.name for file in written.files] == [
        "camera_driver_issue-seed-1-run-2.csv",
        "camera_driver_issue-seed-1-run-3.csv",
        "camera_driver_issue-seed-1.csv",
    ]


def test_runs_of_which_the_script_would_refuse_all_logs_leave_nothing(store: Store, tmp_path: Path) -> None:
    store("runs/none", manager="none", command_s=99.0)
    with pytest.raises(RecordError, match="an adaptation that answers a symptom; run a managing system that"):
        write_logs(tmp_path / "runs", tmp_path / "logs")
    assert not (tmp_path / "logs").exists()
    store("runs/baseline")
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs" / "file").touch()
    with pytest.raises(OutputError, match="logs exists already"):
        write_logs(tmp_path / "runs", tmp_path / "logs")


def test_the_command_line_writes_logs(
    store: Store, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs, out = str(store("runs/1").parent), str(tmp_path / "logs")
    for options in (["--out", out], ["--format", "original-csv"], ["--json", "--out", out]):
        assert main(["report", runs, *options]) == 2
        assert (
            "--format original-csv and --out, the folder that it is written to, need"
            in capsys.readouterr().err
        )
    written = ["--format", "original-csv", "--out", out]
    assert main(["report", runs, *written, "--recompute"]) == 2
    assert "leave out --runs, --site, --figures and --recompute with original-csv" in capsys.readouterr().err
    assert main(["report", runs, *written]) == 0
    printed = capsys.readouterr()
    assert printed.out == ""
    assert f"{out} has 1 log.\n" in printed.err
    assert (
        sunset.report([out, out]) == sunset.report(Path(out)) == render_logs(list(Path(out).rglob("*.csv")))
    )
    assert sunset.write_logs(runs, tmp_path / "more").files[0].parent == tmp_path / "more" / "baseline"
    with pytest.raises(sunset.SunsetError, match="must be a path, got ''"):
        sunset.report([])
