"""A report before it has a format, as tables of cells and notes, and as text, LaTeX and HTML."""

import re
import textwrap
import unicodedata
from collections.abc import Callable, Sequence
from html import escape
from importlib.resources import files
from string import Template
from typing import Final, NamedTuple

from rich.cells import cell_len

from sunset.texts.tables import aligned, table_width
from sunset_ros.texts import printable

_WIDTH: Final = 100
_GAP: Final = 2
_LEAST: Final = 11  # the least width of the first column

PAPER_LABEL: Final = "tab:sunset"
"""The label of the paper's table."""
PAGE_TITLE: Final = "SUNSET: comparison of managing systems"
_ESCAPES: Final = {
    **{character: rf"\{character}" for character in "{}$&#%_"},
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

_LONG: Final = 24  # a name with more characters gets a separate line in LaTeX

_HEAD: Final = r"""\documentclass{article}
\usepackage{textcomp}
\usepackage{booktabs}
\usepackage[a4paper,margin=15mm]{geometry}
\begin{document}
"""


class Quantity(NamedTuple):
    """A mean with a standard deviation, a confidence interval, or neither."""

    mean: float
    std: float | None = None
    interval: tuple[float, float] | None = None


class Link(NamedTuple):
    """A text that leads to another file in a page."""

    text: str
    address: str


Cell = Quantity | Link | str | None
"""The content of a cell; None is N/A."""


def plain(cell: Cell) -> str:
    """Return a cell as text.

    >>> plain(Quantity(-0.0012, 0.02)), plain(Quantity(0.5, interval=(0.1, 1.234))), plain(None)
    ('0.00 ± 0.02', '0.50 [0.10, 1.23]', 'N/A')
    """
    match cell:
        case None:
            return "N/A"
        case Link(text, _):
            return text
        case Quantity(mean, std, interval):
            deviation = "" if std is None else f" ± {std:.2f}"
            low, high = interval or (mean, mean)
            return f"{mean:z.2f}{deviation}" + (f" [{low:z.2f}, {high:z.2f}]" if interval else "")
    return cell


class Column(NamedTuple):
    """A figure's column: its heading, in which `_` stands before an index, and its meaning."""

    text: str
    meaning: str


class Line(NamedTuple):
    """A line of a table; `runs` is empty where a number makes no sense."""

    label: str
    runs: str
    cells: Sequence[Cell]


class Block(NamedTuple):
    """A table: its title, columns and lines, and the label by which LaTeX refers to it."""

    title: str
    columns: Sequence[Column]
    lines: Sequence[Line]
    label: str

    @property
    def head(self) -> list[str]:
        """The headings of all columns."""
        return ["system", "runs", *(column.text for column in self.columns)]

    def rows(self, shown: Callable[[Cell], str] = plain) -> list[list[str]]:
        """Return the texts of all lines, with cells as `shown` returns them."""
        return [[line.label, line.runs, *map(shown, line.cells)] for line in self.lines]


class Report(NamedTuple):
    """The content of a report in any format: tables with lines, and notes."""

    blocks: Sequence[Block]
    notes: Sequence[str]


def as_text(report: Report) -> str:
    """Return a report as text; a name that is too long for its column gets a separate line."""
    parts = [_table(block) for block in report.blocks]
    parts.append("\n".join(map(wrapped, report.notes)))
    return "\n\n".join(parts) + "\n"


def wrapped(text: str, indent: str = "  ") -> str:
    """Return a text in lines for a terminal, all but the first with an indent."""
    return textwrap.fill(text, _WIDTH, subsequent_indent=indent, break_on_hyphens=False)


def _table(block: Block) -> str:
    rows = [block.head, *block.rows()]
    room = max(_WIDTH - table_width([row[1:] for row in rows]) - _GAP, _LEAST)
    above = ["" if cell_len(row[0]) <= room else f"{short_name(row[0], _WIDTH)}\n" for row in rows]
    rows = [["" if name else label, *others] for name, (label, *others) in zip(above, rows, strict=True)]
    head, *lines = (
        name + line
        for name, line in zip(above, aligned(rows, left={0, *range(2, len(block.head))}), strict=True)
    )
    rule = "─" * table_width(rows)
    return "\n".join([f"{block.title}\n", head, rule, *lines, rule])


def short_name(text: str, longest: int = 24) -> str:
    """Return a name without its middle if it has many characters.

    >>> short_name("a-managing-system-with-a-long-name")
    'a-managing-s…a-long-name'
    """
    text, half = printable(text), longest // 2
    return text if len(text) <= longest else f"{text[:half]}…{text[1 - half :]}"


def as_latex(report: Report) -> str:
    """Return the tables and notes of a report as a LaTeX document."""
    notes = [rf"\item {escape_latex(note)}" for note in report.notes]
    listed = [r"\clearpage", r"\begin{itemize}\footnotesize", *notes, r"\end{itemize}", ""] if notes else []
    return "\n".join([_HEAD, *map(_latex_table, report.blocks), *listed, r"\end{document}", ""])


def escape_latex(text: str) -> str:
    r"""Return `text` as LaTeX prints it, with `?` for unprintable characters.

    >>> escape_latex("my_manager.py:A&B")
    'my\\_manager.py:A\\&B'
    """
    known = [char if char in _ESCAPES else unicodedata.normalize("NFKD", char)[0] for char in text]
    return "".join(_ESCAPES.get(char, char if " " <= char <= "~" else "?") for char in known)


def _heading(text: str) -> str:
    return re.sub(r"(\w+)\\_(\w+)", r"$\\mathit{\1}_\\mathrm{\2}$", escape_latex(text))


def _latex_cell(cell: Cell) -> str:
    if isinstance(cell, Quantity):
        return f"${plain(cell)}$".replace("±", r"\pm").replace(" [", r"\;[")
    return escape_latex(plain(cell))


def _latex_table(block: Block) -> str:
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
    for label, *cells in block.rows(_latex_cell):
        name = escape_latex(label)
        if len(label) > _LONG:
            out.append(rf"\multicolumn{{{len(block.head)}}}{{l}}{{{name}}} \\")
            name = ""
        out.append(" & ".join([name, *cells]) + r" \\")
    out += [r"\bottomrule", r"\end{tabular}", r"\end{table*}", ""]
    return "\n".join(out)


def as_html(report: Report, more: str = "", figures: str = "", *, title: str = PAGE_TITLE) -> str:
    """Return a report as a page of HTML, with `more` HTML behind its tables, and `figures` before the paper's."""
    parts = [_html_table(block) for block in report.blocks]
    labels = [block.label for block in report.blocks]
    parts.insert(labels.index(PAPER_LABEL) if PAPER_LABEL in labels else len(parts), figures)
    tables = "\n".join(filter(None, parts))
    columns = dict.fromkeys(column for block in report.blocks for column in block.columns)
    meanings = "\n".join(f"<dt>{escape(text)}</dt><dd>{escape(meaning)}</dd>" for text, meaning in columns)
    notes = "\n".join(f"<li>{escape(note)}</li>" for note in report.notes)
    page = Template(files("sunset.evaluation").joinpath("report.html").read_text(encoding="utf-8"))
    return page.substitute(title=title, tables=tables, more=more, notes=notes, meanings=meanings)


def _html_table(block: Block) -> str:
    heads = "".join(
        f'<th scope="col" title="{escape(column.meaning)}">{escape(column.text)}</th>'
        for column in block.columns
    )
    body = "\n".join(
        f'<tr><th scope="row">{escape(label)}</th><td class="runs">{escape(runs)}</td>'
        + "".join(f"<td>{cell}</td>" for cell in cells)
        + "</tr>"
        for label, runs, *cells in block.rows(_html_cell)
    )
    return (
        f'<h2>{escape(block.title)}</h2>\n<div class="scroll">\n<table>\n<thead><tr>'
        f'<th scope="col">system</th><th scope="col" class="runs">runs</th>{heads}</tr></thead>'
        f"\n<tbody>\n{body}\n</tbody>\n</table>\n</div>"
    )


def _html_cell(cell: Cell) -> str:
    text = escape(plain(cell))
    return f'<a href="{escape(cell.address)}">{text}</a>' if isinstance(cell, Link) else text
