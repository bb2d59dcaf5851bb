"""Checking and loading models."""

import hashlib
import os
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from onnxruntime import InferenceSession

from sunset.errors import ModelError
from sunset.files.inputs import read_bytes
from sunset.perception.card import CARD_NAME, Modality, ModelCard, with_severities
from sunset.perception.engine import open_session
from sunset.perception.installed import find_model, missing_model_error
from sunset_ros.texts import shown

_LARGEST: Final = 2**31
"""The greatest size of an ONNX file in bytes."""

_sessions: dict[tuple[object, ...], InferenceSession] = {}
_sessions_lock = threading.Lock()


@dataclass(frozen=True, slots=True)
class Model:
    """A model whose files have been checked against its card."""

    folder: Path
    card: ModelCard

    def __repr__(self) -> str:
        return f"Model({self.card.name!r}, version {self.card.version!r}, in {str(self.folder)!r})"

    def session(self, modality: Modality, *, device: str = "cpu") -> InferenceSession:
        """Return the network's ONNX Runtime session, made once per process and device, "cpu" or "cuda".

        Raises:
            ModelError: the model lacks this network, or its file cannot be run.
        """
        if modality not in self.card.networks:
            has = ", ".join(sorted(known.key for known in self.card.networks))
            raise ModelError(f"The model {self.card.name!r} has no network {modality.key!r}, only {has}.")
        network = self.card.networks[modality]
        with _sessions_lock:
            key = (network.digest, modality, self.card.height, self.card.width, device)
            if key not in _sessions:
                path = self.folder / network.file
                data = {name: _verified(self.folder / name, digest) for name, digest in network.files.items()}
                content = data.pop(network.file)
                session = open_session(content, data, name=str(path), device=device)
                _check_signature(session, self.card, modality, path)
                _sessions[key] = session
            return _sessions[key]


def load_model(name_or_path: str | Path) -> Model:
    """Load a model and check its files against its card.

    Args:
        name_or_path: a name of `list_models()`, or a folder with `card.json` and its networks.

    Raises:
        ModelError: the model does not exist, a file is missing or differs from the card, or the card is malformed.
    """
    if not isinstance(name_or_path, str | Path):
        raise ModelError(f"A model must be a name or a folder, got {shown(name_or_path)}.")
    folder = find_model(str(name_or_path)) or Path(name_or_path)
    if not os.path.isdir(folder):  # noqa: PTH112  Path.is_dir raises where a name is too long
        raise missing_model_error(str(name_or_path))
    card = with_severities(ModelCard.read(folder / CARD_NAME), folder)
    files = {
        file for network in card.networks.values() for file in network.files.items()
    }  # some may be shared
    for name, digest in sorted(files):
        _verified(folder / name, digest)
    return Model(folder, card)


def _verified(path: Path, expected: str) -> bytes:
    """Return the content of a file, after a check of its checksum."""
    try:
        content = read_bytes(path, _LARGEST)
    except OSError as error:
        raise ModelError(
            f"The file {path}, named on the model's card, cannot be read: {error.strerror}."
        ) from error
    if (digest := hashlib.sha256(content).hexdigest()) != expected:
        raise ModelError(
            f"The file {path} is not the one on the model's card: expected SHA-256 {expected[:12]}…, got "
            f"{digest[:12]}…; it is damaged or was exchanged."
        )
    return content


def _check_signature(session: InferenceSession, card: ModelCard, modality: Modality, path: Path) -> None:
    expected = {}
    if modality.needs_rgb:
        expected["bgr"] = ("tensor(uint8)", [card.height, card.width, 3])
    if modality.needs_depth:
        expected["depth"] = ("tensor(uint16)", [card.height, card.width])
    got = {value.name: (value.type, value.shape) for value in session.get_inputs()}
    if got != expected:
        raise ModelError(f"The network {path} must take {_words(expected)}, but takes {_words(got)}.")
    outputs = {value.name: (value.type, value.shape) for value in session.get_outputs()}
    if missing := {"logits", "labels", "entropy"} - set(outputs):
        raise ModelError(f"The network {path} lacks the output {', '.join(sorted(missing))}.")
    expected = {"labels": ("tensor(uint8)", [card.height, card.width]), "entropy": ("tensor(float)", [])}
    got = {name: outputs[name] for name in expected}
    if got != expected:
        raise ModelError(f"The network {path} must give {_words(expected)}, but gives {_words(got)}.")


def _words(signature: dict[str, tuple[str, list[int]]]) -> str:
    return " and ".join(f"{name} {kind} {shape}" for name, (kind, shape) in signature.items()) or "nothing"
