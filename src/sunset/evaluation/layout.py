"""The report before it has a format: which figures stand in which line, and the notes beneath."""

from collections.abc import Collection, Iterable, Sequence
from types import MappingProxyType
from typing import Final

from sunset.evaluation.blocks import PAPER_LABEL, Block, Cell, Column, Line, Report, deviation_cell
from sunset.evaluation.diagnosis_block import diagnosis_blocks
from sunset.evaluation.estimates import DEVIATIONS
from sunset.evaluation.results import RunRow
from sunset.evaluation.score_layout import lead_blocks, lead_notes
from sunset.evaluation.scores import ScoreTable
from sunset.evaluation.summary import PAPER_SUITES, SystemRow
from sunset.system import DIAGNOSE, REPAIR
from sunset.texts import counted, printable, shorten, tallied

_COLUMNS: Final = MappingProxyType(
    {
        "f_resolved_per_adaptation": Column("f_res/a_exec ↑", "resolved failures per executed adaptation"),
        "t_react_s": Column("t_react [s] ↓", "from when a failure began to the command that resolved it"),
        "redeploys_unnecessary": Column(
            "#redeploy_u ↓", "redeploys of a node without a fault that only a redeploy cures"
        ),
        "t_down_s": Column("t_down [s] ↓", "time without segmentation at the expected rate"),
        "iou": Column("IoU ↑", "mean over the evaluated frames"),
        "cured": Column("cured ↑", "faults that were cured, of all"),
        "uncured_s": Column("uncured [s] ↓", "mean time that a fault was there without a cure in place"),
        "masked_s": Column(
            "masked [s] ↓",
            "time in which a fault was there, its symptom had gone, and the segmentation was bad",
        ),
        "needless": Column("needless ↓", "adaptations that are no step of a cure of a fault there"),
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
"""Figure → what it is called, and what happened in the runs that have none."""
_SHOWN: Final = 10
_LONGEST_REASON: Final = 300
_PAPER_NOTE: Final = (
    "The paper's figures are by SUNSET's definitions. 'sunset report DIR --paper' shows them by those of the published "
    "evaluation script, with the published ones."
)


def arrange(rows: Sequence[SystemRow], scores: Sequence[ScoreTable] = (), *, every: bool = False) -> Report:
    """Return the report of runs: the score and what stands beside it, then the paper's figures of its suites.

    Args:
        rows: those of the paper's table.
        scores: what it leads with.
        every: whether every other figure follows.
    """
    repairing = [row for row in rows if row.task == REPAIR]
    papers = [row for row in repairing if every or row.suite in PAPER_SUITES]
    judged = [row for row in repairing if every and not row.is_reference]
    figures = (
        _block("The paper's figures", PAPER_LABEL, papers, _PAPER),
        _block("What became of the faults", "tab:sunset-faults", judged, _FAULTS),
        *diagnosis_blocks([row for row in rows if every or row.task == DIAGNOSE]),
        _block("More about the same runs", "tab:sunset-more", judged, _MORE),
    )
    return Report(
        tuple(block for block in (*lead_blocks(scores), *figures) if block.lines),
        notes=(
            *_provenance(rows),
            *lead_notes(scores),
            *([DEVIATIONS, _PAPER_NOTE] if papers else ()),
            *_notes(rows, shown=papers),
        ),
    )


def _block(title: str, label: str, rows: Sequence[SystemRow], names: Sequence[str]) -> Block:
    lines = (Line(row.system, str(row.runs), tuple(_cell(row, name) for name in names)) for row in rows)
    return Block(title, tuple(_COLUMNS[name] for name in names), tuple(lines), label)


def _cell(row: SystemRow, name: str) -> Cell:
    if name == "unresolved":
        return _share(row.unresolved, row.episodes, row.unresolved_rate)
    if name == "cured":
        return _share(row.cured, len(row.outcomes), row.cured_rate)
    return deviation_cell(row.estimates[name])


def _share(part: int, whole: int, rate: float | None) -> str | None:
    return None if rate is None else f"{part}/{whole} ({rate:.0%})"


def _provenance(rows: Sequence[SystemRow]) -> list[str]:
    """Say in one line what was run, and with what."""
    if not rows:
        return []
    parts = (
        _named("SUNSET", "", (row.version or "unknown" for row in rows)),
        _named("model", "s", (row.model for row in rows)),
        _named("middleware", "s", (row.middleware for row in rows)),
        _seeds({seed for row in rows for seed in row.seeds}),
        _named("", "", (f"{row.flight.duration_s:g} s measured" for row in rows)),
        _named("flight", "s", (f"{row.flight.name} {row.flight.short_bag}".lstrip() for row in rows)),
    )
    return [f"{'; '.join(parts)}."]


def _named(what: str, plural: str, values: Iterable[str]) -> str:
    """Return different values with what they are before them; of many only the first."""
    found = sorted(set(values))
    more = [f"and {len(found) - _SHOWN} others"] if len(found) > _SHOWN else []
    texts = [*(shorten(value, _LONGEST_REASON) for value in found[:_SHOWN]), *more]
    return f"{what}{plural if len(found) > 1 else ''} {', '.join(texts)}".lstrip()


def _seeds(seeds: Collection[int]) -> str:
    """Return seeds in words: those that follow one another by the first and the last."""
    first, last = min(seeds), max(seeds)
    if 1 < len(seeds) == last - first + 1:
        return f"seeds {first} to {last}"
    return _named("seed", "s", map(str, seeds))


def _notes(rows: Sequence[SystemRow], *, shown: Sequence[SystemRow]) -> list[str]:
    """Say what a reader would otherwise take for granted: runs that are missing from a figure that is shown."""
    notes = []
    for row in rows:
        for name, (figure, reason) in _LACKING.items() if row.task == REPAIR else ():
            found = row.estimates[name]
            if row in shown and found is not None and found.runs < row.runs:
                notes.append(
                    f"{row.system}: {figure} is of {found.runs} of {row.runs} runs; in the others {reason}."
                )
        without_truth = row.estimates["frames_without_truth"]
        if without_truth is not None and without_truth.mean:
            notes.append(
                f"{shorten(row.system, 100)}: {without_truth.mean:.4g} frames of a run have no labels and count for no "
                "figure of quality."
            )
    notes += [_invalid_note(row) for row in rows if row.invalid]
    notes += [_failed_note(row) for row in rows if row.failed]
    notes += [_differing_note(row) for row in rows if row.differing]
    notes += [_walls_note(row) for row in rows if row.unwalled]
    notes += [
        f"{row.system}: its runs were made with several versions of "
        + _listed([f"{name} ({', '.join(versions)})" for name, versions in row.several.items()], "packages")
        for row in rows
        if row.several
    ]
    notes += dict.fromkeys(
        f"Flight {row.flight.name or row.flight.short_bag}: {row.warning}" for row in rows if row.warning
    )
    if not any(row.invalid for row in rows):
        some = any(row.failed for row in rows)
        notes.append("Every run counts, also one that failed." if some else "Every run is valid.")
    return notes


def _invalid_note(row: SystemRow) -> str:
    """Return how many of a row's runs do not count, and why."""
    number = len(row.invalid)
    what = "invalid run is" if number == 1 else "invalid runs are"
    reasons = _told((run, run.reason) for run in row.invalid)
    return f"{row.system}: {number} {what} left out of all columns but the score: {reasons}"


def _failed_note(row: SystemRow) -> str:
    """Return how many of a row's runs failed, and how: the managing system, or a node of an extension."""
    return f"{row.system}: {len(row.failed)} of {counted(row.runs + len(row.invalid), 'run')} failed: " + (
        _told((run, run.failed) for run in row.failed)
    )


def _walls_note(row: SystemRow) -> str:
    """Return in how many of a row's runs walls were missing, and which."""
    missing = dict.fromkeys(name for run in row.unwalled for name in run.missing_walls)
    number, walls = counted(len(row.unwalled), "run"), ", ".join(missing)
    return f"{row.system}: {number} took place without {walls} around the managing system."


def _told(reasons: Iterable[tuple[RunRow, str]]) -> str:
    """Return the reasons that runs have, those that are the same once."""
    return _listed(tallied(_reason(run, reason) for run, reason in reasons), "reasons")


def _reason(run: RunRow, reason: str) -> str:
    """Return a run's reason without what tells it from those of others that have the same."""
    place = f" in {run.scenario.removesuffix(f' {run.faults}')}, seed {run.seed}:"
    return shorten(reason.replace(place, ":", 1).rstrip("."), _LONGEST_REASON) or "no reason given"


def _differing_note(row: SystemRow) -> str:
    """Return which of a row's runs had other figures stored than are shown."""
    told = [f"{', '.join(run.differing)} of {printable(str(run.folder))}" for run in row.differing]
    return f"{row.system}: figures were stored that the messages do not give, and are computed here: " + (
        _listed(told, "runs")
    )


def _listed(texts: Sequence[str], what: str) -> str:
    """Return the texts in one sentence; of many only the first."""
    more = [f"and {len(texts) - _SHOWN} other {what}"] if len(texts) > _SHOWN else []
    return "; ".join([*texts[:_SHOWN], *more]) + "."
