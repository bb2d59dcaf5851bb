"""Logs of the published exemplar, read from files: found, checked, and what can be had from them."""

import csv
import io
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Final

from sunset.errors import RecordError
from sunset.input_files import read_text
from sunset.metrics import WALL_NS, LogFigures, LogRow, LogSource, log_figures
from sunset.recording import RUN_FILE
from sunset.texts import listed, shorten, shown

_ALWAYS: Final = ("timestamp", "iou")
_OF_RULES: Final = ("rule_name", "strategy_name", "strategy_status")
_WITHOUT_SOURCE: Final = (*_OF_RULES, "gt_failure_name")
"""The columns by which rows can be told apart where no column says whose they are."""
_SOURCES: Final = {source.value: source for source in LogSource}
_MOST_NS: Final = 2**64
_REDEPLOY: Final = {"4", "4.0"}
"""The number of a redeploy among the published exemplar's types of adaptations."""


@dataclass(frozen=True, slots=True)
class PublishedLog:
    """One log.

    Attributes:
        file: where it is.
        columns: how many it has.
        has_rules: whether it can tell of rules and strategies, as the paper's evaluation script needs.
        figures: what can be had from it.
    """

    file: Path
    columns: int
    has_rules: bool
    figures: LogFigures


def find_logs(paths: Sequence[Path]) -> list[Path]:
    """Return the logs that paths stand for, each once: files of CSV, and those below folders that hold no runs.

    Raises:
        RecordError: of several paths, or beside a log, one stands for none.
    """
    found = [(path, list(_logs_at(path))) for path in paths]
    files = [file for _, several in found for file in several]
    for path, several in found:
        if not several and len(found) > 1:
            raise RecordError(
                f"{path} is not a log of the published exemplar, nor a folder of such: several paths are read as logs "
                "only. Name one folder of runs, such as the one above several campaigns, and report logs apart."
            )
    return list({file.resolve(): file for file in files}.values())


def _logs_at(path: Path) -> Iterator[Path]:
    if path.suffix.lower() == ".csv" and not path.is_dir():
        yield path
    elif path.is_dir() and next(path.rglob(RUN_FILE), None) is None:
        for file in sorted(path.rglob("*.csv")):
            if not any(part.startswith(".") for part in file.relative_to(path).parts):
                yield file


def read_published_log(file: Path) -> PublishedLog:
    """Return what a log gives, of either of the published layouts, with or without the column `source`.

    Raises:
        RecordError: it cannot be read, is not such a log, or a row does not fit.
    """
    header, lines = _read(file)
    has_rules = set(_OF_RULES) <= set(header)
    rows = [_row(file, number, cells, has_rules=has_rules) for number, cells in lines]
    times = [row.time_ns for row in rows]
    wall = sum(time >= WALL_NS for time in times)
    jumps = 0 in times or 0 < wall < len(times)
    if not jumps:
        for (number, _), (time, following) in zip(lines[1:], pairwise(times), strict=True):
            if following < time:
                raise RecordError(
                    f"The times of the log {file} must ascend, got {following} ns after {time} ns in line {number}; "
                    "sort its rows by timestamp."
                )
    figures = log_figures(rows)
    if not has_rules:
        few = figures.refused if figures.refused.startswith("it has fewer") else ""
        figures = replace(
            figures,
            refused=few or ("its times jump from clock to clock" if jumps else ""),
            redeploys=_older_redeploys([cells for _, cells in lines]),
        )
    return PublishedLog(file, len(header), has_rules, figures)


def _read(file: Path) -> tuple[list[str], list[tuple[int, Mapping[str, str]]]]:
    """Return the names of a log's columns, and each row's line number with its cells by column."""
    try:
        reader = csv.reader(io.StringIO(read_text(file).removeprefix("\ufeff"), newline=""), strict=True)
        records = [(reader.line_num, record) for record in reader if record]
    except OSError as error:
        raise RecordError(f"The log {file} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise RecordError(
            f"{file} is not a log of the published exemplar: it is not a text in UTF-8."
        ) from error
    except csv.Error as error:
        raise RecordError(
            f"{file} is not a log of the published exemplar: it is not CSV, {error}."
        ) from error
    if not records:
        raise RecordError(f"{file} is not a log of the published exemplar: it is empty.")
    (_, header), *lines = records
    expected = (*_ALWAYS, "source") if "source" in header else (*_ALWAYS, *_WITHOUT_SOURCE)
    missing = [name for name in expected if name not in header]
    if missing:
        raise RecordError(
            f"{file} is not a log of the published exemplar: it must have the columns {listed(expected)}, and "
            f"{listed(missing)} is missing in its first line, {shown(','.join(header))}."
        )
    if len(set(header)) < len(header):
        twice = next(name for name, count in Counter(header).items() if count > 1)
        raise RecordError(
            f"{file} is not a log of the published exemplar: its column {twice} is there twice."
        )
    if not lines:
        raise RecordError(f"The log {file} has no rows; leave it out.")
    for number, record in lines:
        if len(record) != len(header):
            raise RecordError(
                f"Line {number} of the log {file} must have {len(header)} cells, as its first line has, got "
                f"{len(record)}: logs of different layouts are files of their own."
            )
    return header, [(number, dict(zip(header, record, strict=True))) for number, record in lines]


def _row(file: Path, number: int, cells: Mapping[str, str], *, has_rules: bool) -> LogRow:
    """Return a row of a log."""
    place = f"in line {number} of the log {file}"
    source = _source(cells)
    iou = _number(cells["iou"] or "0", "iou", place, "a number from 0 to 1", 1)
    if source is LogSource.EVALUATOR and not cells["iou"]:
        raise _misfit_error("iou", place, "a number from 0 to 1", "")
    status = 0.0
    if has_rules:
        status = _number(
            cells["strategy_status"] or "0", "strategy_status", place, "a whole number up to 255", 255
        )
    return LogRow(
        _time(cells["timestamp"], place),
        source,
        rule=cells.get("rule_name", ""),
        strategy=cells.get("strategy_name", ""),
        status=int(status),
        iou=iou,
        fault=cells.get("gt_failure_name", ""),
    )


def _source(cells: Mapping[str, str]) -> LogSource | None:
    """Return who wrote a row; without the column for that, what the row says tells it."""
    if "source" in cells:
        return _SOURCES.get(cells["source"])
    if cells["gt_failure_name"]:
        return LogSource.SCENARIO_EXECUTOR
    if cells["rule_name"]:
        return LogSource.ANALYZER
    return LogSource.PLANNING if cells["strategy_name"] else LogSource.EVALUATOR


def _time(text: str, place: str) -> int:
    """Return a time [ns]; programs that know no missing whole numbers write it with a point."""
    try:
        time = int(text) if text.isdecimal() else int(float(text))
    except (OverflowError, ValueError):
        time = -1
    if not 0 <= time < _MOST_NS:
        raise _misfit_error("timestamp", place, "a whole number of nanoseconds", text)
    return time


def _number(text: str, name: str, place: str, expected: str, most: float) -> float:
    try:
        number = float(text)
    except ValueError:
        number = -1.0
    if not 0 <= number <= most:  # also NaN
        raise _misfit_error(name, place, expected, text)
    return number


def _misfit_error(name: str, place: str, expected: str, got: str) -> RecordError:
    return RecordError(
        f"The {name} {place} must be {expected}, got {shown(shorten(got))}; correct it, or leave the log out."
    )


def _older_redeploys(lines: Sequence[Mapping[str, str]]) -> int:
    """Return the redeploys of a log without strategies: those planned, or else those executed.

    Such an adaptation may have a row for each of its statuses, so that the one with most rows says how many there are.
    """
    for kind in ("planning", "execute"):
        counts: dict[str, Counter[str]] = {}
        for cells in lines:
            source = cells["source"]
            if source.startswith(kind) and _names_redeploy(cells):
                counts.setdefault(source, Counter())[cells.get("adaptation_status", "")] += 1
        if counts:
            return sum(max(statuses.values()) for statuses in counts.values())
    return 0


def _names_redeploy(cells: Mapping[str, str]) -> bool:
    kind = cells.get("adaptation_type", "")
    return "redeploy" in f"{cells.get('rule_name', '')} {kind}".lower() or kind in _REDEPLOY
