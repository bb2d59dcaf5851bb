"""The layout of a report in any format: the figures of each table, and the notes."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from types import MappingProxyType
from typing import Final

from sunset.evaluation.blocks import (
    CURED,
    NEEDLESS,
    PAPER_LABEL,
    Block,
    Cell,
    Column,
    Line,
    Quantity,
    Report,
    deviation_cell,
)
from sunset.evaluation.intervals import DEVIATIONS, INTERVALS
from sunset.evaluation.results import RunRow
from sunset.evaluation.score_layout import lead_blocks, lead_notes
from sunset.evaluation.scores import ScoreTable
from sunset.evaluation.summary import PAPER_SUITES, SystemRow
from sunset.system import DIAGNOSE, REPAIR
from sunset.texts.sentences import counted, tallied
from sunset_ros.texts import printable, shorten

_COLUMNS: Final = MappingProxyType(
    {
        "f_resolved_per_adaptation": Column("f_res/a_exec ↑", "resolved failures per executed adaptation"),
        "t_react_s": Column("t_react [s] ↓", "from when a failure began to the command that resolved it"),
        "redeploys_unnecessary": Column(
            "#redeploy_u ↓", "redeploys of a node without a fault that only a redeploy cures"
        ),
        "t_down_s": Column("t_down [s] ↓", "time without segmentation at the expected rate"),
        "iou": Column("IoU ↑", "mean over the evaluated frames"),
        "cured": CURED,
        "uncured_s": Column("uncured [s] ↓", "mean time that a fault was there without a cure in place"),
        "masked_s": Column(
            "masked [s] ↓",
            "time in which a fault was there, its symptom had gone, and the segmentation was bad",
        ),
        "needless": NEEDLESS,
        "cost_frames": Column("cost ↓", "prices of the adaptations, in frames"),
        "unresolved": Column("unresolved ↓", "failure episodes that no adaptation ended, of all"),
        "t_detect_s": Column("t_detect [s]", "part of t_react, until the symptom holds"),
        "t_decide_s": Column("t_decide [s] ↓", "the rest of t_react, until the command"),
        "t_repair_s": Column("t_repair [s] ↓", "from the command to when the symptom is gone"),
        "iou_all": Column("IoU_all ↑", "frames that never came count as 0"),
    }
)
_PAPER: Final = ("f_resolved_per_adaptation", "t_react_s", "redeploys_unnecessary", "t_down_s", "iou")
_FAULTS: Final = ("cured", "uncured_s", "masked_s", "needless", "cost_frames")
_MORE: Final = ("unresolved", "t_detect_s", "t_decide_s", "t_repair_s", "iou_all")
_LACKING: Final = MappingProxyType(
    {
        "f_resolved_per_adaptation": ("f_res/a_exec", "nothing was adapted"),
        "t_react_s": ("t_react", "nothing was resolved"),
        "iou": ("IoU", "no frame with labels came"),
    }
)
"""Figure → its name, and the reason why a run may lack it."""
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

_LEAST_CALM_S: Final = 1.0
"""The least time without a fault for a rate of false alarms: a fault at 0 comes half a millisecond after 0."""
_SHOWN: Final = 10
_LONGEST_REASON: Final = 300
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
        _block("What became of the faults", "tab:sunset-faults", judged, _FAULTS),
        _diagnosis_block([row for row in rows if every or row.example.task == DIAGNOSE]),
        _block("More about the same runs", "tab:sunset-more", judged, _MORE),
    )
    cells = [cell for block in blocks for line in block.lines for cell in line.cells]
    quantities = [cell for cell in cells if isinstance(cell, Quantity)]
    return Report(
        tuple(block for block in blocks if block.lines),
        notes=(
            *_provenance(rows),
            *lead_notes(scores),
            *([INTERVALS] if any(cell.interval for cell in quantities) else ()),
            *([DEVIATIONS] if any(cell.std is not None for cell in quantities) else ()),
            *([_PAPER_NOTE] if papers else ()),
            *_notes(rows, shown=papers),
        ),
    )


def _block(title: str, label: str, rows: Sequence[SystemRow], names: Sequence[str]) -> Block:
    lines = (Line(row.system, str(row.runs), tuple(_cell(row, name) for name in names)) for row in rows)
    return Block(title, tuple(_COLUMNS[name] for name in names), tuple(lines), label)


def _cell(row: SystemRow, name: str) -> Cell:
    if name == "unresolved":
        return _share(row.total("episodes_unresolved"), row.total("episodes"), row.unresolved_rate)
    if name == "cured":
        return _share(row.cured, len(row.outcomes), row.cured_rate)
    return deviation_cell(row.estimates[name])


def _share(part: float, whole: float, rate: float | None) -> str | None:
    return None if rate is None else f"{part:.0f}/{whole:.0f} ({rate:.0%})"


def _diagnosis_block(rows: Sequence[SystemRow]) -> Block:
    """Return the table of diagnoses, with `none` for comparison; empty if no run published a diagnosis."""
    diagnosing = [row for row in rows if row.total("diagnoses")]
    shown = [row for row in rows if row in diagnosing or row.example.manager == "none"] if diagnosing else []
    lines = tuple(
        Line(row.system, str(row.runs), _diagnosis_cells(row)) for row in shown if not row.is_reference
    )
    return Block("Diagnosis", _DIAGNOSIS_COLUMNS, lines, "tab:sunset-diagnosis")


def _diagnosis_cells(row: SystemRow) -> tuple[Cell, ...]:
    injected, calm_s = row.total("faults_injected"), row.total("faultless_s")
    shares = (_level(row, count, time, injected) if injected else None for count, time in _LEVELS)
    alarms = Quantity(60 * row.total("false_alarms") / calm_s) if calm_s >= _LEAST_CALM_S else None
    brier = row.estimates["brier"]
    return (*shares, alarms, None if brier is None else f"{brier.mean:.3f}")


def _level(row: SystemRow, count: str, time: str, injected: float) -> str:
    """Return the number of faults that reached a level, and the mean time until then."""
    after = row.estimates.get(time)
    return f"{row.total(count):.0f}/{injected:.0f}" + (f", {after.mean:.2f} s" if after else "")


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
    ordered = sorted(set(values))
    more = [f"and {len(ordered) - _SHOWN} others"] if len(ordered) > _SHOWN else []
    texts = [*(shorten(value, _LONGEST_REASON) for value in ordered[:_SHOWN]), *more]
    return f"{name}{plural if len(ordered) > 1 else ''} {', '.join(texts)}".lstrip()


def _seeds(seeds: Collection[int]) -> str:
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
    versions: dict[str, set[str]] = {}
    for package, version in (item for run in runs for item in run.others.items()):
        versions.setdefault(package, set()).add(version)
    return [
        f"{name} ({', '.join(sorted(several))})"
        for name, several in sorted(versions.items())
        if len(several) > 1
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
    return _listed(tallied(_reason(run, reason) for run, reason in reasons), "reasons")


def _reason(run: RunRow, reason: str) -> str:
    """Return a run's reason without its scenario and seed, so that equal reasons are counted together."""
    place = f" in {_plain_name(run)}, seed {run.seed}:"
    return shorten(reason.replace(place, ":", 1).rstrip("."), _LONGEST_REASON) or "no reason given"


def _plain_name(run: RunRow) -> str:
    """Return the name of a run's scenario without a checksum."""
    return run.scenario.removesuffix(f" {run.faults}")


def _listed(texts: Sequence[str], plural: str) -> str:
    """Return texts as a sentence; of many texts only the first."""
    more = [f"and {len(texts) - _SHOWN} other {plural}"] if len(texts) > _SHOWN else []
    return "; ".join([*texts[:_SHOWN], *more]) + "."
