"""Logs of the published exemplar: CSV files."""

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from sunset.errors import RecordError
from sunset.evaluation.published.script import LogRow
from sunset.files.inputs import read_text
from sunset.texts.names import RUN_FILE
from sunset.texts.sentences import listed
from sunset_ros.texts import shorten, shown

_NEEDED: Final = ("timestamp", "source", "iou")


def find_logs(path: Path) -> list[Path]:
    """Return a CSV file, or all CSV files below a folder without runs."""
    if path.suffix.lower() == ".csv" and not path.is_dir():
        return [path]
    return [] if next(path.rglob(RUN_FILE), None) else sorted(path.rglob("*.csv"))


def read_log(file: Path) -> list[LogRow]:
    """Return the rows of a log; all columns but the time, the source and the IoU are optional.

    Raises:
        RecordError: the file cannot be read, or is not such a log.
    """
    try:
        text = io.StringIO(read_text(file).removeprefix("\ufeff"), newline="")
        lines = csv.DictReader(text, strict=True)
        return [_row(cells, f"in line {lines.line_num}") for cells in lines]
    except OSError as error:
        raise RecordError(f"The log {file} cannot be read: {error.strerror}.") from error
    except (csv.Error, ValueError) as error:
        raise RecordError(f"{file} is not a published log: {error}; leave it out.") from error


def _row(cells: Mapping[str, str], place: str) -> LogRow:
    if None in cells or None in map(cells.get, {*cells, *_NEEDED}):
        raise ValueError(f"{place} there must be a cell for each column, {listed(_NEEDED)} among them")
    return LogRow(
        int(_number(cells, "timestamp", place, 2**63)),
        cells["source"],
        rule=cells.get("rule_name", ""),
        strategy=cells.get("strategy_name", ""),
        status=int(_number(cells, "strategy_status", place, 255)),
        iou=_number(cells, "iou", place, 1),
        fault=cells.get("gt_failure_name", ""),
    )


def _number(cells: Mapping[str, str], name: str, place: str, most: float) -> float:
    text = cells.get(name) or "0"
    try:
        number = float(text)
    except ValueError:
        number = -1.0
    if not 0 <= number <= most:
        raise ValueError(f"{name} {place} must be a number from 0 to {most:g}, got {shown(shorten(text))}")
    return number
