"""Runs as logs that the paper's evaluation script reads: a file of CSV each, in the published exemplar's columns."""

import shutil
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from sunset.errors import RecordError
from sunset.evaluation.results import RunRow, load_results
from sunset.evaluation.summary import named_groups
from sunset.metrics import LogRow, LogSource, log_figures
from sunset.output_files import draft_of_folder, folder_name
from sunset.recording import (
    check_extensions,
    measured_topics,
    published_log,
    read_messages,
    read_run,
    timeline_of,
)
from sunset.texts import counted, csv_text, listed
from sunset.workers import Progress

LOG_COLUMNS: Final = (
    "timestamp",
    "scenario",
    "source",
    "rule_name",
    "strategy_name",
    "strategy_hash",
    "strategy_status",
    "adaptation_type",
    "adaptation_status",
    "success",
    "iou",
    "vehicle_iou",
    "road_iou",
    "gt_failure_name",
    "is_gt_failure",
)
"""The columns of a log, a row an event."""


@dataclass(frozen=True, slots=True)
class WrittenLogs:
    """What was written.

    Attributes:
        folder: it has a folder of logs for each managing system.
        files: the logs, below the folder.
        left_out: the managing systems of which the script refuses all logs, as reports call them.
    """

    folder: Path
    files: tuple[Path, ...]
    left_out: tuple[str, ...]

    def __str__(self) -> str:
        """Return it in a sentence."""
        written = f"{self.folder} has {counted(len(self.files), 'log')}."
        if not self.left_out:
            return written
        return (
            f"{written} There is none of {listed(self.left_out)}: the paper's evaluation script refuses a log without "
            "a triggered rule."
        )


def write_logs(folder: Path, out: Path, *, progress: Progress | None = None) -> WrittenLogs:
    """Write a log of every valid run below a folder, in a new folder with a folder for each managing system.

    Args:
        folder: of one run, of a campaign, or of several.
        out: the new folder, which must not exist, or be empty.
        progress: called with (runs that are read, runs in all).

    Raises:
        RecordError: there is no run, one is damaged, or the script would refuse all logs.
        OutputError: the folder exists and is not empty, or cannot be written.
    """
    groups = [
        (label, [run for run in runs if run.valid and not run.is_empty])
        for label, runs in named_groups(load_results(folder))
    ]
    files: list[Path] = []
    left_out: list[str] = []
    done = 0
    with draft_of_folder(out, "folder of logs") as draft:
        for label, runs in groups:
            place = Path(folder_name(label))
            (draft / place).mkdir()
            written: Counter[str] = Counter()
            refused = 0
            for run in runs:
                log = _log_of(run)
                refused += bool(log_figures(log).refused)
                (draft / place / _file_name(run, written)).write_text(
                    _log_text(log, run.scenario), encoding="utf-8"
                )
                done += 1
                if progress is not None:
                    progress(done, sum(len(runs) for _, runs in groups))
            if refused == len(runs):
                shutil.rmtree(draft / place)
                left_out.append(label)
            else:
                files += sorted(file.relative_to(draft) for file in (draft / place).iterdir())
        if not files:
            raise RecordError(
                f"No valid run below {folder} gives a log that the paper's evaluation script does not refuse: it needs "
                "10 frames, and an adaptation that answers a symptom; run a managing system that adapts."
            )
    return WrittenLogs(out, tuple(out / file for file in files), tuple(left_out))


def _file_name(run: RunRow, names: Counter[str]) -> str:
    """Return the name of a run's log, which no other one of its folder has, and note it among the names."""
    name = f"{folder_name(run.scenario.removeprefix(f'{run.suite}/'))}-seed-{run.seed}"
    names[name] += 1
    return f"{name}.csv" if names[name] == 1 else f"{name}-run-{names[name]}.csv"


def _log_of(run: RunRow) -> list[LogRow]:
    """Return the log of a stored run."""
    record = read_run(run.folder)
    check_extensions(record, run.folder)
    messages = read_messages(run.folder, measured_topics())
    return published_log(messages, timeline_of(record, messages))


def _log_text(log: Sequence[LogRow], scenario: str) -> str:
    """Return a log as CSV: numbers that do not apply are 0 in `strategy_status` and `iou`, and empty elsewhere."""
    lines: list[Sequence[object]] = [LOG_COLUMNS]
    for row in log:
        is_fault = row.source is LogSource.SCENARIO_EXECUTOR
        cells = {
            "timestamp": row.time_ns,
            "scenario": scenario if is_fault else "",
            "source": row.source.value if row.source else "",
            "rule_name": row.rule,
            "strategy_name": row.strategy,
            "strategy_status": int(row.status),
            "iou": row.iou,
            "gt_failure_name": row.fault,
            "is_gt_failure": "True" if is_fault else "",
        }
        lines.append([cells.get(name, "") for name in LOG_COLUMNS])
    return csv_text(lines)
