"""Finding, checking and loading models."""

import hashlib
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import onnxruntime
from onnxruntime.capi import onnxruntime_pybind11_state as _runtime_errors

from sunset.errors import ModelError
from sunset.perception.card import CARD_NAME, ModelCard
from sunset.perception.modality import Modality

__all__ = ["Model", "list_models", "load_model"]

_MODELS: Final = Path(__file__).parent / "models"

RUNTIME_ERRORS: Final = tuple(
    getattr(_runtime_errors, name)
    for name in (
        "EPFail",
        "EngineError",
        "Fail",
        "InvalidArgument",
        "InvalidGraph",
        "InvalidProtobuf",
        "NoModel",
        "NoSuchFile",
        "NotImplemented",
        "RuntimeException",
    )
)
"""What ONNX Runtime raises; the classes have no base of their own."""

_sessions: dict[tuple[str, Modality, int, int, int], Any] = {}
_sessions_lock = threading.Lock()


@dataclass(frozen=True, slots=True)
class Model:
    """A model whose files have been checked against its card."""

    folder: Path
    card: ModelCard

    def __repr__(self) -> str:
        """Return name, version and folder."""
        return f"Model({self.card.name!r}, version {self.card.version!r}, in {str(self.folder)!r})"

    def session(self, modality: Modality, threads: int = 1) -> Any:
        """Return the network's ONNX Runtime session, made once per process and number of threads.

        Raises:
            ModelError: the model has no such network, or its file is not one that can be run.
        """
        if modality not in self.card.networks:
            has = ", ".join(sorted(known.key for known in self.card.networks))
            raise ModelError(f"The model {self.card.name!r} has no network {modality.key!r}, only {has}.")
        network = self.card.networks[modality]
        with _sessions_lock:
            key = (network.digest, modality, self.card.height, self.card.width, threads)
            if key not in _sessions:
                session = _open(self.folder / network.file, threads)
                _check_signature(session, self.card, modality, self.folder / network.file)
                _sessions[key] = session
            return _sessions[key]


def list_models() -> tuple[str, ...]:
    """Return the names of the models that come with the package."""
    if not _MODELS.is_dir():
        return ()
    return tuple(sorted(path.parent.name for path in _MODELS.glob(f"*/{CARD_NAME}")))


def load_model(name_or_path: str | Path) -> Model:
    """Load a model and check its files against its card.

    Args:
        name_or_path: a name of `list_models()`, or a folder with `card.json` and its networks. A text
            with a path separator, or one that is no such name, is taken as a folder.

    Raises:
        ModelError: there is no such model, a file is missing or not the one on the card, or the card is
            malformed.
    """
    folder = _MODELS / name_or_path if str(name_or_path) in list_models() else Path(name_or_path)
    if not folder.is_dir():
        raise ModelError(
            f"There is no model {str(name_or_path)!r}: expected a folder with a {CARD_NAME}, or one of the "
            f"names {', '.join(list_models()) or '(none installed)'}."
        )
    card = ModelCard.read(folder / CARD_NAME)
    for name, expected in _files(card).items():
        path = folder / name
        digest = _sha256(path)
        if digest != expected:
            raise ModelError(
                f"The file {path} is not the one on the model's card: expected SHA-256 "
                f"{expected[:12]}…, got {digest[:12]}…; it is damaged or was exchanged."
            )
    return Model(folder, card)


def _files(card: ModelCard) -> dict[str, str]:
    """Return the checksums of all files of a model, by name: networks may share some."""
    files: dict[str, str] = {}
    for network in card.networks.values():
        for name, digest in network.files.items():
            if files.setdefault(name, digest) != digest:
                raise ModelError(
                    f"The model card of {card.name!r} gives two checksums for the file {name!r}."
                )
    return files


def _sha256(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise ModelError(
            f"The file {path}, named on the model's card, cannot be read: {error.strerror}."
        ) from error


def _open(path: Path, threads: int) -> Any:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.execution_mode = onnxruntime.ExecutionMode.ORT_SEQUENTIAL
    options.use_deterministic_compute = True
    options.log_severity_level = 4  # what goes wrong is raised, and must not be printed as well
    # Idle threads would spin, and take a core from the other workers of a bench.
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    try:
        return onnxruntime.InferenceSession(path, options, providers=["CPUExecutionProvider"])
    except RUNTIME_ERRORS as error:
        raise ModelError(
            f"The network {path} is no ONNX model that can be run: {_one_line(error)}."
        ) from error


def _check_signature(session: Any, card: ModelCard, modality: Modality, path: Path) -> None:
    expected = {}
    if modality.needs_rgb:
        expected["bgr"] = ("tensor(uint8)", [card.height, card.width, 3])
    if modality.needs_depth:
        expected["depth"] = ("tensor(uint16)", [card.height, card.width])
    got = {value.name: (value.type, value.shape) for value in session.get_inputs()}
    if got != expected:
        raise ModelError(f"The network {path} must take {_words(expected)}, but takes {_words(got)}.")
    missing = {"logits", "labels", "entropy"} - {value.name for value in session.get_outputs()}
    if missing:
        raise ModelError(f"The network {path} lacks the output {', '.join(sorted(missing))}.")


def _words(signature: dict[str, tuple[str, list[int]]]) -> str:
    return " and ".join(f"{name} {kind} {shape}" for name, (kind, shape) in signature.items()) or "nothing"


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()).rstrip(".")
