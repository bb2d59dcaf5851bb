"""The report before it has a format: which figures stand in which line, and the notes beneath."""

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
from sunset.evaluation.diagnosis_block import diagnosis_blocks
from sunset.evaluation.estimates import DEVIATIONS, INTERVALS
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
    repairing = [row for row in rows if row.example.task == REPAIR]
    papers = [row for row in repairing if every or row.example.suite in PAPER_SUITES]
    judged = [row for row in repairing if every and not row.is_reference]
    blocks = (
        *lead_blocks(scores),
        _block("The paper's figures", PAPER_LABEL, papers, _PAPER),
        _block("What became of the faults", "tab:sunset-faults", judged, _FAULTS),
        *diagnosis_blocks([row for row in rows if every or row.example.task == DIAGNOSE]),
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
    """Give what must be known of a row's runs: figures that they lack, what was wrong with them, how they differ."""
    name = shorten(row.system, 100)
    for figure, (called, reason) in _LACKING.items() if is_shown else ():
        found = row.estimates[figure]
        if found is not None and found.runs < row.runs:
            yield f"{name}: {called} is of {found.runs} of {row.runs} runs; in the others {reason}."
    without_truth = row.estimates["frames_without_truth"]
    if without_truth is not None and without_truth.mean:
        frames = f"{without_truth.mean:.4g} frames of a run"
        yield f"{name}: {frames} have no labels and count for no figure of quality."
    if invalid := [(run, run.reason) for run in row.all_runs if not run.valid]:
        what = "1 invalid run is" if len(invalid) == 1 else f"{len(invalid)} invalid runs are"
        yield f"{name}: {what} left out of all columns but the score: {_told(invalid)}"
    if failed := [(run, run.failed) for run in row.all_runs if run.failed]:
        yield f"{name}: {len(failed)} of {counted(len(row.all_runs), 'run')} failed: {_told(failed)}"
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
    """Return the packages of which runs had several versions, with these."""
    versions: dict[str, set[str]] = {}
    for package, version in (item for run in runs for item in run.others.items()):
        versions.setdefault(package, set()).add(version)
    return [
        f"{name} ({', '.join(sorted(found))})" for name, found in sorted(versions.items()) if len(found) > 1
    ]


def _contradicting(runs: Iterable[RunRow]) -> Iterator[str]:
    """Give the folders of every two simulated runs that should have the same messages and have not."""
    first: dict[tuple[str, int], RunRow] = {}
    for run in runs:
        if run.middleware == "sim" and run.sources and not run.failed:
            known = first.setdefault((run.scenario, run.seed), run)
            if run.digest != known.digest:
                yield f"{printable(str(known.folder))} and {printable(str(run.folder))}"


def _told(reasons: Iterable[tuple[RunRow, str]]) -> str:
    """Return the reasons that runs have, those that are the same once."""
    return _listed(tallied(_reason(run, reason) for run, reason in reasons), "reasons")


def _reason(run: RunRow, reason: str) -> str:
    """Return a run's reason without what tells it from those of others that have the same."""
    place = f" in {_plain_name(run)}, seed {run.seed}:"
    return shorten(reason.replace(place, ":", 1).rstrip("."), _LONGEST_REASON) or "no reason given"


def _plain_name(run: RunRow) -> str:
    """Return the name of a run's scenario without what tells it from others of the same name."""
    return run.scenario.removesuffix(f" {run.faults}")


def _listed(texts: Sequence[str], what: str) -> str:
    """Return the texts in one sentence; of many only the first."""
    more = [f"and {len(texts) - _SHOWN} other {what}"] if len(texts) > _SHOWN else []
    return "; ".join([*texts[:_SHOWN], *more]) + "."
