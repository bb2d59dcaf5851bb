"""The model card: what a model is, what it was measured to do, and the thresholds that belong to it."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Final, Literal

import msgspec
from msgspec import Meta

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError, ModelError
from sunset.perception.card_text import card_text
from sunset.perception.modality import Modality
from sunset.schemas import convert, read_json

CARD_NAME: Final = "card.json"
CARD_FORMAT: Final = 1
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
"""Of a fault, by severity; None where no strength is so severe."""


def check_name(name: str) -> None:
    """Refuse a model's name that its card cannot hold, before the model is made.

    Raises:
        InvalidInputError: it is empty, or UTF-8 cannot encode it.
    """
    if not name or name.encode("utf-8", "ignore").decode() != name:
        raise InvalidInputError(
            f"A model's name must be a text that UTF-8 can encode, got {name!r}: choose another one (--name)."
        )


@dataclass(frozen=True, slots=True)
class NetworkCard:
    """One network of a model.

    Attributes:
        file: its file name in the model's folder.
        sha256: checksum of the file, 64 hexadecimal digits.
        parameters: number of weights.
        temperature: its logits are divided by this before the entropy's softmax.
        data: files beside it that hold its weights (ONNX's external data), with their checksums. Networks of
            one model may share them.
    """

    file: _FileName
    sha256: _Sha256
    parameters: Annotated[int, Meta(ge=1, le=10**12)]
    temperature: Annotated[float, Meta(ge=1e-3, le=1e3)]
    data: Mapping[_FileName, _Sha256] = field(default_factory=dict)

    @property
    def files(self) -> dict[str, str]:
        """Checksums of all files that the network consists of, by name."""
        return {self.file: self.sha256, **self.data}

    @property
    def digest(self) -> str:
        """What tells this network from every other: a checksum over all its files, 64 hexadecimal digits."""
        if not self.data:
            return self.sha256
        files = "".join(f"|{name}|{digest}" for name, digest in sorted(self.data.items()))
        return hashlib.sha256(f"{self.sha256}{files}".encode()).hexdigest()


@dataclass(frozen=True, slots=True)
class ModelCard:
    """What `card.json` says.

    Attributes:
        name: the model's name.
        version: of the weights.
        description: one paragraph.
        height: of the images that it takes, in pixels.
        width: of the images that it takes, in pixels.
        classes: names, by class index.
        entropy_threshold: the F4 symptom holds where the entropy, averaged over 5 frames, exceeds it.
        sharpness_threshold: the F5 symptom holds where the sharpness, averaged over 5 frames, is below it.
        networks: by modality.
        training: how it was trained (data, seeds, schedule, losses), as the training run wrote it.
        results: what it was measured to do on held-out data, as the training run wrote it.
        architecture: of the networks, such as "deeplabv3_resnet50"; empty if the card does not say.
        precision: of the stored weights, such as "float16 weights" or "int8"; empty if the card does not say.
        severities: fault → the strengths that cost so much of the healthy IoU as each severity means.
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
    format: Literal[1] = CARD_FORMAT

    @classmethod
    def read(cls, path: Path) -> "ModelCard":
        """Read and check a card.

        Raises:
            ModelError: it is missing, no JSON, lacks something, or has what cannot be written again.
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
        """Return the object that `card.json` holds."""
        plain: dict[str, object] = msgspec.to_builtins(self)
        networks = {
            modality.key: {
                key: value for key, value in msgspec.to_builtins(network).items() if key != "data" or value
            }
            for modality, network in sorted(self.networks.items())
        }
        return {"format": CARD_FORMAT} | {
            key: value
            for key, value in (plain | {"networks": networks}).items()
            if value or key not in ("architecture", "precision", "severities")
        }

    def write(self, folder: Path) -> None:
        """Write `card.json`, and `card.md` for reading, into the model's folder."""
        text = json.dumps(self.to_json(), indent=2, ensure_ascii=False, allow_nan=False)
        (folder / CARD_NAME).write_text(f"{text}\n", encoding="utf-8")
        (folder / "card.md").write_text(self.to_text(), encoding="utf-8")

    def to_text(self) -> str:
        """Return the card as text for reading, in Markdown."""
        return card_text(self.to_json())
