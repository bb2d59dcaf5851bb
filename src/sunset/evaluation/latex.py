"""The report as a LaTeX document, whose tables can be copied into a paper."""

import re
import unicodedata
from types import MappingProxyType
from typing import Final

from sunset.evaluation.blocks import Block, Cell, Quantity, Report, plain

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
        "-": "{-}",  # two hyphens would become a dash
        "±": r"$\pm$",
        "↑": r"$\uparrow$",
        "↓": r"$\downarrow$",
        "−": "$-$",
        "→": r"$\rightarrow$",
        "…": r"\ldots{}",
        "\n": " ",
    }
)

_LONG: Final = 24
"""A name with more characters gets a separate line."""

_HEAD: Final = r"""\documentclass{article}
\usepackage{textcomp}
\usepackage{booktabs}
\usepackage[a4paper,margin=15mm]{geometry}
\begin{document}
"""


def as_latex(report: Report) -> str:
    """Return the tables and notes of a report as a LaTeX document."""
    notes = [rf"\item {escape_latex(note)}" for note in report.notes]
    listed = [r"\clearpage", r"\begin{itemize}\footnotesize", *notes, r"\end{itemize}", ""] if notes else []
    return "\n".join([_HEAD, *map(_table, report.blocks), *listed, r"\end{document}", ""])


def escape_latex(text: str) -> str:
    r"""Return `text` as LaTeX prints it, with `?` for unprintable characters.

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


def _heading(text: str) -> str:
    r"""Return the heading of a column.

    >>> _heading("t_down [s] ↓")
    '$\\mathit{t}_\\mathrm{down}$ [s] $\\downarrow$'
    """
    return re.sub(r"(\w+)\\_(\w+)", r"$\\mathit{\1}_\\mathrm{\2}$", escape_latex(text))


def _cell(cell: Cell) -> str:
    if isinstance(cell, Quantity):
        return f"${plain(cell)}$".replace("±", r"\pm").replace(" [", r"\;[")
    return escape_latex(plain(cell))


def _table(block: Block) -> str:
    out = [
        r"\begin{table*}[htbp]",
        r"\centering\footnotesize\setlength{\tabcolsep}{3pt}",
        rf"\caption{{{escape_latex(block.title)}.}}",
        rf"\label{{{block.label}}}\par\medskip",
        rf"\begin{{tabular}}{{lr{'c' * len(block.columns)}}}",
        r"\toprule",
        " & ".join(map(_heading, block.head)) + r" \\",
        r"\midrule",
    ]
    for label, *cells in block.rows(_cell):
        name = escape_latex(label)
        if len(label) > _LONG:
            out.append(rf"\multicolumn{{{len(block.head)}}}{{l}}{{{name}}} \\")
            name = ""
        out.append(" & ".join([name, *cells]) + r" \\")
    out += [r"\bottomrule", r"\end{tabular}", r"\end{table*}", ""]
    return "\n".join(out)
