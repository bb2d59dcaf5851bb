"""Logs of the published exemplar: synthetic ones, in the layouts that are described."""

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from sunset.cli import main
from sunset.errors import RecordError
from sunset.evaluation import LOG_COLUMNS, find_logs, render_logs

OLDER = (
    "timestamp",
    "source",
    "rule_name",
    "adaptation_type",
    "adaptation_status",
    "success",
    "iou",
    "vehicle_iou",
    "road_iou",
    "gt_failure_name",
    "is_gt_failure",
)
WITHOUT_SOURCE = tuple(name for name in LOG_COLUMNS if name != "source")

Rows = list[dict[str, str]]


def event(seconds: float, source: str, **cells: str) -> dict[str, str]:
    return {"timestamp": str(round(seconds * 1e9)), "source": source, "strategy_status": "0", **cells}


def frames(first: int, last: int, iou: float) -> Rows:
    """Return a frame every 0.1 s; first and last in tenths of a second."""
    return [event(at / 10, "/evaluator_log", iou=str(iou)) for at in range(first, last + 1)]


def in_order(*rows: dict[str, str]) -> Rows:
    return sorted(rows, key=lambda row: int(row["timestamp"]))


def rules(seconds: float, rule: str, outcome: str = "") -> Rows:
    """Return a rule's trigger, its strategy and, 1.5 s later, its outcome if there is one."""
    rows = [
        event(seconds, "analyzer", rule_name=rule),
        event(seconds, "planning", strategy_name=rule, strategy_status="1"),
    ]
    if outcome:
        more = {"rule_name": rule, "strategy_name": rule, "strategy_status": outcome}
        rows.append(event(seconds + 1.5, "analyzer", **more))
    return rows


NEWER = in_order(
    *frames(1, 30, 0.2),
    event(3.05, "scenario_executor", gt_failure_name="gpu_failure", is_gt_failure="True", scenario="a"),
    *rules(4.25, "redeploy_segmentation", "3"),
    *rules(4.25, "redeploy_sensor_fusion"),
    *frames(60, 90, 0.8),
)
ADAPTED = {"rule_name": "redeploy", "adaptation_type": "4"}
BEHAVIOUR_TREE = in_order(
    *frames(1, 30, 0.2),
    event(3.05, "scenario_executor", gt_failure_name="gpu_failure"),
    event(4.0, "analysis_segmentation", rule_name="frequency"),
    *(
        event(4 + status / 10, "planning_segmentation", **ADAPTED, adaptation_status=str(status))
        for status in (1, 2, 3)
    ),
    event(5.0, "planning_camera", adaptation_type="4.0", adaptation_status="1"),
    event(5.1, "planning_sensor_fusion", adaptation_type="6", adaptation_status="1"),
    event(5.2, "execute_lifecyclecamera", **ADAPTED, adaptation_status="1"),
    *frames(60, 90, 0.8),
)


def written(file: Path, rows: Rows, columns: tuple[str, ...] = LOG_COLUMNS) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    lines = [",".join(columns), *(",".join(row.get(name, "") for name in columns) for row in rows)]
    file.write_text("\n".join(lines) + "\n")
    return file


def rows_of(*files: Path) -> dict[str, dict[str, object]]:
    rows = json.loads(render_logs(files, "json"))["rows"]
    return {row["system"]: row for row in rows}


def pair(mean: float, std: float = 0.0) -> Mapping[str, object]:
    return {"mean": pytest.approx(mean), "std": pytest.approx(std)}


def cells_of(text: str, label: str) -> list[str]:
    (line,) = (line for line in text.splitlines() if line.startswith(f"{label}  "))
    return re.split(r"\s{2,}", line)


# of the last frames, 60 to 70 tenths count: the last event is at 5.75 s
IOU = (30 * 0.2 + 10 * 0.8) / 40


@pytest.mark.parametrize("columns", [LOG_COLUMNS, WITHOUT_SOURCE], ids=["source", "no source"])
def test_a_log_with_rules_gives_the_five_figures(tmp_path: Path, columns: tuple[str, ...]) -> None:
    (row,) = rows_of(written(tmp_path / "theirs" / "a.csv", NEWER, columns)).values()
    assert (row["source"], row["columns"], row["logs_refused"]) == ("published log", len(columns), 0)
    assert row["f_resolved_per_adaptation"] == pair(0.5)
    assert row["t_react_s"] == pair(1.5)
    assert (row["redeploys"], row["redeploys_unnecessary"]) == (pair(2), pair(1))
    assert row["t_down_s"] == pair(3.0)
    assert row["iou"] == pair(IOU, 0.6 * (30 * 10 / 40**2) ** 0.5)
    assert row["self_reported"] == ["f_resolved_per_adaptation", "t_react_s"]


def test_a_log_without_rules_gives_redeploys_downtime_and_iou(tmp_path: Path) -> None:
    file = written(tmp_path / "theirs" / "bt.csv", BEHAVIOUR_TREE, OLDER)
    (row,) = rows_of(file).values()
    assert (row["columns"], row["redeploys"], row["t_down_s"]) == (11, pair(2), pair(3.0))
    assert row["iou"] == pair(IOU, 0.6 * (30 * 10 / 40**2) ** 0.5)
    others = ("f_resolved_per_adaptation", "t_react_s", "redeploys_unnecessary")
    assert [row[name] for name in others] == [None, None, None]
    assert row["self_reported"] == []
    assert cells_of(render_logs([file]), "theirs") == [
        "theirs",
        "1",
        "2.00 ± 0.00",
        "3.00 ± 0.00",
        "0.35 ± 0.26",
    ]


def test_what_is_executed_is_counted_where_nothing_is_planned(tmp_path: Path) -> None:
    rows = [row for row in BEHAVIOUR_TREE if not row["source"].startswith("planning")]
    (row,) = rows_of(written(tmp_path / "a.csv", rows, OLDER)).values()
    assert row["redeploys"] == pair(1)


def test_logs_of_different_folders_and_layouts_have_rows_of_their_own(tmp_path: Path) -> None:
    files = [
        written(tmp_path / "one" / "a.csv", NEWER),
        written(tmp_path / "one" / "b.csv", frames(1, 80, 0.5)),
        written(tmp_path / "two" / "a.csv", NEWER),
        written(tmp_path / "two" / "bt.csv", BEHAVIOUR_TREE, OLDER),
    ]
    rows = rows_of(*files)
    assert {name: row["logs"] for name, row in rows.items()} == {
        "one": 2,
        "two [15 columns]": 1,
        "two [11 columns]": 1,
    }
    assert (rows["one"]["logs_refused"], rows["one"]["redeploys_unnecessary"]) == (1, pair(0.5, 0.5))
    told = " ".join(render_logs(files).split())
    assert "where from self-reported self-reported as planned evaluated evaluated" in told
    assert "not records of SUNSET" in told
    assert (
        "one: the paper's evaluation script refuses 1 of 2 logs, but for their redeploys: no rule was trig"
        in told
    )
    for form, words in (
        ("html", "<td>self-reported</td>"),
        ("latex", "tab:sunset-older-logs"),
        ("csv", "published log"),
    ):
        assert words in render_logs(files, form)


def test_times_are_read_as_other_programs_write_them(tmp_path: Path) -> None:
    rows = [row | {"timestamp": f"{row['timestamp']}.0"} for row in NEWER]
    (row,) = rows_of(written(tmp_path / "a.csv", rows)).values()
    assert row["t_react_s"] == pair(1.5)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"timestamp": "0"}, "a time in it is 0"),
        ({"timestamp": str(17 * 10**17)}, "a time in it is of a wall clock"),
    ],
)
def test_a_log_whose_clock_jumps_is_refused(tmp_path: Path, change: dict[str, str], reason: str) -> None:
    rows = [row | change if place == 5 else row for place, row in enumerate(NEWER)]
    file = written(tmp_path / "a.csv", rows)
    assert reason in " ".join(render_logs([file]).split())
    (row,) = rows_of(file).values()
    assert (row["t_down_s"], row["redeploys_unnecessary"]) == (None, pair(1))
    older = written(tmp_path / "b.csv", rows, OLDER)
    assert "not of b.csv, since its times jump from clock to clock" in " ".join(render_logs([older]).split())


def bad(text: str, place: int = 3, **cells: str) -> str:
    """Return a log's text with other cells in one of its rows."""
    header, *lines = text.splitlines()
    names = header.split(",")
    changed = dict(zip(names, lines[place - 2].split(","), strict=True)) | cells
    lines[place - 2] = ",".join(changed[name] for name in names)
    return "\n".join([header, *lines])


BAD: dict[str, tuple[Callable[[str], str], str]] = {
    "empty": (lambda _: "", "is not a log of the published exemplar: it is empty"),
    "no rows": (lambda text: text.splitlines()[0], "has no rows; leave it out"),
    "another table": (
        lambda _: "a,b\n1,2\n",
        "columns timestamp, iou, rule_name, .* and timestamp, .* missing in",
    ),
    "no iou": (
        lambda text: text.replace("iou", "miou", 1),
        "must have .* and iou is missing in its first line, 'timestamp",
    ),
    "twice": (lambda text: text.replace("success", "source", 1), "its column source is there twice"),
    "two layouts": (
        lambda text: f"{text}\n1,2,3\n",
        "must have 15 cells, as its first line has, got 3: logs of diff",
    ),
    "no number": (
        lambda text: bad(text, iou="good"),
        "The iou in line 3 of .* from 0 to 1, got 'good'; correct it",
    ),
    "no iou of a frame": (lambda text: bad(text, iou=""), "The iou in line 3 of .* from 0 to 1, got ''"),
    "NaN": (lambda text: bad(text, iou="nan"), "The iou in line 3 of .* from 0 to 1, got 'nan'"),
    "no time": (
        lambda text: bad(text, timestamp="soon"),
        "The timestamp in line 3 .* of nanoseconds, got 'soon'",
    ),
    "endless time": (
        lambda text: bad(text, timestamp="1e999"),
        "The timestamp in line 3 .* of nanoseconds, got",
    ),
    "no status": (
        lambda text: bad(text, strategy_status="ok"),
        "The strategy_status in line 3 .* up to 255, got 'ok'",
    ),
    "unordered": (
        lambda text: bad(text, 7, timestamp="99000000"),
        "must ascend, got 99000000 ns after .* in line 7;",
    ),
    "quotes": (lambda text: f'{text}\n"unfinished', "it is not CSV"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_log_is_refused_in_one_sentence(case: str, tmp_path: Path) -> None:
    change, words = BAD[case]
    file = written(tmp_path / "a.csv", NEWER)
    file.write_text(change(file.read_text()))
    with pytest.raises(RecordError, match=words) as caught:
        render_logs([file])
    assert str(file) in str(caught.value)


def test_a_log_that_is_not_a_text_or_huge_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b"timestamp\xff")
    with pytest.raises(RecordError, match="it is not a text in UTF-8"):
        render_logs([tmp_path / "a.csv"])
    with (tmp_path / "a.csv").open("wb") as file:
        file.truncate(2**24 + 1)
    with pytest.raises(RecordError, match="cannot be read: it is larger than 16777216 bytes"):
        render_logs([tmp_path / "a.csv"])


def test_files_and_folders_stand_for_logs_each_once(tmp_path: Path) -> None:
    one, two = written(tmp_path / "x" / "a.csv", NEWER), written(tmp_path / "x" / "y" / "b.csv", NEWER)
    written(tmp_path / "x" / ".hidden" / "c.csv", NEWER)
    assert find_logs([tmp_path / "x"]) == [one, two]
    assert find_logs([two, tmp_path / "x"]) == [two, one]
    assert find_logs([tmp_path / "nowhere"]) == []
    with pytest.raises(RecordError, match=r"nowhere is not a log .* Name one folder of runs, such as"):
        find_logs([one, tmp_path / "nowhere"])
    (tmp_path / "x" / "y" / "run.json").touch()
    assert find_logs([tmp_path / "x"]) == []


def test_the_command_line_reports_logs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path / "theirs" / "a.csv", NEWER)
    assert main(["report", str(file), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert [row["system"] for row in printed["rows"]] == ["theirs"]
    for options in (["--runs"], ["--recompute"], ["--format", "original-csv", "--out", "x"], ["--site", "x"]):
        assert main(["report", str(tmp_path / "theirs"), *options]) == 2
        assert "theirs has published logs and not runs: leave out" in capsys.readouterr().err
    assert main(["report", str(tmp_path / "missing.csv")]) == 2
    assert "missing.csv cannot be read: No such file or directory." in capsys.readouterr().err
