"""The layout of a report in any format: the figures of each table, and the notes."""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

from sunset.evaluation.differences import DIFFERENCE_METHOD, ManagerDifference
from sunset.evaluation.formats import PAPER_LABEL, Block, Cell, Column, Line, Quantity, Report
from sunset.evaluation.intervals import DEVIATIONS, INTERVALS, NO_INTERVAL, Estimate
from sunset.evaluation.results import RunRow
from sunset.evaluation.scores import HARM, NO_SCORE, SCORE_METHOD, ScoreRow, ScoreTable
from sunset.evaluation.summary import PAPER_SUITES, SystemRow
from sunset.evaluation.thinking import thinking_block
from sunset.system import DIAGNOSE, REPAIR
from sunset.texts.sentences import counted, listed, tallied
from sunset_ros.texts import printable, shorten

_CURED: Final = Column("cured ↑", "faults that were cured, of all")
_NEEDLESS: Final = Column("needless ↓", "adaptations of a run that are no step of a cure of a fault there")
_FIRST_COLUMNS: Final = (
    Column("evidence", "what the managing system looked at, and is ranked by"),
    Column("score ↑", "the share of what repairing can win: 0 as none, 1 as oracle; with its 95 % interval"),
    Column("quality ↑", "mean IoU of all frames (IoU_all), of which one that never came counts 0"),
    Column("t_down ↓", "time of a run without segmentation"),
    _NEEDLESS,
    _CURED,
)
_HARM_COLUMNS: Final = (Column("harm ↓", "what utility loses against none where repairing wins nothing"),)
_DIFFERENCE_COLUMNS: Final = (
    Column("score", "the difference in score"),
    Column("utility", "the difference in utility"),
    Column("pairs won", "the share of pairs in which the first has more utility, ties by half"),
    Column("p", "of the difference in utility, adjusted after Holm"),
)
_PAPER: Final = {
    "f_resolved_per_adaptation": Column("f_res/a_exec ↑", "resolved failures per executed adaptation"),
    "t_react_s": Column("t_react [s] ↓", "from when a failure began to the command that resolved it"),
    "redeploys_unnecessary": Column(
        "#redeploy_u ↓", "redeploys of a node without a fault that only a redeploy cures"
    ),
    "t_down_s": Column("t_down [s] ↓", "time without segmentation at the expected rate"),
    "iou": Column("IoU ↑", "mean over the evaluated frames"),
}
FAULT_COLUMNS: Final = {
    "cured": _CURED,
    "uncured_s": Column("uncured [s] ↓", "mean time that a fault was there without a cure in place"),
    "masked_s": Column(
        "masked [s] ↓", "time in which a fault was there, its symptom had gone, and the segmentation was bad"
    ),
    "needless": _NEEDLESS,
    "cost_frames": Column("cost ↓", "prices of the adaptations, in frames"),
}
_MORE: Final = {
    "unresolved": Column("unresolved ↓", "failure episodes that no adaptation ended, of all"),
    "t_detect_s": Column("t_detect [s]", "part of t_react, until the symptom holds"),
    "t_decide_s": Column("t_decide [s] ↓", "the rest of t_react, until the command"),
    "t_repair_s": Column("t_repair [s] ↓", "from the command to when the symptom is gone"),
    "iou_all": Column("IoU_all ↑", "frames that never came count as 0"),
}
_LEVELS: Final = {
    ("faults_detected", "t_detected_s"): Column(
        "detected ↑", "of all faults: a fault was reported, and how long after the onset"
    ),
    ("faults_located", "t_located_s"): Column("located ↑", "likewise, a fault of the same node"),
    ("faults_identified", "t_identified_s"): Column("identified ↑", "likewise, the fault itself"),
    ("faults_top1", ""): Column(
        "top 1 ↑", "the fault was among the k most probable, of k faults that were there"
    ),
}
_DIAGNOSIS_COLUMNS: Final = (
    *_LEVELS.values(),
    Column("alarms [1/min] ↓", "false alarms per minute without a fault"),
    Column("Brier ↓", "mean square error of the probabilities, over time and faults"),
)
_LACKING: Final = {
    "f_resolved_per_adaptation": ("f_res/a_exec", "nothing was adapted"),
    "t_react_s": ("t_react", "nothing was resolved"),
    "iou": ("IoU", "no frame with labels came"),
}
"""Figure → its name, and the reason why a run may lack it."""

_LEAST_P: Final = 0.001
_LEAST_CALM_S: Final = 1.0
"""The least time without a fault for a rate of false alarms: a fault at 0 comes half a millisecond after 0."""
_SHOWN: Final = 10
_LONGEST_REASON: Final = 300
_BESIDE: Final = "; ".join(
    f"{column.text.rstrip(' ↑↓')}: {column.meaning}" for column in _FIRST_COLUMNS if column.text != "score ↑"
)
_PAPER_NOTE: Final = (
    "The paper's figures are by SUNSET's definitions. 'sunset report DIR --paper' shows them by those of the published "
    "evaluation script, with the published ones."
)


def arrange(rows: Sequence[SystemRow], scores: Sequence[ScoreTable] = (), *, every: bool = False) -> Report:
    """Return a report: the scores, the paper's figures of its suites and, if `every`, all other figures."""
    repairing = [row for row in rows if row.example.task == REPAIR]
    papers = [row for row in repairing if every or row.example.suite in PAPER_SUITES]
    judged = [row for row in repairing if every and not row.is_reference]
    blocks = (
        *lead_blocks(scores),
        _block("The paper's figures", PAPER_LABEL, papers, _PAPER),
        _block("What became of the faults", "tab:sunset-faults", judged, FAULT_COLUMNS),
        _diagnosis_block([row for row in rows if every or row.example.task == DIAGNOSE]),
        thinking_block(rows),
        _block("More about the same runs", "tab:sunset-more", judged, _MORE),
    )
    cells = [cell for block in blocks for line in block.lines for cell in line.cells]
    quantities = [cell for cell in cells if isinstance(cell, Quantity)]
    notes = [
        *_provenance(rows),
        *lead_notes(scores),
        *([INTERVALS] if any(cell.interval for cell in quantities) else []),
        *([DEVIATIONS] if any(cell.std is not None for cell in quantities) else []),
        *([_PAPER_NOTE] if papers else []),
        *_notes(rows, shown=papers),
    ]
    return Report([block for block in blocks if block.lines], notes)


def lead_blocks(tables: Sequence[ScoreTable]) -> list[Block]:
    """Return the tables of a report's first page: scores, harm, and differences between neighbours."""
    return [block for table in tables for block in _lead(table)]


def _lead(table: ScoreTable) -> Iterator[Block]:
    suite = f": {table.title}" if table.title else ""
    label = "-".join(("", *re.findall(r"[a-z0-9.]+", table.title.lower())))
    rows = sorted(table.rows, key=lambda row: row.evidence == "images")  # evidence is ranked apart
    harms = [Line(row.system, str(row.harm.runs), [_interval(row.harm)]) for row in table.rows if row.harm]
    differences = [_difference_line(pair) for pair in table.neighbours]
    harm, difference = "Harm where there is nothing to repair", "Differences between neighbours"
    yield Block(f"The score{suite}", _FIRST_COLUMNS, [*map(_score_line, rows)], f"tab:sunset-score{label}")
    yield Block(f"{harm}{suite}", _HARM_COLUMNS, harms, f"tab:sunset-harm{label}")
    yield Block(f"{difference}{suite}", _DIFFERENCE_COLUMNS, differences, f"tab:sunset-differences{label}")


def _score_line(row: ScoreRow) -> Line:
    lost = {"invalid": row.invalid, "missing": row.missing}
    runs = ", ".join([str(row.runs), *(f"{number} {state}" for state, number in lost.items() if number)])
    # the scores of references are 0 and 1 by definition
    score = Quantity(row.score.mean) if row.score and row.is_reference else _interval(row.score)
    quality, down, needless = (Quantity(each.mean) if each else None for each in row.estimates.values())
    cured = f"{row.cured}/{row.faults}" if row.faults else None
    down_s = f"{down.mean:.2f} s" if down else None
    return Line(row.system, runs, (row.evidence, score, quality, down_s, needless, cured))


def _difference_line(pair: ManagerDifference) -> Line:
    won = None if pair.pairs_won is None else Quantity(pair.pairs_won)
    p = None if pair.p_holm is None else f"< {_LEAST_P}" if pair.p_holm < _LEAST_P else f"{pair.p_holm:.3f}"
    cells = (_interval(pair.score), _interval(pair.utility), won, p)
    return Line(f"{pair.first} − {pair.second}", str(pair.pairs), cells)


def _block(title: str, label: str, rows: Sequence[SystemRow], columns: Mapping[str, Column]) -> Block:
    lines = [Line(row.system, str(row.runs), [_cell(row, name) for name in columns]) for row in rows]
    return Block(title, [*columns.values()], lines, label)


def _cell(row: SystemRow, name: str) -> Cell:
    if name == "unresolved":
        return _share(row.total("episodes_unresolved"), row.total("episodes"))
    if name == "cured":
        return _share(row.cured, len(row.outcomes))
    estimate = row.estimates[name]
    return Quantity(estimate.mean, estimate.std) if estimate else None


def _share(part: float, whole: float) -> str | None:
    return f"{part:.0f}/{whole:.0f} ({part / whole:.0%})" if whole else None


def _interval(estimate: Estimate | None) -> Quantity | None:
    return Quantity(estimate.mean, interval=estimate.interval) if estimate else None


def _diagnosis_block(rows: Sequence[SystemRow]) -> Block:
    """Return the table of diagnoses, with `none` for comparison; empty if no run published a diagnosis."""
    diagnosing = [row for row in rows if row.total("diagnoses")]
    shown = [row for row in rows if row in diagnosing or row.example.manager == "none"] if diagnosing else []
    lines = [Line(row.system, str(row.runs), _diagnosis_cells(row)) for row in shown if not row.is_reference]
    return Block("Diagnosis", _DIAGNOSIS_COLUMNS, lines, "tab:sunset-diagnosis")


def _diagnosis_cells(row: SystemRow) -> Sequence[Cell]:
    injected, calm_s = row.total("faults_injected"), row.total("faultless_s")
    levels = []
    for count, time in _LEVELS:
        after = row.estimates.get(time)
        until = f", {after.mean:.2f} s" if after else ""
        levels.append(f"{row.total(count):.0f}/{injected:.0f}{until}" if injected else None)
    alarms = Quantity(60 * row.total("false_alarms") / calm_s) if calm_s >= _LEAST_CALM_S else None
    brier = row.estimates["brier"]
    return (*levels, alarms, f"{brier.mean:.3f}" if brier else None)


def lead_notes(tables: Sequence[ScoreTable]) -> list[str]:
    """Return the notes of a report about its first page."""
    if not tables:
        return []
    scored = [table for table in tables if any(row.score or row.harm for row in table.rows)]
    rows = [row for table in scored for row in table.rows]
    pairs = [pair for table in tables for pair in table.neighbours]
    estimates = [
        *(estimate for row in rows for estimate in (row.score, row.harm)),
        *(estimate for pair in pairs for estimate in (pair.score, pair.utility)),
    ]
    return [
        SCORE_METHOD if scored else NO_SCORE,
        *([HARM] if any(row.harm for row in rows) else []),
        f"Beside the score: {_BESIDE}.",
        *(_price_note(table, evidence) for table in scored if table.orders for evidence in table.classes),
        *(
            f"{row.system}{_where(table)}: {row.unpaired} of {counted(row.runs, 'run')} without a score, since a valid "
            "run of none or oracle is missing."
            for table in scored
            for row in table.rows
            if row.unpaired
        ),
        *([DIFFERENCE_METHOD] if pairs else []),
        *filter(None, map(_sizes, scored)),
        *([NO_INTERVAL] if any(estimate and estimate.lacks_interval for estimate in estimates) else []),
    ]


def _price_note(table: ScoreTable, evidence: str) -> str:
    """Return a note about the order of rows with the same evidence, and its changes at multiples of the prices."""
    orders = table.orders_of(evidence)
    order = orders.pop(1.0)
    changed: defaultdict[tuple[str, ...], list[str]] = defaultdict(list)
    for multiple, other in orders.items():
        changed[_changed(other, order)].append(f"{multiple:g}")
    same = [f"the same at {listed(changed.pop(()))} times the prices"] if () in changed else []
    others = [f"at {listed(each)} times the prices {' > '.join(names)}" for names, each in changed.items()]
    by = f" by {evidence} (oracle and none for reference)" if len(table.classes) > 1 else ""
    return f"Order{_where(table)}{by}: {'; '.join([' > '.join(order), *same, *others])}."


def _sizes(table: ScoreTable) -> str:
    """Return a note about the numbers of degradations, flights and seeds; empty without intervals."""
    sizes = max(
        (row.score.spread.sizes for row in table.rows if row.score and row.score.spread), default=None
    )
    if sizes is None:
        return ""
    alike, flights, seeds = (
        counted(*of) for of in zip(sizes, ("degradation", "flight", "seed"), strict=True)
    )
    return f"Intervals{_where(table)} are of {alike}, {flights} and {seeds}."


def _where(table: ScoreTable) -> str:
    return f" in the suite {table.title}" if table.title else ""


def _changed(order: tuple[str, ...], usual: tuple[str, ...]) -> tuple[str, ...]:
    """Return the part of an order that differs from the usual order."""
    places = [place for place, names in enumerate(zip(order, usual, strict=True)) if len(set(names)) > 1]
    return order[places[0] : places[-1] + 1] if places else ()


def _provenance(rows: Sequence[SystemRow]) -> list[str]:
    """Return a note about the versions, models, middlewares, seeds and flights of the runs."""
    if not rows:
        return []
    runs = [row.example for row in rows]
    parts = (
        _named("SUNSET", "", (run.version or "unknown" for run in runs)),
        _named("model", "s", (run.model for run in runs)),
        _named("middleware", "s", (run.middleware for run in runs)),
        _seeds({run.seed for row in rows for run in row.all_runs}),
        _named("", "", (f"{run.flight.duration_s:g} s measured" for run in runs)),
        _named("flight", "s", (f"{run.flight.name} {run.flight.short_bag}".lstrip() for run in runs)),
    )
    return [f"{'; '.join(parts)}."]


def _named(name: str, plural: str, values: Iterable[str]) -> str:
    """Return different values behind their name; of many values only the first."""
    ordered = [shorten(value, _LONGEST_REASON) for value in sorted(set(values))]
    return f"{name}{plural if len(ordered) > 1 else ''} {', '.join(_first(ordered, 'others'))}".lstrip()


def _first(texts: Sequence[str], others: str) -> list[str]:
    more = [f"and {len(texts) - _SHOWN} {others}"] if len(texts) > _SHOWN else []
    return [*texts[:_SHOWN], *more]


def _seeds(seeds: set[int]) -> str:
    """Return seeds in words, consecutive seeds by the first and the last."""
    first, last = min(seeds), max(seeds)
    if 1 < len(seeds) == last - first + 1:
        return f"seeds {first} to {last}"
    return _named("seed", "s", map(str, seeds))


def _notes(rows: Sequence[SystemRow], *, shown: Sequence[SystemRow]) -> list[str]:
    """Return notes about runs that are missing from a figure, invalid, failed or doubtful."""
    runs = [run for row in rows for run in row.all_runs]
    notes = [note for row in rows for note in _row_notes(row, is_shown=row in shown)]
    notes += [
        f"{shorten(row.system, 100)}: it has scenarios of one name that differ, as those of two splits do."
        for row in rows
        if len({run.scenario for run in row.all_runs}) > len(set(map(_plain_name, row.all_runs)))
    ]
    notes += dict.fromkeys(
        f"Flight {run.flight.name or run.flight.short_bag}: {run.warning}" for run in runs if run.warning
    )
    if all(run.valid for run in runs):
        some = any(run.failed for run in runs)
        notes.append("Every run counts, also one that failed." if some else "Every run is valid.")
    return notes


def _row_notes(row: SystemRow, *, is_shown: bool) -> Iterator[str]:
    """Yield the notes about a row's runs."""
    name = shorten(row.system, 100)
    for figure, (called, reason) in _LACKING.items() if is_shown else ():
        estimate = row.estimates[figure]
        if estimate is not None and estimate.runs < row.runs:
            yield f"{name}: {called} is of {estimate.runs} of {row.runs} runs; in the others {reason}."
    without_truth = row.estimates["frames_without_truth"]
    if without_truth is not None and without_truth.mean:
        frames = f"{without_truth.mean:.4g} frames of a run"
        yield f"{name}: {frames} have no labels and count for no figure of quality."
    if invalid := [(run, run.reason) for run in row.all_runs if not run.valid]:
        subject = "1 invalid run is" if len(invalid) == 1 else f"{len(invalid)} invalid runs are"
        yield f"{name}: {subject} left out of all columns but the score: {_reasons(invalid)}"
    if failed := [(run, run.failed) for run in row.all_runs if run.failed]:
        yield f"{name}: {len(failed)} of {counted(len(row.all_runs), 'run')} failed: {_reasons(failed)}"
    if differing := [run for run in row.all_runs if run.differing]:
        texts = [f"{', '.join(run.differing)} of {printable(str(run.folder))}" for run in differing]
        yield (
            f"{name}: figures were stored that the messages do not give, and are computed here: "
            f"{_listed(texts, 'runs')}"
        )
    if pairs := list(_contradicting(row.all_runs)):
        yield (
            f"{name}: runs of the same scenario, seed, managing system and version have different messages, so that "
            f"they were changed, or their computers or packages differ: {_listed(pairs, 'pairs')}"
        )
    if open_runs := [run for run in row.all_runs if run.missing_walls]:
        walls = ", ".join(dict.fromkeys(wall for run in open_runs for wall in run.missing_walls))
        yield f"{name}: {counted(len(open_runs), 'run')} took place without {walls} around the managing system."
    if several := _several(row.all_runs):
        yield f"{name}: its runs were made with several versions of {_listed(several, 'packages')}"


def _several(runs: Iterable[RunRow]) -> list[str]:
    """Return the packages of which runs had several versions, with the versions."""
    versions: defaultdict[str, set[str]] = defaultdict(set)
    for package, version in (item for run in runs for item in run.others.items()):
        versions[package].add(version)
    return [
        f"{name} ({', '.join(sorted(known))})" for name, known in sorted(versions.items()) if len(known) > 1
    ]


def _contradicting(runs: Iterable[RunRow]) -> Iterator[str]:
    """Yield the folders of simulated runs that should have the same messages, but differ."""
    first: dict[tuple[str, int], RunRow] = {}
    for run in runs:
        if run.middleware == "sim" and run.sources and not run.failed:
            known = first.setdefault((run.scenario, run.seed), run)
            if run.digest != known.digest:
                yield f"{printable(str(known.folder))} and {printable(str(run.folder))}"


def _reasons(reasons: Iterable[tuple[RunRow, str]]) -> str:
    """Return reasons without scenario and seed, so that equal reasons are counted together."""
    texts = (reason.replace(f" in {_plain_name(run)}, seed {run.seed}:", ":", 1) for run, reason in reasons)
    plain = (shorten(text.rstrip("."), _LONGEST_REASON) or "no reason given" for text in texts)
    return _listed(tallied(plain), "reasons")


def _plain_name(run: RunRow) -> str:
    """Return the name of a run's scenario without a checksum."""
    return run.scenario.removesuffix(f" {run.faults}")


def _listed(texts: Sequence[str], plural: str) -> str:
    """Return texts as a sentence; of many texts only the first."""
    return "; ".join(_first(texts, f"other {plural}")) + "."
