"""The strengths of faults by their cost to a model, in a file beside its card."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

import msgspec

from sunset.errors import ModelError
from sunset.files.schemas import convert, read_json
from sunset.perception.card import ModelCard, Strengths

SEVERITIES_NAME: Final = "severities.json"
"""The file in a model's folder."""

LOSSES: Final = (0.10, 0.25, 0.40, 0.55, 0.70)
"""Severity → the share of the model's healthy IoU that a fault costs."""


class SeverityTable(msgspec.Struct, frozen=True, kw_only=True):
    """The strengths of faults by severity.

    Attributes:
        model: the model's name.
        version: of its weights.
        frames: number of frames on which the curves were measured.
        strengths: by fault, for each of `LOSSES`; None where no strength costs so much.
    """

    model: str
    version: str
    frames: int
    strengths: Mapping[str, Strengths]


def with_severities(card: ModelCard, folder: Path) -> ModelCard:
    """Return a card with the severities in the file beside it, if there is such a file.

    Raises:
        ModelError: the file is damaged, or of another version of the model.
    """
    file = folder / SEVERITIES_NAME
    if not file.exists():
        return card
    remedy = "make it again with 'sunset models curves', or remove it"
    content = read_json(file, "The file", ModelError)
    table = convert(content, SeverityTable, f"the file {file}", ModelError, remedy=remedy)
    if (table.model, table.version) != (card.name, card.version):
        raise ModelError(
            f"The file {file} must be of {card.name}, version {card.version}, got {table.model}, version "
            f"{table.version}; {remedy}."
        )
    return replace(card, severities=table.strengths)
