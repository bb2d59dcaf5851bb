"""Turning the published networks' checkpoints into a model.

SynDrone's benchmark (LTTM/Syndrone) saves `model.state_dict()` of torchvision's `deeplabv3_resnet50`, and the
exemplar that this project follows loads three of them, `rgb.pth`, `depth.pth` and `fusion.pth`, strictly. State
dicts that were wrapped in a training's checkpoint or saved from a parallel model are understood, too.
"""

import shutil
import zipfile
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from pathlib import Path
from pickle import UnpicklingError
from pickletools import genops
from typing import TYPE_CHECKING, Final
from warnings import catch_warnings

import numpy as np

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError, MissingExtraError, ModelError, OutputError
from sunset.input_files import file_digest, open_regular
from sunset.perception import Modality, Model, ModelCard, load_model
from sunset.perception.card import check_name
from sunset.training.architecture import Layer
from sunset.training.archives import check_archive
from sunset.training.config import MODALITIES, TrainingConfig
from sunset.training.inputs import HEIGHT, WIDTH
from sunset.training.recalibrate import version_of
from sunset.training.reference import ReferenceShape

if TYPE_CHECKING:
    from torch import Tensor

    from sunset.training.onnx_layers import Weights

_PARALLEL: Final = "module."
_REFUSED: Final = (
    "unsupported global",
    "unrecognized function",
    "unsupported class",
    "can only create",
    "can only build",
)
"""How torch says that a file refers to other code than that of tensors, in small letters."""

_SHOWN: Final = 3


def import_checkpoints(
    folder: Path,
    out: Path,
    *,
    name: str,
    height: int = HEIGHT,
    width: int = WIDTH,
    progress: Callable[[str, int, int], None] | None = None,
) -> Model:
    """Make a model of `rgb.pth`, `depth.pth` and `fusion.pth`, those that are there.

    Each must hold exactly the entries of torchvision's `deeplabv3_resnet50` with 28 classes and without auxiliary
    classifier, the fusion `rgb.*` and `dth.*` of them and `merge.0`, `merge.2` and `merge.4`. Loading executes
    nothing. The networks take frames as the published ones do, and compute in float32. Temperatures and
    thresholds are not known: calibrate the model next.

    Args:
        folder: with the checkpoints.
        out: the model's folder.
        name: the model's name on its card.
        height: of the frames that it will take, a multiple of 8.
        width: of the frames, likewise.
        progress: called with what is being done, how much of it is done, and how much there is.

    Raises:
        MissingExtraError: torch or onnx is not installed.
        InvalidInputError: the networks cannot take the size, or a card cannot hold the name.
        ModelError: no checkpoint is there, or one is unusable.
        OutputError: the model's folder cannot be written.
    """
    if find_spec("torch") is None or find_spec("onnx") is None:
        raise MissingExtraError(
            "Importing checkpoints needs torch and onnx, not installed: pip install 'sunset-exemplar[train]'."
        )
    stride = ReferenceShape.stride
    if min(height, width) < stride or height % stride or width % stride:
        raise InvalidInputError(
            f"The networks take frames whose width and height are multiples of {stride}, got {width}x{height}."
        )
    check_name(name)
    paths = {name: folder / f"{name}.pth" for name in MODALITIES if (folder / f"{name}.pth").is_file()}
    if not paths:
        raise ModelError(
            f"The folder {folder} has none of the checkpoints rgb.pth, depth.pth and fusion.pth: give the folder "
            "with at least one of them."
        )
    from sunset.training.onnx_graph import Format, Network, export  # noqa: PLC0415  onnx is optional

    networks = {}
    for done, (modality, path) in enumerate(paths.items()):
        if progress is not None:
            progress("Importing", done, len(paths))
        networks[Modality[modality.upper()]] = Network(*_layers_and_weights(modality, path))
    is_new = not out.exists()
    try:
        cards = export(out, networks, Format(size=(height, width), published_depth=True))
        ModelCard(
            name=name,
            version=version_of(cards),
            description=_DESCRIPTION,
            height=height,
            width=width,
            classes=CLASSES,
            entropy_threshold=1.0,
            sharpness_threshold=0.0,
            networks=cards,
            training={
                "source": "imported checkpoints",
                "sha256": {path.name: file_digest(path) for path in paths.values()},
                "left_out": _LEFT_OUT,
            },
            architecture=ReferenceShape().name,
            precision="float32",
        ).write(out)
    except BaseException as error:
        if is_new:
            shutil.rmtree(out, ignore_errors=True)  # half a model would be in the way of the next try
        if not isinstance(error, OSError):
            raise
        raise OutputError(f"The model cannot be written to {out}: {error.strerror or error}.") from error
    if progress is not None:
        progress("Importing", len(paths), len(paths))
    return load_model(out)


_DESCRIPTION: Final = (
    f"{ReferenceShape().description} The weights were imported. The networks take raw frames: colours are "
    "normalised with ImageNet's mean and standard deviation; depth enters as its share of 1000 m in all three "
    "channels."
)

_LEFT_OUT: Final = (
    "temperatures and thresholds: they are 1, 1 and 0 until 'sunset models calibrate' finds those of this model. "
    "SynDrone's own training code also normalises depth like a colour, which the exemplar's checkpoints do not "
    "expect: depth is not normalised here"
)


def _layers_and_weights(modality: str, path: Path) -> tuple[tuple[Layer, ...], "Weights"]:
    """Return a network's plan, and its weights out of a checkpoint."""
    import torch  # noqa: PLC0415  an optional extra

    from sunset.training.network import build, folded_weights  # noqa: PLC0415

    shape = ReferenceShape()
    whole = modality == "fusion"
    layers = TrainingConfig(shape=shape).layers(modality) if whole else shape.network(f"{modality}.", "")
    with torch.device("meta"):
        modules = build(layers)
    entries = _checked(_entries(path), modules.state_dict(), path)
    modules.load_state_dict(entries, strict=True, assign=True)
    with np.errstate(over="ignore"):  # such numbers are refused next
        weights = folded_weights(layers, modules.eval())
    for layer, arrays in weights.items():
        if not all(np.isfinite(array).all() for array in arrays):
            raise ModelError(
                f"The layer {layer!r} of the checkpoint {path} has weights that its normalisation makes too large "
                "for float32: the file is damaged or its training failed, import another one."
            )
    return layers, weights


def _entries(path: Path) -> Mapping[str, "Tensor"]:
    """Return the state dict in a checkpoint."""
    import torch  # noqa: PLC0415  an optional extra

    if zipfile.is_zipfile(path):  # older ones are not
        check_archive(path, _unreadable_error(path))
    try:
        with catch_warnings(action="ignore"):  # on what the file is like: what is wrong is said below
            content = torch.load(path, map_location="cpu", weights_only=True)
    except UnpicklingError as error:
        # an archive's checksums hold, so what is refused in it was written so
        refused = any(words in str(error).lower() for words in _REFUSED)
        if not (zipfile.is_zipfile(path) or refused or _names_code(path)):
            raise _unreadable_error(path) from error
        raise ModelError(
            f"The checkpoint {path} refers to code that loading it would execute, which is refused: save its "
            "state dict, tensors by name, and nothing else."
        ) from error
    except Exception as error:  # a damaged pickle or archive can raise anything
        raise _unreadable_error(path) from error
    if isinstance(content, dict):
        wrapped = (content.get(key) for key in ("state_dict", "model_state_dict", "model"))
        content = next((inner for inner in wrapped if isinstance(inner, dict)), content)
    if not isinstance(content, dict) or not content or not all(isinstance(key, str) for key in content):
        kind = f"a {type(content).__name__}"
        if isinstance(content, dict):
            kind = "a dict whose keys are no names" if content else "nothing"
        raise ModelError(f"The checkpoint {path} must hold a state dict, tensors by name, but holds {kind}.")
    if all(key.startswith(_PARALLEL) for key in content):
        return {key.removeprefix(_PARALLEL): value for key, value in content.items()}
    return content


def _names_code(path: Path) -> bool:
    """Return whether a file is a pickle that names code; torch does not say so of one of a newer protocol."""
    try:
        with open_regular(path) as file:
            return any("GLOBAL" in code.name or code.name == "INST" for code, _, _ in genops(file))
    except Exception:  # noqa: BLE001  whatever it is, it is not a pickle
        return False


def _unreadable_error(path: Path) -> ModelError:
    return ModelError(
        f"The file {path} cannot be read as a PyTorch checkpoint: it is damaged, incomplete, or something else."
    )


def _checked(
    entries: Mapping[str, "Tensor"], expected: Mapping[str, "Tensor"], path: Path
) -> dict[str, "Tensor"]:
    """Return the entries as float32, if they are exactly those of the network."""
    network = f"{ReferenceShape().name} with {len(CLASSES)} classes"
    for names, verb in (
        (sorted(set(expected) - set(entries)), f"lacks {{}} of the {len(expected)} entries of a {network}"),
        (sorted(set(entries) - set(expected)), f"has {{}} entries that a {network} has not"),
    ):
        if names:
            shown = ", ".join(names[:_SHOWN]) + ", …" * (len(names) > _SHOWN)
            raise ModelError(f"The checkpoint {path} {verb.format(len(names))}: {shown}.")
    return {name: _converted(entries[name], like, name, path) for name, like in expected.items()}


def _converted(value: "Tensor", like: "Tensor", name: str, path: Path) -> "Tensor":
    """Return an entry in the network's own number format, if it is one that the network can compute with."""
    import torch  # noqa: PLC0415  an optional extra

    entry = f"The entry {name!r} of the checkpoint {path}"
    if not isinstance(value, torch.Tensor) or value.layout is not torch.strided or value.is_nested:
        nested = getattr(value, "is_nested", False)
        form = "a nested tensor" if nested else getattr(value, "layout", type(value).__name__)
        raise ModelError(f"{entry} must be a dense tensor, got {form}: save it as one.")
    if value.is_meta:
        raise ModelError(
            f"{entry} must have values, got a tensor of the device 'meta', which has none: save the state dict "
            "after the weights were loaded."
        )
    if value.shape != like.shape:
        raise ModelError(f"{entry} must have shape {tuple(like.shape)}, got {tuple(value.shape)}.")
    numbers = "floating-point numbers" if like.is_floating_point() else "whole numbers"
    misfit = ModelError(f"{entry} must hold {numbers}, got {value.dtype}: save it as {like.dtype}.")
    if value.is_floating_point() != like.is_floating_point() or value.is_complex():
        raise misfit
    try:
        converted = value.detach().to(like.dtype)  # it may be a parameter
    except RuntimeError as error:  # torch can store numbers that it cannot convert
        raise misfit from error
    if not bool(torch.isfinite(converted).all()):
        raise ModelError(
            f"{entry} has values that are not finite as {like.dtype}, such as "
            f"{_first(value, ~torch.isfinite(converted))}: the file is damaged or its training failed, import "
            "another one."
        )
    if name.endswith(".running_var") and bool((converted < 0).any()):
        raise ModelError(
            f"{entry} holds variances, which must be at least 0, got {_first(value, converted < 0)}: the file is "
            "damaged or its training failed, import another one."
        )
    return converted


def _first(value: "Tensor", chosen: "Tensor") -> str:
    """Return the first of some of a tensor's numbers."""
    return f"{value.detach().double()[chosen][0].item():g}"
