"""The paper's figures by the published script: of stored runs, and of published logs."""

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
OLDER = (
    *("timestamp", "source", "rule_name", "adaptation_type", "adaptation_status", "success"),
    *("iou", "vehicle_iou", "road_iou", "gt_failure_name", "is_gt_failure"),
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


def event(seconds: float, source: str, **cells: str) -> dict[str, str]:
    return {"timestamp": str(round(seconds * 1e9)), "source": source, "strategy_status": "0", **cells}


def frames(first: int, last: int, iou: float) -> Rows:
    """Return a frame every 0.1 s; first and last in tenths of a second."""
    return [event(at / 10, "/evaluator_log", iou=str(iou)) for at in range(first, last + 1)]


RULE = "redeploy_segmentation"
LOG = [
    *frames(1, 30, 0.2),
    event(3.05, "scenario_executor", gt_failure_name="gpu_failure", is_gt_failure="True", scenario="a"),
    event(4.25, "analyzer", rule_name=RULE),
    event(4.25, "planning", strategy_name=RULE, strategy_status="1"),
    event(5.75, "analyzer", rule_name=RULE, strategy_name=RULE, strategy_status="3"),
    *frames(60, 230, 0.8),
]


def written(file: Path, rows: Rows = LOG, columns: tuple[str, ...] = COLUMNS) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    lines = [",".join(columns), *(",".join(row.get(name, "") for name in columns) for row in rows)]
    file.write_text("\n".join(lines) + "\n")
    return file


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
    assert "By SUNSET's definitions" not in text
    content = json.loads(paper_report(tmp_path, "json"))
    assert content["published"]["t_down_s"] == {"mean": 6.52, "std": 4.67}
    assert content["rows"][1]["t_down_s"] == {"mean": 4.1, "std": 0.0}
    assert content["rows"][0]["t_down_s"] is None
    assert r"\label{tab:sunset-paper}" in paper_report(tmp_path, "latex")
    assert ">4.10 ± 0.00</td>" in paper_report(tmp_path, "html")


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
    for place in ("runs", "logs"):
        (row,) = json.loads(paper_report(tmp_path / place, "json"))["rows"]
        assert (row["logs"], row["logs_refused"]) == (5, 1)
        for name, pair in theirs.items():
            assert pair is not None
            assert (row[NAMES[name]]["mean"], row[NAMES[name]]["std"]) == pytest.approx(pair, abs=1e-9)


def test_a_log_is_shown_by_both_definitions(tmp_path: Path) -> None:
    # the script ends ten frames after the last event, at 5.75 s; the 20 s from 3.05 s on end after the last frame
    text = paper_report(written(tmp_path / "theirs" / "a.csv").parent)
    label = str(tmp_path / "theirs")
    by_script, published = lines_of(text, "By the published script")[-2:]
    assert by_script[-5:] == ["1.00 ± 0.00", "1.50 ± 0.00", "0.00 ± 0.00", "3.00 ± 0.00", "0.35 ± 0.26"]
    assert published == PUBLISHED
    (own,) = (cells for cells in lines_of(text, "By SUNSET's definitions") if len(cells) > 1)
    # silent from 3.05 to 6.0 s; 171 of 200 frames
    assert own[-3:] == ["2.95 ± 0.00", "0.80 ± 0.00", "0.68 ± 0.00"]
    assert label in text


def test_a_log_of_the_older_layout_has_figures_by_our_definitions_only(tmp_path: Path) -> None:
    rows = [row for row in LOG if row["source"] not in {"analyzer", "planning"}]
    written(tmp_path / "theirs" / "a.csv", rows, OLDER)
    (row,) = json.loads(paper_report(tmp_path / "theirs", "json"))["rows"]
    assert (row["logs_refused"], row["t_down_s"]) == (1, None)
    assert row["own"]["t_down_s"] == {"mean": pytest.approx(2.95), "std": 0.0}
    text = " ".join(paper_report(tmp_path / "theirs").split())
    assert "published" not in text.replace("the published script refuses", "")


def test_each_folder_of_logs_is_a_row(tmp_path: Path) -> None:
    written(tmp_path / "one" / "a.csv")
    written(tmp_path / "one" / "b.csv", frames(1, 80, 0.5))
    written(tmp_path / "two" / "a.csv")
    rows = json.loads(paper_report(tmp_path, "json"))["rows"]
    assert [(Path(row["system"]).name, row["logs"], row["logs_refused"]) for row in rows] == [
        ("one", 2, 1),
        ("two", 1, 0),
    ]
    # a fault that only a redeploy cures is set off against the redeploys of every log
    assert rows[0]["redeploys_unnecessary"] == {"mean": 0.0, "std": 0.0}


def changed(line: int, **cells: str) -> Callable[[str], str]:
    """Return what changes cells in a line of a log's text."""

    def change(text: str) -> str:
        header, *lines = text.splitlines()
        names = header.split(",")
        row = dict(zip(names, lines[line - 2].split(","), strict=True)) | cells
        lines[line - 2] = ",".join(row[name] for name in names)
        return "\n".join([header, *lines])

    return change


BAD: dict[str, tuple[Callable[[str], str], str]] = {
    "another table": (lambda _: "a,b\n1,2\n", "line 2: .*; leave it out"),
    "two layouts": (lambda text: f"{text}\n1,2,3\n", r"got `null` - at `\$.rule_name`; leave it out"),
    "no number": (changed(3, iou="good"), r"line 3: .*, got `str` - at `\$.iou`; leave it out"),
    "NaN": (changed(3, iou="nan"), r"line 3: .* at `\$.iou`"),
    "no time": (
        changed(3, timestamp="soon"),
        r"line 3: .*, got `str` - at `\$.timestamp`",
    ),
    "endless time": (changed(3, timestamp="1e999"), r"line 3: .* at `\$.timestamp`"),
    "no status": (changed(3, strategy_status="ok"), r"line 3: .*, got `str` - at `\$.strategy_status`"),
    "quotes": (lambda text: f'{text}\n"unfinished', "is not a published log: "),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_log_is_refused_in_one_sentence(case: str, tmp_path: Path) -> None:
    change, words = BAD[case]
    file = written(tmp_path / "a.csv")
    file.write_text(change(file.read_text()))
    with pytest.raises(RecordError, match=words) as caught:
        paper_report(file)
    assert str(file) in str(caught.value)


def test_what_is_neither_text_nor_there_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b"timestamp\xff")
    with pytest.raises(RecordError, match="is not a published log: "):
        paper_report(tmp_path)
    with pytest.raises(RecordError, match=r"missing.csv cannot be read: No such file"):
        paper_report(tmp_path / "missing.csv")
    with pytest.raises(RecordError, match="There is no folder"):
        paper_report(tmp_path / "nowhere")


def test_runs_of_other_suites_have_no_figures_of_the_papers(store: Store, tmp_path: Path) -> None:
    store("run", suite="timed")
    with pytest.raises(RecordError, match="neither a valid run of the suite paper nor a log below"):
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
