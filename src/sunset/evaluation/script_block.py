"""The block of a report that has the figures of the paper's evaluation script."""

from collections.abc import Mapping, Sequence
from typing import Final

from sunset.evaluation.blocks import Block, Column, Line, LineKind, Quantity
from sunset.evaluation.script_figures import SCRIPT_METHOD, ScriptFigures
from sunset.evaluation.summary import PUBLISHED, SystemRow
from sunset.metrics import SCRIPT_FIGURES
from sunset.texts import listed, tallied

SCRIPT_TITLE: Final = "By the paper's evaluation script"

SCRIPT_COLUMNS: Final = (
    Column(
        "f_res/a_exec ↑",
        r"$\frac{f_\mathrm{resolved}}{a_\mathrm{executed}}\uparrow$",
        "by the script: rules that succeeded, per executed strategy",
    ),
    Column(
        "t_react [s] ↓",
        r"$t_\mathrm{react}\,[\mathrm{s}]\downarrow$",
        "by the script: from a rule's trigger to its success",
    ),
    Column(
        "#redeploy_u ↓",
        r"$\#\mathrm{redeploy}_\mathrm{u}\downarrow$",
        "by the script: redeploys, less injected faults that only a redeploy cures",
    ),
    Column(
        "t_down [s] ↓",
        r"$t_\mathrm{down}\,[\mathrm{s}]\downarrow$",
        "by the script: gaps of more than 0.2 s between two frames",
    ),
    Column(
        "IoU ↑", r"IoU $\uparrow$", "by the script: mean over the frames until shortly after the last event"
    ),
)
"""The column of each of `SCRIPT_FIGURES`."""


def script_blocks(rows: Sequence[SystemRow]) -> tuple[Block, ...]:
    """Return the block of a table's rows; nothing where it would have no line.

    A managing system of which the script refuses all logs, since nothing was adapted, is not in the block.
    """
    groups = tuple(
        (script_line(row.system, figures), *published_lines(row.published)) for row, figures in _shown(rows)
    )
    return (Block(SCRIPT_TITLE, SCRIPT_COLUMNS, groups, "tab:sunset-script"),) if groups else ()


def script_notes(rows: Sequence[SystemRow]) -> list[str]:
    """Say how the block's figures come about, and which are missing from it."""
    found = {row.system: row.by_paper_script for row in rows if row.by_paper_script and not row.is_reference}
    notes = [SCRIPT_METHOD, *refusal_notes(found)] if _shown(rows) else []
    lacking = [row.system for row in rows if row.by_paper_script is None and row.has_adapted]
    if lacking:
        notes.append(
            f"The figures by the paper's evaluation script are not stored with all runs of {listed(lacking)}; "
            "--recompute computes them."
        )
    return notes


def _shown(rows: Sequence[SystemRow]) -> list[tuple[SystemRow, ScriptFigures]]:
    """Return the rows of which the script counts a log, with its figures."""
    return [(row, row.by_paper_script) for row in rows if row.by_paper_script and row.by_paper_script.counts]


def script_line(label: str, script: ScriptFigures) -> Line:
    """Return the figures of several logs as a line."""
    pairs = (script.figures[name] for name in SCRIPT_FIGURES)
    cells = tuple(None if pair is None else Quantity(*pair) for pair in pairs)
    return Line(LineKind.OURS, label, str(script.logs), cells)


def refusal_notes(scripts: Mapping[str, ScriptFigures]) -> list[str]:
    """Say which logs the script refuses, by what their lines are called."""
    notes = []
    for label, script in scripts.items():
        reasons = "; ".join(tallied(script.refused))
        if reasons:
            notes.append(
                f"{label}: the paper's evaluation script refuses {len(script.refused)} of {script.logs} logs, but for "
                f"their redeploys: {reasons}."
            )
    return notes


def published_lines(name: str | None) -> tuple[Line, ...]:
    """Return the line with the figures of a row of the paper's table; nothing where there is none."""
    if name is None:
        return ()
    figures = PUBLISHED[name]
    cells = tuple(Quantity(*figures[figure]) if figure in figures else None for figure in SCRIPT_FIGURES)
    return (Line(LineKind.PUBLISHED, "  published", "", cells),)
