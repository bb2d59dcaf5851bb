"""The engine of the networks, ONNX Runtime, with settings for results that repeat bit by bit."""

from collections.abc import Mapping
from typing import Final

import onnxruntime
from onnxruntime.capi import onnxruntime_pybind11_state as _runtime_errors

from sunset.errors import InvalidInputError, MissingExtraError, ModelError

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
            "Inference on CUDA needs the package onnxruntime-gpu in the place of onnxruntime: the one that is "
            "installed does not offer it; or choose the device cpu."
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
