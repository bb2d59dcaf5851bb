"""The report of logs of the published exemplar: what was not measured by SUNSET, and is never put beside its runs."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean, pstdev
from typing import Final

from sunset.errors import InvalidInputError
from sunset.evaluation.blocks import Block, Column, Line, LineKind, Quantity, Report
from sunset.evaluation.latex import as_latex
from sunset.evaluation.published_logs import PublishedLog, read_published_log
from sunset.evaluation.report import FORMATS
from sunset.evaluation.script_block import SCRIPT_COLUMNS, SCRIPT_TITLE, refusal_notes, script_line
from sunset.evaluation.script_figures import SCRIPT_METHOD, ScriptFigures
from sunset.evaluation.text import as_text
from sunset.evaluation.webpage import as_html
from sunset.metrics import SCRIPT_FIGURES
from sunset.texts import csv_text, printable
from sunset.workers import Progress

SELF_REPORTED: Final = ("f_resolved_per_adaptation", "t_react_s")
"""The figures that only the managing system itself vouches for."""

_ORIGINS: Final = ("self-reported", "self-reported", "as planned", "evaluated", "evaluated")
_OLDER_TITLE: Final = "Logs without rules and strategies"
_OLDER_COLUMNS: Final = (
    Column("#redeploy", r"$\#\mathrm{redeploy}$", "redeploys in the log, needed or not"),
    *SCRIPT_COLUMNS[3:],
)
_TRUST: Final = (
    "These are logs as of the published exemplar, not records of SUNSET: a log says itself what happened, and no "
    "digest stands for what was measured."
)
_ORIGIN_NOTE: Final = (
    "Self-reported is what only the managing system says; planned is what it says that it did; evaluated is what the "
    "evaluator's rows give."
)
_OLDER_NOTE: Final = (
    f"{_OLDER_TITLE} are refused by the paper's evaluation script: only redeploys, t_down and IoU can be had from "
    "them, cut and computed as it does with other logs."
)


@dataclass(frozen=True, slots=True)
class LogRows:
    """The logs of one folder that have the same columns: one row of the report.

    Attributes:
        label: what the row is called: the folder.
        columns: how many the logs have.
        logs: the logs.
    """

    label: str
    columns: int
    logs: tuple[PublishedLog, ...]

    @property
    def has_rules(self) -> bool:
        """Whether they can tell of rules and strategies."""
        return self.logs[0].has_rules

    @property
    def script(self) -> ScriptFigures:
        """What the paper's evaluation script gives for them."""
        return ScriptFigures.of([log.figures for log in self.logs])

    @property
    def redeploys(self) -> tuple[float, float]:
        """The mean and the population's standard deviation of their redeploys, needed or not."""
        numbers = [log.figures.redeploys for log in self.logs]
        return fmean(numbers), pstdev(numbers)

    @property
    def figures(self) -> Mapping[str, tuple[float, float] | None]:
        """Each of `SCRIPT_FIGURES`, and `redeploys`; None where they cannot be had."""
        found = self.script.figures
        had = {
            name: found[name] if self.has_rules or name in {"t_down_s", "iou"} else None
            for name in SCRIPT_FIGURES
        }
        return {**had, "redeploys": self.redeploys}


def render_logs(files: Sequence[Path], form: str = "table", *, progress: Progress | None = None) -> str:
    """Return the report of logs in one of `FORMATS`: a row for each folder, and for each layout of the logs in it.

    Args:
        files: the logs, at least one.
        form: the format.
        progress: called with (logs that are read, logs in all).

    Raises:
        RecordError: one cannot be read, or is not such a log.
        InvalidInputError: there is no such format.
    """
    if form not in FORMATS:
        raise InvalidInputError(f"The format of a report must be one of {', '.join(FORMATS)}, got {form!r}.")
    logs = []
    for done, file in enumerate(files, 1):
        logs.append(read_published_log(file))
        if progress is not None:
            progress(done, len(files))
    rows = _rows(logs)
    match form:
        case "json":
            return _as_json(rows)
        case "csv":
            return _as_csv(rows)
        case "latex":
            return as_latex(_arrange(rows))
        case "html":
            return as_html(_arrange(rows))
    return as_text(_arrange(rows))


def _rows(logs: Sequence[PublishedLog]) -> list[LogRows]:
    groups: dict[tuple[Path, int, bool], list[PublishedLog]] = {}
    for log in logs:
        groups.setdefault((log.file.absolute().parent, log.columns, log.has_rules), []).append(log)
    folders = list(dict.fromkeys(folder for folder, _, _ in groups))
    common = Path(os.path.commonpath(folders)) if len(folders) > 1 else folders[0].parent
    layouts = {folder: sum(place == folder for place, _, _ in groups) for folder in folders}
    return [
        LogRows(
            printable(folder.relative_to(common).as_posix())
            + (f" [{columns} columns]" if layouts[folder] > 1 else ""),
            columns,
            tuple(group),
        )
        for (folder, columns, _), group in groups.items()
    ]


def _arrange(rows: Sequence[LogRows]) -> Report:
    newer = [row for row in rows if row.has_rules]
    older = [row for row in rows if not row.has_rules]
    groups = tuple(
        (
            script_line(row.label, row.script),
            Line(LineKind.CONFIDENCE, "  where from", "", _ORIGINS),
        )
        for row in newer
    )
    blocks = [Block(SCRIPT_TITLE, SCRIPT_COLUMNS, groups, "tab:sunset-logs")] if newer else []
    notes = [_TRUST]
    if newer:
        notes += [_ORIGIN_NOTE, SCRIPT_METHOD]
    if older:
        lines = tuple((_older_line(row),) for row in older)
        blocks.append(Block(_OLDER_TITLE, _OLDER_COLUMNS, lines, "tab:sunset-older-logs"))
        notes.append(_OLDER_NOTE)
    notes += refusal_notes({row.label: row.script for row in newer})
    notes += [
        f"{row.label}: t_down and IoU are not of {log.file.name}, since {log.figures.refused}."
        for row in older
        for log in row.logs
        if log.figures.refused
    ]
    return Report(tuple(blocks), tuple(notes))


def _older_line(row: LogRows) -> Line:
    pairs = (row.figures[name] for name in ("redeploys", "t_down_s", "iou"))
    cells = tuple(None if pair is None else Quantity(*pair) for pair in pairs)
    return Line(LineKind.OURS, row.label, str(len(row.logs)), cells)


def _as_json(rows: Sequence[LogRows]) -> str:
    content = {
        "rows": [
            {
                "system": row.label,
                "source": "published log",
                "columns": row.columns,
                "logs": len(row.logs),
                "logs_refused": len(row.script.refused),
                **{
                    name: None if pair is None else dict(zip(("mean", "std"), pair, strict=True))
                    for name, pair in row.figures.items()
                },
                "self_reported": list(SELF_REPORTED) if row.has_rules else [],
            }
            for row in rows
        ],
        "method": f"{_TRUST} {SCRIPT_METHOD}",
    }
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _as_csv(rows: Sequence[LogRows]) -> str:
    names = (*SCRIPT_FIGURES, "redeploys")
    head = ["system", "source", "columns", "logs", "logs_refused"]
    head += [f"{name}_{part}" for name in names for part in ("mean", "std")]
    lines: list[list[object]] = [[*head, "self_reported"]]
    for row in rows:
        cells: list[object] = [
            row.label,
            "published log",
            row.columns,
            len(row.logs),
            len(row.script.refused),
        ]
        for name in names:
            cells += row.figures[name] or (None, None)
        lines.append([*cells, " ".join(SELF_REPORTED) if row.has_rules else ""])
    return csv_text(lines)
