"""Finding, checking and loading models, with settings of ONNX Runtime for results that repeat bit by bit.

A distribution offers a model by an entry point of the group `sunset.models`: its name is the model's, its value the
top-level package whose folder holds the card and the networks. That package is not executed.
"""

import hashlib
import os
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Final

import onnxruntime
from onnxruntime import InferenceSession
from onnxruntime.capi import onnxruntime_pybind11_state as _runtime_errors

from sunset.errors import InvalidInputError, MissingExtraError, ModelError
from sunset.files.inputs import read_bytes
from sunset.perception.card import CARD_NAME, Modality, ModelCard, with_severities
from sunset_ros.texts import shown, suggestion

OFFERED: Final[Mapping[str, str]] = {"reference": "pip install ./models/reference"}
"""Models of other distributions, and the command that installs each in a clone of SUNSET's repository."""

_GROUP: Final = "sunset.models"
_SHIPPED: Final = Path(__file__).parent / "models"


def list_models() -> tuple[str, ...]:
    """Return the names of the models that are installed, sorted."""
    return tuple(sorted({*_shipped(), *entry_points(group=_GROUP).names}))


def find_model(name: str) -> Path | None:
    """Return the folder of an installed model, or None; the package's own models come first.

    Raises:
        ModelError: the model's distribution lacks the files.
    """
    if name in _shipped():
        return _SHIPPED / name
    for point in entry_points(group=_GROUP, name=name):
        if folder := _folder(point):
            return folder
        owner = repr(point.dist.name if point.dist else "?")
        raise ModelError(
            f"The model {name!r} of the installed distribution {owner} is broken: expected the "
            f"top-level package {point.value!r} with a {CARD_NAME}, found none; install it again."
        )
    return None


def missing_model_error(name: str) -> ModelError:
    """Return the error for a name of neither an installed model nor a folder."""
    if name in OFFERED:
        return ModelError(
            f"The model {name!r} is not installed: in a clone of SUNSET's repository, run {OFFERED[name]!r}."
        )
    installed = list_models()
    hint = suggestion(name, (*installed, *OFFERED))
    return ModelError(
        f"There is no model {name!r}: {hint}name a folder with a {CARD_NAME} or one of {', '.join(installed)}."
    )


def is_installed(folder: Path) -> bool:
    """Return whether a folder holds an installed model, which only installers change."""
    shipped = (_SHIPPED / name for name in _shipped())
    others = (_folder(point) for point in entry_points(group=_GROUP))
    return folder.resolve() in {place.resolve() for place in (*shipped, *others) if place is not None}


def _shipped() -> list[str]:
    return [path.parent.name for path in _SHIPPED.glob(f"*/{CARD_NAME}")]


def _folder(point: EntryPoint) -> Path | None:
    """Return the folder that an entry point names, if it has a card."""
    try:
        # of a name with dots, the parent packages would be imported
        spec = find_spec(point.value) if point.value.isidentifier() else None
    except (ImportError, ValueError):
        return None
    places = map(Path, (spec and spec.submodule_search_locations) or ())
    return next((place for place in places if (place / CARD_NAME).is_file()), None)


DEVICES: Final = ("cpu", "cuda", "auto")
"""The choices of a device; "auto" is "cuda" where the engine offers it, else "cpu"."""

RUNTIME_ERRORS: Final = tuple(
    kind for kind in vars(_runtime_errors).values() if isinstance(kind, type) and issubclass(kind, Exception)
)
"""The exceptions of ONNX Runtime, which have no common base."""

_CUDA: Final = "CUDAExecutionProvider"
_PROVIDERS: Final[dict[str, list[object]]] = {
    "cpu": ["CPUExecutionProvider"],
    # Neither rounding to 19 bits nor algorithms that are chosen by timing them.
    "cuda": [(_CUDA, {"use_tf32": "0", "cudnn_conv_algo_search": "DEFAULT"}), "CPUExecutionProvider"],
}


def find_device(wanted: str) -> str:
    """Return "cpu" or "cuda" for a choice of `DEVICES`.

    Raises:
        InvalidInputError: the choice is unknown.
        MissingExtraError: "cuda" is chosen and the installed engine does not offer it.
    """
    if wanted not in DEVICES:
        raise InvalidInputError(f"The device must be one of {', '.join(DEVICES)}, got {wanted!r}.")
    offered = _CUDA in onnxruntime.get_available_providers()
    if wanted == "cuda" and not offered:
        raise MissingExtraError(
            "Inference on CUDA needs the package onnxruntime-gpu instead of the "
            "installed onnxruntime; or choose the device cpu."
        )
    return "cuda" if wanted != "cpu" and offered else "cpu"


def open_session(
    network: bytes, data: Mapping[str, bytes], *, name: str, device: str = "cpu"
) -> onnxruntime.InferenceSession:
    """Open a network from memory, without access to files.

    Args:
        network: an ONNX file.
        data: files that may hold its weights (ONNX's external data), by their names in the network.
        name: the network's, for errors.
        device: "cpu" or "cuda". CUDA has not been tried on a graphics card by this project.

    Raises:
        ModelError: the network cannot be run, or the device does not work.
    """
    try:
        options = _options(data)
        session = onnxruntime.InferenceSession(network, options, providers=_PROVIDERS[device])
    except RUNTIME_ERRORS as error:
        hint = "; weights in other files are read where the card names these as the network's 'data'"
        raise ModelError(
            f"The network {name} is no ONNX model that can be run: {one_line(error)}"
            f"{hint if 'xternal' in str(error) else '; export it again'}."
        ) from error
    if device == "cuda" and session.get_providers()[0] != _CUDA:
        raise ModelError(
            f"The network {name} cannot be run with CUDA: ONNX Runtime offers it, but could not start it; "
            f"check the driver and the CUDA and cuDNN libraries, or choose the device cpu."
        )
    return session


def _options(data: Mapping[str, bytes]) -> onnxruntime.SessionOptions:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1  # from 4 on, float sums may be blocked differently
    options.inter_op_num_threads = 1
    options.execution_mode = onnxruntime.ExecutionMode.ORT_SEQUENTIAL
    options.use_deterministic_compute = True
    options.enable_mem_pattern = False  # with it, not only the first run is slow but also the second
    options.log_severity_level = 4  # errors are raised, and must not be printed as well
    # Files outside the table are refused, but an empty table would not count as a table.
    table = {"": b"\0", **data}
    sizes = [len(content) for content in table.values()]
    options.add_external_initializers_from_files_in_memory(list(table), list(table.values()), sizes)
    return options


def one_line(error: BaseException) -> str:
    """Return an error of the engine as part of a sentence, without its name and number."""
    return " ".join(str(error).rpartition("[ONNXRuntimeError] : ")[2].split(" : ", 2)[-1].split()).rstrip(".")


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
