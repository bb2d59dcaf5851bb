"""The model card: what a model is, what it was measured to do, and the thresholds that belong to it."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Final

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError, ModelError
from sunset.input_files import read_text
from sunset.perception.card_text import card_text
from sunset.perception.modality import Modality
from sunset.texts import printable_json

__all__ = ["CARD_FORMAT", "CARD_NAME", "MAX_SIDE", "ModelCard", "NetworkCard", "check_name"]

CARD_NAME: Final = "card.json"
CARD_FORMAT: Final = 1
MAX_SIDE: Final = 4096
"""The largest width and height in pixels of the images that a model may take."""

_SHA256_DIGITS: Final = 64


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

    file: str
    sha256: str
    parameters: int
    temperature: float
    data: Mapping[str, str] = field(default_factory=dict)

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
    """

    name: str
    version: str
    description: str
    height: int
    width: int
    classes: tuple[str, ...]
    entropy_threshold: float
    sharpness_threshold: float
    networks: Mapping[Modality, NetworkCard]
    training: Mapping[str, object] = field(default_factory=dict)
    results: Mapping[str, object] = field(default_factory=dict)
    architecture: str = ""
    precision: str = ""

    @classmethod
    def read(cls, path: Path) -> "ModelCard":
        """Read and check a card.

        Raises:
            ModelError: it is missing, no JSON, lacks something, or has what cannot be written again.
        """
        try:
            raw = json.loads(read_text(path))
            json.dumps(raw, ensure_ascii=False, allow_nan=False).encode()  # as it is written again
            raw = printable_json(raw)
        except FileNotFoundError:
            raise ModelError(f"The model card {path} is missing.") from None
        except OSError as error:
            raise ModelError(f"The model card {path} cannot be read: {error.strerror}.") from error
        except (RecursionError, ValueError) as error:
            raise ModelError(f"The model card {path} cannot be read as JSON: {error}.") from error
        return _parse(_Fields(raw, f"model card {path}"))

    def to_json(self) -> dict[str, object]:
        """Return the object that `card.json` holds."""
        networks = {
            modality.key: {
                "file": network.file,
                "sha256": network.sha256,
                "parameters": network.parameters,
                "temperature": network.temperature,
                **({"data": dict(sorted(network.data.items()))} if network.data else {}),
            }
            for modality, network in sorted(self.networks.items())
        }
        kind = {"architecture": self.architecture, "precision": self.precision}
        return {
            "format": CARD_FORMAT,
            "name": self.name,
            "version": self.version,
            "description": self.description,
            **{key: value for key, value in kind.items() if value},
            "height": self.height,
            "width": self.width,
            "classes": list(self.classes),
            "entropy_threshold": self.entropy_threshold,
            "sharpness_threshold": self.sharpness_threshold,
            "networks": networks,
            "training": dict(self.training),
            "results": dict(self.results),
        }

    def write(self, folder: Path) -> None:
        """Write `card.json`, and `card.md` for reading, into the model's folder."""
        text = json.dumps(self.to_json(), indent=2, ensure_ascii=False, allow_nan=False)
        (folder / CARD_NAME).write_text(f"{text}\n", encoding="utf-8")
        (folder / "card.md").write_text(self.to_text(), encoding="utf-8")

    def to_text(self) -> str:
        """Return the card as text for reading, in Markdown."""
        return card_text(self.to_json())


class _Fields:
    """Typed access to the fields of a JSON object, with errors that say where."""

    def __init__(self, raw: object, where: str) -> None:
        if not isinstance(raw, dict):
            raise ModelError(f"The {where} must be a JSON object, got {type(raw).__name__}.")
        self._raw = raw
        self._where = where

    def wrong(self, key: str, expected: str) -> ModelError:
        got = repr(self._raw[key]) if key in self._raw else "nothing"
        return ModelError(f"The {self._where} must have {expected} as {key!r}, got {got}.")

    def text(self, key: str) -> str:
        value = self._raw.get(key)
        if not isinstance(value, str) or not value:
            raise self.wrong(key, "a text")
        return value

    def optional_text(self, key: str) -> str:
        return self.text(key) if key in self._raw else ""

    def file_name(self, key: str) -> str:
        value = self.text(key)
        if not _is_file_name(value):
            raise self.wrong(key, "a plain file name")
        return value

    def sha256(self, key: str) -> str:
        value = self.text(key)
        if not _is_sha256(value):
            raise self.wrong(key, "64 hexadecimal digits")
        return value

    def checksums(self, key: str) -> dict[str, str]:
        """Return an optional object of checksums by file name."""
        value = self.object(key) if key in self._raw else {}
        if not all(_is_file_name(name) and _is_sha256(digest) for name, digest in value.items()):
            raise self.wrong(key, "plain file names with 64 hexadecimal digits each")
        return {name: str(digest) for name, digest in value.items()}

    def whole(self, key: str, most: int = 10**12) -> int:
        value = self._raw.get(key)
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= most:
            raise self.wrong(key, f"a whole number from 1 to {most}")
        return value

    def number(self, key: str, low: float, high: float) -> float:
        value = self._raw.get(key)
        if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
            raise self.wrong(key, f"a number from {low:g} to {high:g}")
        return float(value)

    def object(self, key: str) -> "dict[str, object]":
        value = self._raw.get(key)
        if not isinstance(value, dict):
            raise self.wrong(key, "an object")
        return value

    def classes(self, key: str) -> tuple[str, ...]:
        if self._raw.get(key) != list(CLASSES):
            raise self.wrong(key, f"the list of the {len(CLASSES)} classes in their order")
        return CLASSES


def _is_file_name(value: str) -> bool:
    return value not in ("", ".", "..") and not set(value) & set("/\\\0")


def _is_sha256(value: object) -> bool:
    return (
        isinstance(value, str) and len(value) == _SHA256_DIGITS and not set(value) - set("0123456789abcdef")
    )


def _network(raw: object, where: str) -> NetworkCard:
    fields = _Fields(raw, where)
    return NetworkCard(
        file=fields.file_name("file"),
        sha256=fields.sha256("sha256"),
        parameters=fields.whole("parameters"),
        temperature=fields.number("temperature", 1e-3, 1e3),
        data=MappingProxyType(fields.checksums("data")),
    )


def _parse(fields: _Fields) -> ModelCard:
    if fields.whole("format") != CARD_FORMAT:
        raise fields.wrong("format", f"{CARD_FORMAT}, the only format known,")
    networks = {}
    known = {modality.key: modality for modality in Modality}
    for key, raw in fields.object("networks").items():
        if key not in known:
            raise fields.wrong("networks", f"networks named {', '.join(sorted(known))} only")
        networks[known[key]] = _network(raw, f"entry of network {key!r} in the model card")
    if not networks:
        raise fields.wrong("networks", "at least one network")
    return ModelCard(
        name=fields.text("name"),
        version=fields.text("version"),
        description=fields.text("description"),
        height=fields.whole("height", MAX_SIDE),
        width=fields.whole("width", MAX_SIDE),
        classes=fields.classes("classes"),
        entropy_threshold=fields.number("entropy_threshold", 0, 1),
        sharpness_threshold=fields.number("sharpness_threshold", 0, 64),
        networks=MappingProxyType(networks),
        training=MappingProxyType(fields.object("training")),
        results=MappingProxyType(fields.object("results")),
        architecture=fields.optional_text("architecture"),
        precision=fields.optional_text("precision"),
    )
