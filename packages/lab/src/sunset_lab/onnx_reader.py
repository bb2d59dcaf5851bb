"""The weights of a model's networks, for further training."""

from collections.abc import Mapping
from pathlib import Path
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
import onnx
from google.protobuf.message import DecodeError  # type: ignore[import-untyped]  # comes with onnx
from onnx import numpy_helper

from sunset.errors import InvalidInputError, ModelError
from sunset.perception import Modality, Model
from sunset_lab.architecture import Conv, convolutions
from sunset_lab.config import TrainingConfig
from sunset_lab.onnx_layers import Weights

_Array: TypeAlias = npt.NDArray[np.float32]


def read_network(path: Path, *, weights: bool = True) -> onnx.ModelProto:
    """Return the content of an ONNX file, with or without the weights in files beside it."""
    try:
        return onnx.load(path, load_external_data=weights)
    except DecodeError as error:
        raise ModelError(f"The network {path} is not an ONNX model: {error}.") from error


def stored_weights(model: Model, config: TrainingConfig) -> Weights:
    """Return the weights of a model that `train` wrote, for the networks of a training.

    Weights in 8 bits are converted; rows and columns of kernels that were not stored are zeros.
    """
    weights = {}
    for name in config.modalities:
        modality = Modality[name.upper()]
        if modality not in model.card.networks:
            raise _misfit_error(model, config, f"it has no network {name!r}")
        graph = read_network(model.folder / model.card.networks[modality].file).graph
        constants = {tensor.name: tensor for tensor in graph.initializer}
        for layer in convolutions(config.plan((name,))):
            try:
                weights[layer.name] = _stored(layer, constants)
            except (KeyError, ValueError) as error:
                why = f"its network {name!r} has no such layer {layer.name}"
                raise _misfit_error(model, config, why) from error
    return weights


def _stored(layer: Conv, constants: Mapping[str, onnx.TensorProto]) -> tuple[_Array, _Array]:
    """Return a layer's kernel and bias; a missing or unsuitable constant raises KeyError or ValueError."""

    def constant(key: str) -> _Array:
        array: _Array = numpy_helper.to_array(constants[f"{layer.name}.{key}"])
        return array

    if f"{layer.name}.kernel.8bit" in constants:
        kernel = constant("kernel.8bit") * constant("kernel.scale")[:, None, None, None]
        bias = constant("bias.32bit") * constant("bias.scale")
    else:
        kernel, bias = constant("kernel"), constant("bias")
    kernel = kernel.reshape(*layer.channels[::-1], *(kernel.shape[2:] or (1, 1)))
    unstored = [(layer.kernel - taps) // 2 for taps in kernel.shape[2:]]
    kernel = np.pad(kernel, [(0, 0), (0, 0), *((each, each) for each in unstored)])
    return kernel.astype(np.float32), bias.astype(np.float32).reshape(layer.channels[1])


def _misfit_error(model: Model, config: TrainingConfig, why: str) -> InvalidInputError:
    return InvalidInputError(
        f"A training of {config.shape.name} ({', '.join(config.modalities)}) cannot start from the model "
        f"{model.card.name!r}: {why}. Start from a model that 'sunset train' made with the same --model and --modality."
    )
