"""The report as LaTeX: a document that compiles as it is, with a table to take out of it."""

import unicodedata
from types import MappingProxyType
from typing import Final

from sunset.evaluation.blocks import Block, Cell, Interval, LineKind, Quantity, Report

_ESCAPES: Final = MappingProxyType(
    {character: rf"\{character}" for character in "{}$&#%_"}
    | {
        "\\": r"\textbackslash{}",
        "^": r"\textasciicircum{}",
        "~": r"\textasciitilde{}",
        "<": r"\textless{}",
        ">": r"\textgreater{}",
        "|": r"\textbar{}",
        '"': "''",
        "`": r"\textasciigrave{}",
        "-": "{-}",  # so that two do not become a dash
        "±": r"$\pm$",
        "−": "$-$",
        "→": r"$\rightarrow$",
        "…": r"\ldots{}",
        "\n": " ",
    }
)

_LONG: Final = 24
"""A name of more characters has a line of its own."""

_HEAD: Final = r"""\documentclass{article}
\usepackage{textcomp}
\usepackage{booktabs}
\usepackage[a4paper,margin=15mm]{geometry}
\begin{document}
"""


def as_latex(report: Report) -> str:
    """Return a report as a document of LaTeX: its tables, each of which can be taken out, and its notes."""
    notes = [rf"\item {escape_latex(note)}" for note in report.notes]
    listed = [r"\clearpage", r"\begin{itemize}\footnotesize", *notes, r"\end{itemize}", ""] if notes else []
    return "\n".join([_HEAD, *map(_table, report.blocks), *listed, r"\end{document}", ""])


def escape_latex(text: str) -> str:
    r"""Return `text` such that LaTeX prints it, whatever it holds; what it cannot print becomes a `?`.

    >>> escape_latex("my_manager.py:A&B")
    'my\\_manager.py:A\\&B'
    """
    return "".join(_escaped(character) for character in text)


def _escaped(character: str) -> str:
    if character in _ESCAPES:
        return _ESCAPES[character]
    if " " <= character <= "~":
        return character
    base = unicodedata.normalize("NFKD", character)[0]
    return _ESCAPES.get(base, base) if " " <= base <= "~" else "?"


def _cell(cell: Cell) -> str:
    match cell:
        case None:
            return "N/A"
        case Quantity(mean, None):
            return f"${mean:z.2f}$"
        case Quantity(mean, std):
            return rf"${mean:z.2f} \pm {std:.2f}$"
        case Interval(low, high):
            return rf"$[{low:z.2f},\,{high:z.2f}]$"
    return escape_latex(cell)


def _table(block: Block) -> str:
    heads = " & ".join(["system", "runs", *(column.latex for column in block.columns)])
    out = [
        r"\begin{table*}[htbp]",
        r"\centering\footnotesize\setlength{\tabcolsep}{3pt}",
        rf"\caption{{{escape_latex(block.title)}.}}",
        rf"\label{{{block.label}}}\par\medskip",
        rf"\begin{{tabular}}{{lr{'c' * len(block.columns)}}}",
        r"\toprule",
        heads + r" \\",
    ]
    for group in block.groups:
        out.append(r"\midrule")
        for line in group:
            indent = r"\quad " if line.label.startswith("  ") else ""
            label_cell = escape_latex(line.label.strip())
            if len(line.label) > _LONG:
                out.append(rf"\multicolumn{{{len(line.cells) + 2}}}{{l}}{{{label_cell}}} \\")
                label_cell = ""
            cells = [indent + label_cell, line.runs, *map(_cell, line.cells)]
            if line.kind is not LineKind.OURS:
                cells = [rf"\scriptsize {cell}" if cell else "" for cell in cells]
            out.append(" & ".join(cells) + r" \\")
    out += [r"\bottomrule", r"\end{tabular}", r"\end{table*}", ""]
    return "\n".join(out)
