"""The paper's five figures by the rules of the published exemplar's evaluation script, which reads logs.

A published log is a CSV file. SUNSET's managing systems write no such log, so it is made from the record of a run. Each
of their adaptations is taken for an executed strategy, which answers the rule of a current symptom. Each failure has a
rule.
"""

import csv
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from itertools import pairwise
from math import inf, isnan
from pathlib import Path
from typing import Annotated, Final, NamedTuple

import msgspec
import numpy as np

from sunset.errors import InvalidInputError, RecordError
from sunset.evaluation.formats import Block, Column, Line, Quantity, Report, as_html, as_latex, as_text
from sunset.evaluation.results import load_results
from sunset.evaluation.summary import named_groups
from sunset.files.inputs import read_text
from sunset.metrics import ExecutedAdaptation, Spell, Timeline, downtime, executed_adaptations, spells_of
from sunset.processes.workers import Progress
from sunset.recording import check_extensions, measured_topics, read_messages, read_run, timeline_of
from sunset.recording.timelines import start_of
from sunset.system import DURATION_S, ENTROPY_SIGNAL, PERIOD_S, Failure, current_system
from sunset.system_interfaces.msg import FaultInjection, FrameEvaluation
from sunset.texts.names import RUN_FILE
from sunset.texts.sentences import tallied
from sunset_ros.texts import printable

_RENDERERS: Final = {"table": as_text, "latex": as_latex, "html": as_html}
PAPER_FORMATS: Final = (*_RENDERERS, "json")

PUBLISHED: Final = {
    "f_resolved_per_adaptation": Quantity(0.89, 0.16),
    "t_react_s": Quantity(1.44, 1.32),
    "redeploys_unnecessary": Quantity(2.02, 1.04),
    "t_down_s": Quantity(6.52, 4.67),
    "iou": Quantity(0.30, 0.09),
}
"""The paper's baseline: Wiedholz et al., SUNSET, RoSE '26, Table 1."""

EVALUATOR: Final = "/evaluator_log"
EXECUTOR: Final = "scenario_executor"
ANALYZER: Final = "analyzer"
PLANNING: Final = "planning"
"""The writers of a log's rows."""

EXECUTED: Final = 1
SUCCEEDED: Final = 3
RESOLVED: Final = 5
"""The status of a strategy, in rows of the planning and the analyzer."""

_COLUMNS: Final = (
    Column("f_res/a_exec ↑", "of the rules"),
    Column("t_react [s] ↓", "from trigger to success"),
    Column("#redeploy_u ↓", "redeploys that no fault needed"),
    Column("t_down [s] ↓", "gaps between frames"),
    Column("IoU ↑", "mean over the frames"),
)
_OWN: Final = ("t_down_s", "iou", "iou_all")
"""SUNSET's figures that can be computed from a log."""
_OWN_COLUMNS: Final = (*_COLUMNS[-2:], Column("IoU_all ↑", "lost frames count as 0"))
_METHOD: Final = (
    "By the published script: mean ± population standard deviation over logs; of t_react and IoU over the values of "
    "all logs at once. Published: Wiedholz et al., SUNSET, RoSE '26, Table 1, of 54 scenarios of 20 s."
)
_OWN_METHOD: Final = (
    "By SUNSET's definitions: mean ± population standard deviation over logs, of the 20 s from the first injection on. "
    "A log lacks the symptoms, which the other figures need."
)
_LONGEST_GAP_NS: Final = 200_000_000
_DROPPED_ROWS: Final = 4
_ROWS_AFTER_LAST_EVENT: Final = 10
_LEAST_FRAMES: Final = 10
_WALL_NS: Final = 10**18  # an experiment's clock needs 31 years for this
_REDEPLOY_ONLY: Final = frozenset({"hardware_disconnect", "memory_leakage", "gpu_failure"})
_LOOK_S: Final = 0.2  # time between two looks at a symptom [s]
_NEWS_S: Final = 0.15
"""Greatest age of symptoms when a managing system acts [s]; the blackboard is published every 0.1 s."""
_TOLERANCE_S: Final = 1e-6


_LOG_COLUMNS: Final = {
    "time_ns": "timestamp",
    "rule": "rule_name",
    "strategy": "strategy_name",
    "status": "strategy_status",
    "fault": "gt_failure_name",
}


class LogRow(msgspec.Struct, frozen=True, rename=_LOG_COLUMNS):
    """A row of a log."""

    time_ns: Annotated[int, msgspec.Meta(ge=0)]  # on the experiment's clock
    source: str  # the writer, such as `EVALUATOR`
    rule: str = ""
    strategy: str = ""
    status: int = 0  # of the strategy, such as `EXECUTED`; 0 when a rule of the analyzer triggers
    iou: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.0  # of the evaluator's frame, NaN without labels
    fault: str = ""


class LogFigures(NamedTuple):
    """The values of each of the paper's five figures: of t_react for each success, of IoU for each frame."""

    refused: str  # why the script counts only redeploys; empty if it counts everything
    values: Mapping[str, Sequence[float]]
    own: Mapping[str, Sequence[float]]  # of `_OWN`, by SUNSET's definitions


def paper_report(path: Path, form: str = "table", *, progress: Progress | None = None) -> str:
    """Return the paper's five figures by the published script's rules, in one of `PAPER_FORMATS`.

    Each managing system is a row, with its runs of the suite `paper`; arguments are as in `load_results`. If the
    path is a log of the published exemplar, or a folder of logs, each folder is a row, also by SUNSET's definitions.

    Raises:
        InvalidInputError: the format is unknown.
        RecordError: the path has neither runs of the suite nor logs, or a file is damaged.
    """
    if form not in PAPER_FORMATS:
        raise InvalidInputError(
            f"The format with --paper must be one of {', '.join(PAPER_FORMATS)}, got {form!r}."
        )
    files = _find_logs(path)
    sources = [(printable(str(file.parent)), file) for file in files] or _paper_runs(path)
    rows: dict[str, list[LogFigures]] = {}
    for done, (label, source) in enumerate(sources, 1):
        rows.setdefault(label, []).append(log_figures(_read_log(source) if files else log_of_run(source)))
        if progress is not None:
            progress(done, len(sources))
    report = _arranged(rows, are_logs=bool(files))
    if form in _RENDERERS:
        return _RENDERERS[form](report)
    content = {
        "rows": [
            {"system": label, "logs": len(logs), "logs_refused": len(_refused(logs))}
            | _pairs(_pooled(logs))
            | ({"own": _pairs(_pooled(logs, own=True))} if files else {})
            for label, logs in rows.items()
        ],
        "published": {"system": "baseline", **_pairs(PUBLISHED)},
        "notes": report.notes,
    }
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _find_logs(path: Path) -> list[Path]:
    """Return a CSV file, or all CSV files below a folder without runs."""
    if path.suffix.lower() == ".csv" and not path.is_dir():
        return [path]
    return [] if next(path.rglob(RUN_FILE), None) else sorted(path.rglob("*.csv"))


def _paper_runs(path: Path) -> list[tuple[str, Path]]:
    runs = [run for run in load_results(path) if run.suite == "paper" and run.valid and not run.is_empty]
    if not runs:
        raise RecordError(f"There is neither a valid run of the suite paper nor a log below {path}.")
    return [(label, run.folder) for label, group in named_groups(runs) for run in group]


def _read_log(file: Path) -> list[LogRow]:
    """Return the rows of a published log; empty cells count as absent."""
    place = ""
    rows = []
    try:
        lines = csv.DictReader(StringIO(read_text(file).removeprefix("\ufeff"), newline=""), strict=True)
        for cells in lines:
            place = f"line {lines.line_num}: "
            filled = {name: cell for name, cell in cells.items() if cell != ""}
            lacking = dict.fromkeys({"iou"} - cells.keys())
            rows.append(msgspec.convert(lacking | filled, LogRow, strict=False))
    except OSError as error:
        raise RecordError(f"The log {file} cannot be read: {error.strerror}.") from error
    except (csv.Error, UnicodeDecodeError, msgspec.ValidationError) as error:
        raise RecordError(f"{file} is not a published log: {place}{error}; leave it out.") from error
    return rows


def _arranged(rows: Mapping[str, Sequence[LogFigures]], *, are_logs: bool) -> Report:
    """Return the report; rows whose logs the script refuses are not in its table."""
    lines = [
        Line(label, str(len(logs)), tuple(_pooled(logs).values()))
        for label, logs in rows.items()
        if len(_refused(logs)) < len(logs)
    ]
    notes = [_METHOD] * bool(lines) + [_OWN_METHOD] * are_logs
    notes += [
        f"{label}: the published script refuses {len(refused)} of {len(logs)} logs, but for their redeploys: "
        f"{'; '.join(tallied(refused))}."
        for label, logs in rows.items()
        if (refused := _refused(logs))
    ]
    published = Line("baseline, published", "", tuple(PUBLISHED.values()))
    own = [
        Line(label, str(len(logs)), tuple(_pooled(logs, own=True).values())) for label, logs in rows.items()
    ]
    blocks = [
        Block("By the published script", _COLUMNS, (*lines, published), "tab:sunset-paper"),
        Block("By SUNSET's definitions", _OWN_COLUMNS, tuple(own), "tab:sunset-logs"),
    ]
    return Report(tuple(blocks[not lines : 1 + are_logs]), tuple(notes))


def _refused(logs: Iterable[LogFigures]) -> list[str]:
    return [log.refused for log in logs if log.refused]


def _pooled(logs: Sequence[LogFigures], *, own: bool = False) -> dict[str, Quantity | None]:
    figures = [log.own if own else log.values for log in logs]
    names = _OWN if own else PUBLISHED
    pools = {name: [value for log in figures for value in log.get(name, ())] for name in names}
    return {
        name: Quantity(float(np.mean(pool)), float(np.std(pool))) if pool else None
        for name, pool in pools.items()
    }


def _pairs(figures: Mapping[str, Quantity | None]) -> dict[str, object]:
    return {
        name: quantity and {"mean": quantity.mean, "std": quantity.std} for name, quantity in figures.items()
    }


def log_figures(log: Sequence[LogRow]) -> LogFigures:
    """Return the figures of a log, whose rows are in order of time.

    The script ignores the last four rows, and rows more than ten after the last event, which is a row that is not a
    frame.
    """
    rows = list(log[:-_DROPPED_ROWS])
    events = [place for place, row in enumerate(rows) if row.source != EVALUATOR]
    rows = rows[: events[-1] + 1 + _ROWS_AFTER_LAST_EVENT] if events else rows
    planned = [row for row in rows if row.source == PLANNING]
    needed = sum(row.source == EXECUTOR and row.fault in _REDEPLOY_ONLY for row in rows)
    unnecessary = sum("redeploy" in row.strategy for row in planned) - needed
    frames, rules = ([row for row in rows if row.source == source] for source in (EVALUATOR, ANALYZER))
    reactions, repeated = _reactions(rules)
    refused = _problem(rows) or ("" if rules else "no rule was triggered") or repeated
    own = {} if _problem(log) else _own_figures(log)
    if refused:
        return LogFigures(refused, {"redeploys_unnecessary": [unnecessary]}, own)
    succeeded = sum(row.status in {SUCCEEDED, RESOLVED} for row in rules)
    executed = sum(row.status == EXECUTED for row in planned)
    gaps_ns = [later.time_ns - row.time_ns for row, later in pairwise(frames)]
    values: dict[str, Sequence[float]] = {
        "f_resolved_per_adaptation": [succeeded / executed] if executed else [],
        "t_react_s": reactions,
        "redeploys_unnecessary": [unnecessary],
        "t_down_s": [sum(gap for gap in gaps_ns if gap > _LONGEST_GAP_NS) / 1e9],
        "iou": [row.iou for row in frames if not isnan(row.iou)],
    }
    return LogFigures("", values, own)


def _problem(log: Sequence[LogRow]) -> str:
    if sum(row.source == EVALUATOR for row in log) < _LEAST_FRAMES:
        return f"it has fewer than {_LEAST_FRAMES} frames"
    times = [row.time_ns for row in log]
    if not all(0 < time_ns < _WALL_NS for time_ns in times):
        return "a time in it is 0 or of a wall clock"
    return "" if times == sorted(times) else "its times do not ascend"


def _reactions(rules: Sequence[LogRow]) -> tuple[list[float], str]:
    """Return the times from triggers to successes [s], and why the script refuses the log; empty if it does not."""
    triggered: dict[str, int] = {}
    waiting: set[str] = set()
    reactions, problem = [], ""
    for row in rules:
        if not row.strategy:
            if row.rule in waiting:
                problem = f"the rule {row.rule} is triggered again before its outcome"
            waiting.add(row.rule)
            triggered[row.rule] = row.time_ns
            continue
        waiting.discard(row.rule)
        if row.status in {SUCCEEDED, RESOLVED} and row.rule in triggered:
            reactions.append((row.time_ns - triggered.pop(row.rule)) / 1e9)
    return reactions, problem


def _own_figures(log: Sequence[LogRow]) -> dict[str, Sequence[float]]:
    start_ns = next((row.time_ns for row in log if row.source == EXECUTOR), None)
    if start_ns is None:
        return {}
    frames = [((row.time_ns - start_ns) / 1e9, row.iou) for row in log if row.source == EVALUATOR]
    ious = [iou for time_s, iou in frames if 0 <= time_s < DURATION_S]
    times = np.array([time_s for time_s, _ in frames])
    return {
        "t_down_s": [downtime(times, period_s=PERIOD_S, duration_s=DURATION_S)],
        "iou": [sum(ious) / len(ious)] if ious else [],
        "iou_all": [sum(ious) * PERIOD_S / DURATION_S],
    }


def log_of_run(folder: Path) -> list[LogRow]:
    """Return the log that the published exemplar would have written of a stored run, in order of time.

    Raises:
        RecordError: the record is damaged, or other extensions made it.
    """
    run = read_run(folder)
    check_extensions(run, folder)
    messages = read_messages(folder, measured_topics())
    rows = []
    for recorded in messages:
        match recorded.message:
            case FrameEvaluation(iou=iou):
                rows.append(LogRow(recorded.time_ns, EVALUATOR, iou=iou))
            case FaultInjection(fault=fault):
                rows.append(LogRow(recorded.time_ns, EXECUTOR, fault=fault))
    rows += rule_rows(timeline_of(run, messages), start_of(messages))
    return sorted(rows, key=lambda row: row.time_ns)


@dataclass(frozen=True, slots=True)
class _Rule:
    """A rule, the nodes whose adaptation answers it (the failing node first), and when its symptom held."""

    name: str
    nodes: tuple[str, ...]
    is_silence: bool
    spells: Sequence[Spell]

    def holds_at(self, time_s: float) -> bool:
        return any(spell.holds <= time_s + _TOLERANCE_S < (spell.ended or inf) for spell in self.spells)


def rule_rows(timeline: Timeline, start_ns: int) -> list[LogRow]:
    """Return the rows of the analyzer and of the planning; `start_ns` is the injection on the experiment's clock.

    An adaptation triggers the rule that it answers, unless that is triggered already. The rule succeeds when a look,
    every 0.2 s, does not see its symptom.
    """
    rules = [_rule(failure, timeline) for failure in current_system().failures.values()]
    rows: list[LogRow] = []
    busy_until: dict[str, float] = {}

    def add(time_s: float, source: str, rule: str = "", strategy: str = "", status: int = 0) -> None:
        rows.append(LogRow(start_ns + round(time_s * 1e9), source, rule, strategy, status))

    for adaptation in executed_adaptations(timeline.commands, until_s=timeline.duration_s):
        time_s = adaptation.time
        strategy = "+".join(adaptation.parameters) or f"{adaptation.kind}_{adaptation.node}"
        rule = _answered(adaptation, rules)
        if rule is not None and busy_until.get(rule.name, -inf) <= time_s:
            add(time_s, ANALYZER, rule.name)
            looks = np.arange(time_s + _LOOK_S, timeline.duration_s + _TOLERANCE_S, _LOOK_S)
            gone_s = next((look for look in looks.tolist() if not rule.holds_at(look)), inf)
            busy_until[rule.name] = gone_s
            if gone_s < inf:
                add(gone_s, ANALYZER, rule.name, strategy, SUCCEEDED)
        add(time_s, PLANNING, "", strategy, EXECUTED)
    return rows


def _rule(failure: Failure, timeline: Timeline) -> _Rule:
    system = current_system()
    node, spells = system.failing_nodes[failure.name], spells_of(failure, timeline)
    if failure.topic:
        return _Rule(f"redeploy_{node}", (node,), True, spells)
    name = "do_recalibration" if failure.signal == ENTROPY_SIGNAL.name else failure.signal
    return _Rule(name, (node, *system.upstream[node]), False, spells)


def _answered(adaptation: ExecutedAdaptation, rules: Sequence[_Rule]) -> _Rule | None:
    """Return the rule that an adaptation answers; None without a symptom.

    The symptom is a silence of the adapted node, or a signal of this node or of a node downstream. A call that sets
    parameters answers signals first, other adaptations answer silences first.
    """
    node, seen_s = adaptation.node, (adaptation.time, adaptation.time - _NEWS_S)
    able = [rule for rule in rules if node in rule.nodes and any(map(rule.holds_at, seen_s))]
    sets = bool(adaptation.parameters)
    return min(able, key=lambda rule: (rule.is_silence is sets, rule.nodes[0] != node), default=None)
