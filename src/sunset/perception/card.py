"""The model card: a model's networks, results and thresholds, and the strengths of faults by their cost to it."""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from pathlib import Path
from typing import Annotated, Final, Literal

import msgspec
from msgspec import Meta

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError, ModelError
from sunset.files.schemas import convert, read_json

CARD_NAME: Final = "card.json"
SEVERITIES_NAME: Final = "severities.json"
"""The file in a model's folder."""
LOSSES: Final = (0.10, 0.25, 0.40, 0.55, 0.70)
"""Severity → the share of the model's healthy IoU that a fault costs."""
MAX_SIDE: Final = 4096
"""The largest width and height in pixels of the images that a model may take."""

_REMEDY: Final = "correct the card, or take another model"

_Text = Annotated[str, Meta(min_length=1)]
_FileName = Annotated[
    str, Meta(pattern=r"^(?!\.{0,2}$)[^/\\\x00]+$", description="a plain file name, without folders")
]
_Sha256 = Annotated[str, Meta(pattern="^[0-9a-f]{64}$", description="64 hexadecimal digits")]
_Side = Annotated[int, Meta(ge=1, le=MAX_SIDE)]
Strengths = Annotated[
    tuple[float | None, ...], Meta(min_length=5, max_length=5, description="a list of five")
]
"""A fault's strengths by severity; None where no strength is so severe."""


class Modality(IntEnum):
    """The sensors that a network looks at; the values are those in `system_interfaces/msg/FusionType`.

    >>> Modality.FUSION.key, Modality.DEPTH.needs_rgb, Modality.DEPTH.needs_depth
    ('fusion', False, True)
    """

    FUSION = 0
    RGB = 1
    DEPTH = 2

    @property
    def key(self) -> str:
        """The name in a model's card and files."""
        return self.name.lower()

    @property
    def needs_rgb(self) -> bool:
        """Whether the network takes a colour image."""
        return self is not Modality.DEPTH

    @property
    def needs_depth(self) -> bool:
        """Whether the network takes a depth image."""
        return self is not Modality.RGB


def check_name(name: str) -> None:
    """Check that a card can hold a model's name.

    Raises:
        InvalidInputError: it is empty, or UTF-8 cannot encode it.
    """
    if not name or name.encode("utf-8", "ignore").decode() != name:
        raise InvalidInputError(
            f"A model's name must be a text that UTF-8 can encode, got {name!r}: choose another one (--name)."
        )


@dataclass(frozen=True, slots=True)
class NetworkCard:
    """A network of a model.

    Attributes:
        file: its file name in the model's folder.
        sha256: checksum of the file, 64 hexadecimal digits.
        parameters: number of weights.
        temperature: divisor of the logits before the entropy's softmax.
        data: other files of its weights (ONNX's external data) with their checksums; a model's networks may share them.
    """

    file: _FileName
    sha256: _Sha256
    parameters: Annotated[int, Meta(ge=1, le=10**12)]
    temperature: Annotated[float, Meta(ge=1e-3, le=1e3)]
    data: Mapping[_FileName, _Sha256] = field(default_factory=dict)

    @property
    def files(self) -> dict[str, str]:
        """Checksums of the network's files, by name."""
        return {self.file: self.sha256, **self.data}

    @property
    def digest(self) -> str:
        """A checksum over all its files, 64 hexadecimal digits."""
        if not self.data:
            return self.sha256
        files = "".join(f"|{name}|{digest}" for name, digest in sorted(self.data.items()))
        return hashlib.sha256(f"{self.sha256}{files}".encode()).hexdigest()


@dataclass(frozen=True, slots=True)
class ModelCard:
    """The content of `card.json`.

    Attributes:
        name: the model's name.
        version: of the weights.
        description: one paragraph.
        height: of the input images, in pixels.
        width: of the input images, in pixels.
        classes: names, by class index.
        entropy_threshold: the F4 symptom holds where the entropy, averaged over 5 frames, exceeds it.
        sharpness_threshold: the F5 symptom holds where the sharpness, averaged over 5 frames, is below it.
        networks: by modality.
        training: its data, seeds, schedule and losses, as the training run wrote them.
        results: measurements on held-out data, as the training run wrote them.
        architecture: of the networks, such as "deeplabv3_resnet50"; empty if the card does not say.
        precision: of the stored weights, such as "float16 weights" or "int8"; empty if the card does not say.
        severities: fault → its strengths, by the share of the healthy IoU that they cost.
    """

    name: _Text
    version: _Text
    description: _Text
    height: _Side
    width: _Side
    classes: tuple[str, ...]
    entropy_threshold: Annotated[float, Meta(ge=0, le=1)]
    sharpness_threshold: Annotated[float, Meta(ge=0, le=64)]
    networks: Mapping[Modality, NetworkCard]
    training: Mapping[str, object] = field(default_factory=dict)
    results: Mapping[str, object] = field(default_factory=dict)
    architecture: str = ""
    precision: str = ""
    severities: Mapping[str, Strengths] = field(default_factory=dict)
    format: Literal[1] = 1

    @classmethod
    def read(cls, path: Path) -> "ModelCard":
        """Read and check a card.

        Raises:
            ModelError: it is missing or malformed.
        """
        raw, where = read_json(path, "The model card", ModelError), f"model card {path}"
        names = {modality.key: modality for modality in Modality}
        if isinstance(raw, dict) and isinstance(networks := raw.get("networks"), dict):
            if not networks or networks.keys() - names.keys():
                raise ModelError(
                    f"The networks in the {where} must be at least one, named {', '.join(sorted(names))} only, got "
                    f"{', '.join(sorted(networks)) or 'none'}; {_REMEDY}."
                )
            raw["networks"] = {names[name]: network for name, network in networks.items()}
        card = convert(raw, cls, f"the {where}", ModelError, remedy=_REMEDY)
        if card.classes != CLASSES:
            raise ModelError(
                f"The classes in the {where} must be the {len(CLASSES)} classes in their order; {_REMEDY}."
            )
        return card

    def to_json(self) -> dict[str, object]:
        """Return the content of `card.json`."""
        plain: dict[str, object] = msgspec.to_builtins(self)
        plain["networks"] = {
            modality.key: _without_empty(msgspec.to_builtins(network), "data")
            for modality, network in sorted(self.networks.items())
        }
        return {"format": self.format} | _without_empty(plain, "architecture", "precision", "severities")

    def write(self, folder: Path) -> None:
        """Write `card.json`, and `card.md` for reading, into the model's folder."""
        text = json.dumps(self.to_json(), indent=2, ensure_ascii=False, allow_nan=False)
        (folder / CARD_NAME).write_text(f"{text}\n", encoding="utf-8")
        (folder / "card.md").write_text(self.to_text(), encoding="utf-8")

    def to_text(self) -> str:
        """Return the card as text for reading, in Markdown."""
        lines = [f"# {self.name}, version {self.version}", "", self.description, ""]
        head = ("name", "version", "description", "format")
        lines += _section({key: value for key, value in self.to_json().items() if key not in head}, 2)
        return "\n".join(lines).rstrip() + "\n"


class SeverityTable(msgspec.Struct, frozen=True, kw_only=True):
    """The strengths of faults by severity, in a file beside the card.

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


def _without_empty(content: dict[str, object], *optional: str) -> dict[str, object]:
    return {key: value for key, value in content.items() if value or key not in optional}


def _section(content: Mapping[str, object], level: int) -> Iterator[str]:
    plain = {key: value for key, value in content.items() if not isinstance(value, Mapping)}
    for key, value in plain.items():
        yield f"- {_words(key)}: {_cell(value)}"
    if plain:
        yield ""
    for key, value in content.items():
        if isinstance(value, Mapping) and value:
            yield f"{'#' * level} {_words(key).capitalize()}"
            yield ""
            yield from _table(value) if _is_table(value) else _section(value, level + 1)


def _is_table(content: Mapping[str, object]) -> bool:
    return all(
        isinstance(row, Mapping) and not any(isinstance(cell, Mapping) for cell in row.values())
        for row in content.values()
    )


def _table(rows: Mapping[str, object]) -> Iterator[str]:
    maps = {key: row for key, row in rows.items() if isinstance(row, Mapping)}
    columns = list(dict.fromkeys(str(column) for row in maps.values() for column in row))
    yield "| | " + " | ".join(_words(column) for column in columns) + " |"
    yield "|---|" + "---|" * len(columns)
    for key, row in maps.items():
        yield f"| {_words(key)} | " + " | ".join(_cell(row.get(column, "")) for column in columns) + " |"
    yield ""


def _words(key: str) -> str:
    return key.replace("_", " ")


def _cell(value: object) -> str:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(_cell(item) for item in value)
    return f"{value:.4g}" if isinstance(value, float) else str(value)
