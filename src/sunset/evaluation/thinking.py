"""The table of what the decisions of managing systems have cost."""

from collections.abc import Mapping, Sequence
from typing import Final

from sunset.evaluation.formats import Block, Column, Line
from sunset.evaluation.summary import SystemRow
from sunset.texts.sentences import listed

_COLUMNS: Final[Mapping[str, Column]] = {
    "think_s": Column("thinking [s] ↓", "time of a run by which thinking delayed adaptations"),
    "tokens_in": Column("tokens in ↓", "of a run, to language models, as the managing system says"),
    "tokens_out": Column("tokens out ↓", "likewise, from language models"),
    "price": Column("price ↓", "of a run's decisions, as the managing system says, in a currency of its own"),
}
_MODELS: Final = Column("asked", "the language models, as the managing system says")


def thinking_block(rows: Sequence[SystemRow]) -> Block:
    """Return the table of the costs of thinking, without columns that are 0 everywhere; empty without costs."""
    paying = [row for row in rows if any(map(row.total, _COLUMNS))]
    names = [name for name in _COLUMNS if any(row.total(name) for row in paying)]
    asked = [dict.fromkeys(model for run in row.valid for model in run.models_asked) for row in paying]
    lines = [
        Line(
            row.system,
            str(row.runs),
            [
                *(_mean(row, name) for name in names),
                *([listed(list(models)) or None] if any(asked) else []),
            ],
        )
        for row, models in zip(paying, asked, strict=True)
    ]
    columns = [*map(_COLUMNS.__getitem__, names), *([_MODELS] if any(asked) else [])]
    return Block("The costs of thinking", columns, lines, "tab:sunset-thinking")


def _mean(row: SystemRow, name: str) -> str | None:
    """Return the mean of a figure over the valid runs, in which runs without costs count 0."""
    return f"{row.total(name) / row.runs:.4g}" if row.total(name) else None
