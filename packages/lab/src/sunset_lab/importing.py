"""Import of the published networks' checkpoints as a model.

SynDrone's benchmark (LTTM/Syndrone) saves `model.state_dict()` of torchvision's `deeplabv3_resnet50`, and the
exemplar that this project follows loads three of them strictly: `rgb.pth`, `depth.pth` and `fusion.pth`. State dicts
inside a training's checkpoint, or of a parallel model, are understood, too.
"""

import shutil
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from pickle import UnpicklingError
from typing import Final
from warnings import catch_warnings

import numpy as np
import torch
from torch import Tensor

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError, ModelError, OutputError
from sunset.files.inputs import file_digest
from sunset.perception import Modality, Model, load_model
from sunset.perception.card import check_name
from sunset.processes.workers import Stages
from sunset_lab.architecture import Layer
from sunset_lab.archives import check_archive
from sunset_lab.config import MODALITIES, TrainingConfig
from sunset_lab.inputs import HEIGHT, WIDTH
from sunset_lab.network import build, folded_weights
from sunset_lab.onnx_graph import Format, Network, export
from sunset_lab.reference import ReferenceShape

_PARALLEL: Final = "module."
_SHOWN: Final = 3


def import_checkpoints(
    folder: Path,
    out: Path,
    *,
    name: str,
    height: int = HEIGHT,
    width: int = WIDTH,
    progress: Stages | None = None,
) -> Model:
    """Make a model of the checkpoints `rgb.pth`, `depth.pth` and `fusion.pth` in a folder, as far as there are any.

    Each must hold exactly the entries of torchvision's `deeplabv3_resnet50` with 28 classes and without auxiliary
    classifier; the fusion `rgb.*`, `dth.*`, `merge.0`, `merge.2` and `merge.4`. Their code is not executed. The
    networks take frames as the published networks do, and compute in float32. The model needs to be calibrated.
    """
    paths = _checked_paths(folder, name, height, width)
    note = progress or (lambda *_: None)
    networks = {}
    for done, (key, path) in enumerate(paths.items()):
        note("Importing", done, len(paths))
        networks[Modality[key.upper()]] = _network(key, path)
    with _new_folder(out):
        card = {
            "name": name,
            "description": _DESCRIPTION,
            "architecture": ReferenceShape.name,
            "training": {
                "source": "imported checkpoints",
                "sha256": {path.name: file_digest(path) for path in paths.values()},
                "left_out": _LEFT_OUT,
            },
        }
        export(out, networks, Format(size=(height, width), published_depth=True), card)
    note("Importing", len(paths), len(paths))
    return load_model(out)


def _checked_paths(folder: Path, name: str, height: int, width: int) -> dict[str, Path]:
    """Return the checkpoints in a folder by network, after checks of the arguments."""
    stride = ReferenceShape.stride
    if min(height, width) < stride or height % stride or width % stride:
        raise InvalidInputError(
            f"The networks take frames whose width and height are multiples of {stride}, got {width}x{height}."
        )
    check_name(name)
    paths = {key: folder / f"{key}.pth" for key in MODALITIES}
    present = {key: path for key, path in paths.items() if path.is_file()}
    if not present:
        raise ModelError(
            f"The folder {folder} has none of the checkpoints rgb.pth, depth.pth and fusion.pth: give the folder "
            "with at least one of them."
        )
    return present


@contextmanager
def _new_folder(out: Path) -> Iterator[None]:
    """Remove a new folder when writing into it fails, as it would be in the way of the next attempt."""
    is_new = not out.exists()
    try:
        yield
    except BaseException as error:
        if is_new:
            shutil.rmtree(out, ignore_errors=True)
        if not isinstance(error, OSError):
            raise
        raise OutputError(f"The model cannot be written to {out}: {error.strerror or error}.") from error


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


def _network(key: str, path: Path) -> Network:
    """Return a network's plan with the weights of a checkpoint."""
    shape = ReferenceShape()
    layers: tuple[Layer, ...] = shape.network(f"{key}.", "")
    if key == "fusion":
        layers = TrainingConfig(shape=shape).layers(key)
    with torch.device("meta"):
        modules = build(layers)
    entries = _checked(_entries(path), modules.state_dict(), path)
    modules.load_state_dict(entries, strict=True, assign=True)
    with np.errstate(over="ignore"):  # the next lines refuse such numbers
        weights = folded_weights(layers, modules.eval())
    for layer, arrays in weights.items():
        if not all(np.isfinite(array).all() for array in arrays):
            raise ModelError(
                f"The layer {layer!r} of the checkpoint {path} has weights that its normalisation makes too large "
                "for float32: the file is damaged or its training failed, import another one."
            )
    return Network(layers, weights)


def _entries(path: Path) -> Mapping[str, Tensor]:
    """Return the state dict in a checkpoint."""
    unreadable = ModelError(
        f"The file {path} cannot be read as a PyTorch checkpoint: it is damaged, incomplete, or something else."
    )
    if zipfile.is_zipfile(path):  # old checkpoints are not archives
        check_archive(path, unreadable)
    try:
        with catch_warnings(action="ignore"):  # the errors below say the same
            content = torch.load(path, map_location="cpu", weights_only=True)
    except UnpicklingError as error:
        raise ModelError(
            f"The file {path} cannot be read as a PyTorch checkpoint: it refers to code, which is not executed, or is "
            "damaged; save its state dict, tensors by name, and nothing else."
        ) from error
    except Exception as error:  # a damaged pickle or archive can raise anything
        raise unreadable from error
    if isinstance(content, dict):
        wrapped = (content.get(key) for key in ("state_dict", "model_state_dict", "model"))
        content = next((inner for inner in wrapped if isinstance(inner, dict)), content)
    if not isinstance(content, dict) or not content or not all(isinstance(key, str) for key in content):
        kind = type(content).__name__
        raise ModelError(
            f"The checkpoint {path} must hold a state dict, tensors by name, got an unsuitable {kind}."
        )
    if all(key.startswith(_PARALLEL) for key in content):
        return {key.removeprefix(_PARALLEL): value for key, value in content.items()}
    return content


def _checked(entries: Mapping[str, Tensor], expected: Mapping[str, Tensor], path: Path) -> dict[str, Tensor]:
    """Return the entries as float32, after a comparison with the network's."""
    network = f"{ReferenceShape().name} with {len(CLASSES)} classes"
    for names, verb in (
        (sorted(set(expected) - set(entries)), f"lacks {{}} of the {len(expected)} entries of a {network}"),
        (sorted(set(entries) - set(expected)), f"has {{}} entries that a {network} has not"),
    ):
        if names:
            shown = ", ".join(names[:_SHOWN]) + ", …" * (len(names) > _SHOWN)
            raise ModelError(f"The checkpoint {path} {verb.format(len(names))}: {shown}.")
    return {name: _converted(entries[name], like, name, path) for name, like in expected.items()}


def _converted(value: Tensor, like: Tensor, name: str, path: Path) -> Tensor:
    """Return an entry in the network's own number format."""
    entry = f"The entry {name!r} of the checkpoint {path}"
    if not isinstance(value, torch.Tensor) or value.layout is not torch.strided or value.is_meta:
        raise ModelError(f"{entry} must be a dense tensor with values, got {type(value).__name__}.")
    if value.shape != like.shape:
        raise ModelError(f"{entry} must have shape {tuple(like.shape)}, got {tuple(value.shape)}.")
    if value.is_floating_point() != like.is_floating_point() or value.is_complex():
        numbers = "floating-point numbers" if like.is_floating_point() else "whole numbers"
        raise ModelError(f"{entry} must hold {numbers}, got {value.dtype}: save it as {like.dtype}.")
    converted = value.detach().to(like.dtype)  # it may be a parameter
    allowed = torch.isfinite(converted)
    if name.endswith(".running_var"):
        allowed &= converted >= 0
    if not bool(allowed.all()):
        first = value.detach().double()[~allowed][0].item()
        limits = "at least 0 and finite" if name.endswith(".running_var") else "finite"
        raise ModelError(
            f"{entry} must hold numbers that are {limits} as {like.dtype}, got {first:g}: the file is damaged or its "
            "training failed, import another one."
        )
    return converted
