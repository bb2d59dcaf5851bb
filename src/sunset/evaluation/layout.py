"""The report before it has a format: which figures stand in which line, and the notes beneath."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Final

from sunset.evaluation.blocks import PAPER_LABEL, Block, Cell, Column, Line, Quantity, Report
from sunset.evaluation.diagnosis_block import diagnosis_blocks
from sunset.evaluation.estimates import METHOD, NO_INTERVAL
from sunset.evaluation.results import RunRow
from sunset.evaluation.score_layout import lead_blocks, lead_notes
from sunset.evaluation.scores import ScoreTable
from sunset.evaluation.summary import PAPER_SUITES, SystemRow
from sunset.evaluation.treatments import fault_blocks, lines_of
from sunset.system import DIAGNOSE, REPAIR
from sunset.texts import counted, printable, shorten, tallied

_COLUMNS: Final[Mapping[str, Column]] = MappingProxyType(
    {
        "f_resolved_per_adaptation": Column(
            "f_res/a_exec ↑",
            r"$\frac{f_\mathrm{resolved}}{a_\mathrm{executed}}\uparrow$",
            "resolved failures per executed adaptation",
        ),
        "t_react_s": Column(
            "t_react [s] ↓",
            r"$t_\mathrm{react}\,[\mathrm{s}]\downarrow$",
            "from when a failure began to the command that resolved it",
        ),
        "redeploys_unnecessary": Column(
            "#redeploy_u ↓",
            r"$\#\mathrm{redeploy}_\mathrm{u}\downarrow$",
            "redeploys of a node without a fault that only a redeploy cures",
        ),
        "t_down_s": Column(
            "t_down [s] ↓",
            r"$t_\mathrm{down}\,[\mathrm{s}]\downarrow$",
            "time without segmentation at the expected rate",
        ),
        "iou": Column("IoU ↑", r"IoU $\uparrow$", "mean over the evaluated frames"),
        "unresolved": Column(
            "unresolved ↓", r"unresolved $\downarrow$", "failure episodes that no adaptation ended, of all"
        ),
        "t_detect_s": Column(
            "t_detect [s]", r"$t_\mathrm{detect}\,[\mathrm{s}]$", "part of t_react, until the symptom holds"
        ),
        "t_decide_s": Column(
            "t_decide [s] ↓",
            r"$t_\mathrm{decide}\,[\mathrm{s}]\downarrow$",
            "the rest of t_react, until the command",
        ),
        "t_repair_s": Column(
            "t_repair [s] ↓",
            r"$t_\mathrm{repair}\,[\mathrm{s}]\downarrow$",
            "from the command to when the symptom is gone",
        ),
        "iou_all": Column("IoU_all ↑", r"IoU$_\mathrm{all}\uparrow$", "frames that never came count as 0"),
    }
)
_PAPER: Final = ("f_resolved_per_adaptation", "t_react_s", "redeploys_unnecessary", "t_down_s", "iou")
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
    main = tuple(_group(row, _PAPER) for row in papers)
    more = tuple(_group(row, _MORE) for row in repairing if every and not row.is_reference)
    blocks = (
        *lead_blocks(scores),
        Block("The paper's figures", tuple(_COLUMNS[name] for name in _PAPER), main, PAPER_LABEL),
        *(fault_blocks(repairing) if every else ()),
        *diagnosis_blocks([row for row in rows if every or row.task == DIAGNOSE]),
        Block("More about the same runs", tuple(_COLUMNS[name] for name in _MORE), more, "tab:sunset-more"),
    )
    return Report(
        tuple(block for block in blocks if block.groups),
        notes=(
            *_provenance(rows),
            *lead_notes(scores),
            METHOD,
            *([_PAPER_NOTE] if papers else ()),
            *_notes(rows, shown=papers),
        ),
    )


def _group(row: SystemRow, names: Sequence[str]) -> tuple[Line, ...]:
    """Return a row's figures and, where there are any, their confidence intervals."""
    figures = tuple(_figure(row, name) for name in names)
    return lines_of(row, figures, tuple(row.estimates.get(name) for name in names))


def _figure(row: SystemRow, name: str) -> Cell:
    if name == "unresolved":
        rate = row.unresolved_rate
        return None if rate is None else f"{row.unresolved}/{row.episodes} ({rate:.0%})"
    found = row.estimates[name]
    return None if found is None else Quantity(found.mean, found.std)


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
    if any(found and found.lacks_interval for row in rows for found in row.estimates.values()):
        notes.append(NO_INTERVAL)
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
    notes += [_contradicting_note(row) for row in rows if row.contradicting]
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


def _contradicting_note(row: SystemRow) -> str:
    """Return which of a row's runs contradict each other."""
    told = [" and ".join(printable(str(run.folder)) for run in pair) for pair in row.contradicting]
    return (
        f"{row.system}: runs of the same scenario, seed, managing system and version have different messages, so that "
        "they were changed, or their computers or packages differ: " + _listed(told, "pairs")
    )


def _listed(texts: Sequence[str], what: str) -> str:
    """Return the texts in one sentence; of many only the first."""
    more = [f"and {len(texts) - _SHOWN} other {what}"] if len(texts) > _SHOWN else []
    return "; ".join([*texts[:_SHOWN], *more]) + "."
