"""Writes plans of `architecture` with their weights as ONNX models, from raw frames to labels and entropy."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from onnx import TensorProto

from sunset.classes import CLASSES
from sunset.input_files import file_digest
from sunset.perception import Modality, NetworkCard
from sunset.training.architecture import Layer, convolutions
from sunset.training.inputs import HEIGHT, WIDTH
from sunset.training.onnx_inputs import depth_input, published_depth_input, rgb_input
from sunset.training.onnx_layers import Layers, Ranges, Weights
from sunset.training.onnx_outputs import write_outputs
from sunset.training.onnx_writer import Graph, Store, tensor_info


@dataclass(frozen=True, slots=True)
class Format:
    """What an exported network takes, and how its numbers are stored.

    Attributes:
        size: height and width of the frames; multiples of 8, and of 16 unless depth is as published.
        published_depth: depth enters as in SynDrone's benchmark, not as logarithm and contrasts.
        ranges: of the results that are computed in 8 bits; a convolution is, if its source has a range.
    """

    size: tuple[int, int] = (HEIGHT, WIDTH)
    published_depth: bool = False
    ranges: Ranges | None = None

    @property
    def precision(self) -> str:
        """How the numbers are stored, for the model's card."""
        return "int8" if self.ranges else "float32"


@dataclass(frozen=True, slots=True)
class Network:
    """One network of a model: its plan, whose last layer is the logits, and what `folded_weights` gives for it.

    The temperature is greater than 0.
    """

    layers: tuple[Layer, ...]
    weights: Weights
    temperature: float = 1.0

    @property
    def parameters(self) -> int:
        """The number of weights, normalisation folded in."""
        used = [self.weights[layer.name] for layer in convolutions(self.layers)]
        return sum(kernel.size + bias.size for kernel, bias in used)


def export(folder: Path, networks: Mapping[Modality, Network], form: Format) -> dict[Modality, NetworkCard]:
    """Write a model's networks as ONNX; what they share is stored once, in files beside them.

    Their inputs are raw: `bgr` (H, W, 3) uint8 and `depth` (H, W) uint16, those that they need. Their outputs
    are `logits` (1, 28, h, w) float32 at the network's stride, before interpolation and without the
    temperature; `labels` (H, W) uint8, the class of the greatest interpolated logit; and `entropy`, the mean
    over pixels of the normalised Shannon entropy of the softmax of the interpolated logits over the
    constant `temperature`, logits bounded as `write_outputs` says.

    Returns:
        The networks' entries on the model's card.
    """
    folder.mkdir(parents=True, exist_ok=True)
    store = Store(folder)
    # branches first: what the fusion shares is in their files
    graphs = {
        modality: _graph(modality, networks[modality], form, store)
        for modality in sorted(networks, reverse=True)
    }
    store.write()
    cards = {}
    for modality, graph in sorted(graphs.items()):
        path, network = folder / f"{modality.key}.onnx", networks[modality]
        graph.write(path)
        data = {name: file_digest(folder / name) for name in sorted(graph.data)}
        cards[modality] = NetworkCard(
            path.name, file_digest(path), network.parameters, network.temperature, data
        )
    return cards


def _graph(modality: Modality, network: Network, form: Format, store: Store) -> Graph:
    """Return one network, put together."""
    graph, sizes = Graph(modality.key, store), {}
    if modality.needs_rgb:
        sizes["rgb.input"] = form.size
        graph.inputs.append(tensor_info("bgr", TensorProto.UINT8, [*form.size, 3]))
        rgb_input(graph)
    if modality.needs_depth:
        sizes["depth.input"] = form.size
        graph.inputs.append(tensor_info("depth", TensorProto.UINT16, form.size))
        (published_depth_input if form.published_depth else depth_input)(graph, form.size)
    layers = Layers(graph, network.weights, sizes, form.ranges or {})
    for layer in network.layers:
        layers.write(layer)
    logits = network.layers[-1].name
    write_outputs(graph, logits, layers.sizes[logits], form.size, network.temperature)
    graph.outputs += [
        tensor_info("logits", TensorProto.FLOAT, [1, len(CLASSES), *layers.sizes[logits]]),
        tensor_info("labels", TensorProto.UINT8, form.size),
        tensor_info("entropy", TensorProto.FLOAT, []),
    ]
    return graph
