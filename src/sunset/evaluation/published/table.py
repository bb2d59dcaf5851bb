"""The paper's five figures by the published script's rules, with the paper's row beneath."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from sunset.errors import InvalidInputError, RecordError
from sunset.evaluation import load_results
from sunset.evaluation.blocks import Block, Column, Line, Quantity, Report
from sunset.evaluation.latex import as_latex
from sunset.evaluation.published.log_files import find_logs, read_log
from sunset.evaluation.published.run_logs import log_of_run
from sunset.evaluation.published.script import OWN_FIGURES, LogFigures, log_figures
from sunset.evaluation.summary import named_groups
from sunset.evaluation.text import as_text
from sunset.evaluation.webpage import as_html
from sunset.processes.workers import Progress
from sunset.texts.sentences import tallied
from sunset_ros.texts import printable

_RENDERERS: Final = MappingProxyType({"table": as_text, "latex": as_latex, "html": as_html})
PAPER_FORMATS: Final = (*_RENDERERS, "json")

PUBLISHED: Final[Mapping[str, Quantity]] = MappingProxyType(
    {
        "f_resolved_per_adaptation": Quantity(0.89, 0.16),
        "t_react_s": Quantity(1.44, 1.32),
        "redeploys_unnecessary": Quantity(2.02, 1.04),
        "t_down_s": Quantity(6.52, 4.67),
        "iou": Quantity(0.30, 0.09),
    }
)
"""The paper's baseline: Wiedholz et al., SUNSET, RoSE '26, Table 1."""

_COLUMNS: Final = (
    Column("f_res/a_exec ↑", "of the rules"),
    Column("t_react [s] ↓", "from trigger to success"),
    Column("#redeploy_u ↓", "redeploys that no fault needed"),
    Column("t_down [s] ↓", "gaps between frames"),
    Column("IoU ↑", "mean over the frames"),
    Column("IoU_all ↑", "lost frames count as 0"),
)
_METHOD: Final = (
    "By the published script: mean ± population standard deviation over logs; of t_react and IoU over the values of "
    "all logs at once. Published: Wiedholz et al., SUNSET, RoSE '26, Table 1, of 54 scenarios of 20 s."
)
_OWN_METHOD: Final = (
    "By SUNSET's definitions: mean ± population standard deviation over logs, of the 20 s from the first injection on. "
    "A log lacks the symptoms, which the other figures need."
)


@dataclass(frozen=True, slots=True)
class _Row:
    """A row of the table: a managing system's runs, or a folder of logs."""

    label: str
    logs: Sequence[LogFigures]

    @property
    def refused(self) -> list[str]:
        return [log.refused for log in self.logs if log.refused]

    @property
    def by_script(self) -> dict[str, Quantity | None]:
        return {name: _pooled(log.by_script.get(name, ()) for log in self.logs) for name in PUBLISHED}

    @property
    def own(self) -> dict[str, Quantity | None]:
        return {name: _pooled(log.own.get(name, ()) for log in self.logs) for name in OWN_FIGURES}

    def line(self, figures: Mapping[str, Quantity | None]) -> Line:
        return Line(self.label, str(len(self.logs)), tuple(figures.values()))

    def to_json(self, *, are_logs: bool) -> dict[str, object]:
        about = {"system": self.label, "logs": len(self.logs), "logs_refused": len(self.refused)}
        return about | _pairs(self.by_script) | ({"own": _pairs(self.own)} if are_logs else {})


def _pooled(logs: Iterable[Sequence[float]]) -> Quantity | None:
    values = [value for log in logs for value in log]
    return Quantity(float(np.mean(values)), float(np.std(values))) if values else None


def paper_report(path: Path, form: str = "table", *, progress: Progress | None = None) -> str:
    """Return the paper's five figures by the published script's rules.

    Args:
        path: a folder of runs: each managing system is a row, with its runs of the suite `paper`. Or a log of the
            published exemplar, or a folder of logs: each folder is a row, also by SUNSET's definitions.
        form: the format, one of `PAPER_FORMATS`.
        progress: called with (logs that are done, logs in all).

    Raises:
        InvalidInputError: the format is unknown.
        RecordError: the path has neither runs of the suite nor logs, or a file is damaged.
    """
    if form not in PAPER_FORMATS:
        raise InvalidInputError(
            f"The format with --paper must be one of {', '.join(PAPER_FORMATS)}, got {form!r}."
        )
    files = find_logs(path)
    read = read_log if files else log_of_run
    figures: dict[str, list[LogFigures]] = {}
    sources = [(printable(str(file.parent)), file) for file in files] or _paper_runs(path)
    for done, (label, source) in enumerate(sources, 1):
        figures.setdefault(label, []).append(log_figures(read(source)))
        if progress is not None:
            progress(done, len(sources))
    rows = [_Row(label, logs) for label, logs in figures.items()]
    report = _arranged(rows, are_logs=bool(files))
    if form in _RENDERERS:
        return _RENDERERS[form](report)
    content = {
        "rows": [row.to_json(are_logs=bool(files)) for row in rows],
        "published": {"system": "baseline", **_pairs(PUBLISHED)},
        "notes": report.notes,
    }
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _paper_runs(path: Path) -> list[tuple[str, Path]]:
    runs = [run for run in load_results(path) if run.suite == "paper" and run.valid and not run.is_empty]
    if not runs:
        raise RecordError(f"There is neither a valid run of the suite paper nor a log below {path}.")
    return [(label, run.folder) for label, group in named_groups(runs) for run in group]


def _arranged(rows: Sequence[_Row], *, are_logs: bool) -> Report:
    """Return the report; rows whose logs the script refuses are not in the block by the script."""
    blocks, notes = [], []
    counted = [row for row in rows if len(row.refused) < len(row.logs)]
    if counted:
        lines = [row.line(row.by_script) for row in counted]
        lines.append(Line("baseline, published", "", tuple(PUBLISHED.values())))
        blocks.append(Block("By the published script", _COLUMNS[:5], tuple(lines), "tab:sunset-paper"))
        notes.append(_METHOD)
    if are_logs:
        lines = [row.line(row.own) for row in rows]
        blocks.append(Block("By SUNSET's definitions", _COLUMNS[3:], tuple(lines), "tab:sunset-logs"))
        notes.append(_OWN_METHOD)
    notes += [
        f"{row.label}: the published script refuses {len(row.refused)} of {len(row.logs)} logs, but for their "
        f"redeploys: {'; '.join(tallied(row.refused))}."
        for row in rows
        if row.refused
    ]
    return Report(tuple(blocks), tuple(notes))


def _pairs(figures: Mapping[str, Quantity | None]) -> dict[str, object]:
    return {
        name: quantity and {"mean": quantity.mean, "std": quantity.std} for name, quantity in figures.items()
    }
