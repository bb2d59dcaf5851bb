"""Import of the published networks' checkpoints as a model.

SynDrone's benchmark (LTTM/Syndrone) saves `model.state_dict()` of torchvision's `deeplabv3_resnet50`, and the
exemplar that this project follows loads three of them strictly: `rgb.pth`, `depth.pth` and `fusion.pth`.
"""

import zipfile
from pathlib import Path
from pickle import UnpicklingError
from typing import Final
from warnings import catch_warnings

import numpy as np
import torch
from torch import Tensor

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError, ModelError
from sunset.files.inputs import file_digest
from sunset.files.outputs import draft_of_folder
from sunset.perception import Modality, Model, load_model
from sunset.perception.card import MAX_SIDE, check_name
from sunset.processes.workers import Stages
from sunset_lab.architecture import HEIGHT, WIDTH, Layer
from sunset_lab.config import MODALITIES, TrainingConfig
from sunset_lab.network import build, check_archive, folded_weights
from sunset_lab.onnx_graph import Format, Network, export
from sunset_lab.shapes import ReferenceShape
from sunset_ros.texts import shorten


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
    with draft_of_folder(out, "model") as draft:
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
        export(draft, networks, Format(size=(height, width), published_depth=True), card)
    note("Importing", len(paths), len(paths))
    return load_model(out)


def _checked_paths(folder: Path, name: str, height: int, width: int) -> dict[str, Path]:
    """Return the checkpoints in a folder by network, after checks of the arguments."""
    stride = ReferenceShape.stride
    if not all(side in range(stride, MAX_SIDE + 1, stride) for side in (width, height)):
        raise InvalidInputError(
            f"The networks take frames whose width and height are multiples of {stride}, of at most {MAX_SIDE}, got "
            f"{width}x{height}."
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
    modules = modules.to_empty(device="cpu").eval()
    try:
        modules.load_state_dict(_entries(path))
    except RuntimeError as error:
        why = shorten(" ".join(line.strip() for line in str(error).splitlines()[1:]))
        raise ModelError(
            f"The checkpoint {path} does not fit a {shape.name} with {len(CLASSES)} classes: {why}"
        ) from error
    with np.errstate(over="ignore", invalid="ignore"):  # the next lines refuse such numbers
        weights = folded_weights(layers, modules)
    stored = [torch.isfinite(value).all() for value in modules.state_dict().values()]
    folded = [np.isfinite(array).all() for arrays in weights.values() for array in arrays]
    if not all(stored) or not all(folded):
        raise ModelError(
            f"The checkpoint {path} has weights that are not finite as float32: the file is damaged or its training "
            "failed, import another one."
        )
    return Network(layers, weights)


def _entries(path: Path) -> dict[str, Tensor]:
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
    if not isinstance(content, dict):
        kind = type(content).__name__
        raise ModelError(
            f"The checkpoint {path} must hold a state dict, tensors by name, got an unsuitable {kind}."
        )
    return content
