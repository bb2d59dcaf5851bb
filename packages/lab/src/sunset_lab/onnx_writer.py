"""ONNX graphs under construction, whose large weights are in shared files."""

import hashlib
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt
from onnx import NodeProto, TensorProto, ValueInfoProto, checker, external_data_helper, helper, numpy_helper

from sunset.files.outputs import draft_of
from sunset_lab.inputs import upsampling

_LARGE: Final = 16384
"""Weights of so many bytes or more are kept outside the graph's own file."""


class Store:
    """Weights by content, in files beside the graphs: several graphs share the same bytes."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._files: dict[str, bytearray] = {}
        self._known: dict[bytes, tuple[str, int]] = {}

    def place(self, data: bytes, file: str) -> tuple[str, int]:
        """Return the file and the offset of bytes; new bytes are appended to `file`."""
        digest = hashlib.sha256(data).digest()
        if digest not in self._known:
            content = self._files.setdefault(file, bytearray())
            content.extend(bytes(-len(content) % 64))
            self._known[digest] = (file, len(content))
            content.extend(data)
        return self._known[digest]

    def write(self) -> None:
        """Write the files."""
        for name, content in self._files.items():
            with draft_of(self._folder / name) as draft:
                draft.write_bytes(content)


class Graph:
    """A graph under construction, whose large weights go into a store."""

    def __init__(self, name: str, store: Store) -> None:
        self._name = name
        self._store = store
        self._nodes: list[NodeProto] = []
        self._constants: list[TensorProto] = []
        self.inputs: list[ValueInfoProto] = []
        self.outputs: list[ValueInfoProto] = []
        self.data: set[str] = set()
        """The store's files that the graph needs."""

    def constant(self, name: str, value: npt.ArrayLike, dtype: npt.DTypeLike = np.float32) -> str:
        """Add a constant and return its name."""
        self._constants.append(numpy_helper.from_array(np.asarray(value, dtype=dtype), name))
        return name

    def weights(self, name: str, value: npt.ArrayLike, dtype: npt.DTypeLike = np.float32) -> str:
        """Add a constant to the store if it is large, to the graph if not."""
        self.constant(name, value, dtype)
        tensor = self._constants[-1]
        if len(tensor.raw_data) >= _LARGE:
            file, offset = self._store.place(tensor.raw_data, f"{self._name}.bin")
            external_data_helper.set_external_data(tensor, file, offset, len(tensor.raw_data))
            tensor.ClearField("raw_data")
            self.data.add(file)
        return name

    def node(self, kind: str, inputs: Sequence[str], output: str, *more: str, **attributes: object) -> str:
        """Add a node and return its first output, which names it."""
        self._nodes.append(helper.make_node(kind, list(inputs), [output, *more], output, **attributes))
        return output

    def bounds(self, name: str, axis: int, part: slice) -> tuple[str, ...]:
        """Add the constants of `Slice` for a part along an axis, and return their names."""
        values = {"start": part.start, "stop": part.stop, "axis": axis}
        return tuple(self.constant(f"{name}.{key}", [value], np.int64) for key, value in values.items())

    def upsample(self, source: str, output: str, size: tuple[int, int], factor: int) -> str:
        """Add the bilinear interpolation of maps by a whole factor, and return the result's name."""
        if factor == 1:
            return self.node("Identity", [source], output)
        rows = self.constant(f"{output}.rows", upsampling(size[0], factor))
        columns = self.constant(f"{output}.columns", upsampling(size[1], factor).T)
        self.node("MatMul", [source, columns], f"{output}.wide")
        return self.node("MatMul", [rows, f"{output}.wide"], output)

    def write(self, path: Path) -> None:
        """Write and check the graph, after the store."""
        body = helper.make_graph(self._nodes, self._name, self.inputs, self.outputs, self._constants)
        opset = helper.make_opsetid("", 18)
        model = helper.make_model(body, opset_imports=[opset], ir_version=9, producer_name="sunset")
        with draft_of(path) as draft:
            draft.write_bytes(model.SerializeToString(deterministic=True))
        checker.check_model(os.fspath(path))


def tensor_info(name: str, dtype: int, shape: Sequence[int]) -> ValueInfoProto:
    """Return the description of an input or output."""
    return helper.make_tensor_value_info(name, dtype, list(shape))
