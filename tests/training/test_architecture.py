import pytest

from sunset.errors import InvalidInputError
from sunset.training import NetworkShape
from sunset.training.architecture import (
    Concat,
    Conv,
    Layer,
    Pool,
    Resize,
    Shuffle,
    branch,
    convolutions,
    merge,
)


def sources(layer: Layer) -> tuple[str, ...]:
    match layer:
        case Concat():
            return layer.sources
        case Conv():
            return (layer.source, layer.add) if layer.add else (layer.source,)
        case Pool() | Resize() | Shuffle():
            return (layer.source,)


def channels(layer: Layer, known: dict[str, int]) -> int:
    match layer:
        case Concat():
            return sum(known[source] for source in layer.sources)
        case Conv():
            assert layer.channels[0] == known[layer.source], layer
            assert not layer.add or known[layer.add] == layer.channels[1], layer
            return layer.channels[1]
        case Shuffle():
            return known[layer.source] // 4
        case Pool() | Resize():
            return known[layer.source]


@pytest.mark.parametrize(
    "shape", [NetworkShape(), NetworkShape(stem=16, widths=(16, 24, 40), blocks=(2, 1, 3), rates=(3,))]
)
def test_every_layer_has_sources_before_it_whose_channels_fit(shape: NetworkShape) -> None:
    layers = branch("rgb", shape) + branch("depth", shape) + merge(("rgb", "depth"))
    known = {"rgb.input": 3, "depth.input": 3}
    for layer in layers:
        assert set(sources(layer)) <= set(known), layer
        assert layer.name not in known
        known[layer.name] = channels(layer, known)
    assert [known[f"{name}.logits"] for name in ("rgb", "depth", "fusion")] == [28, 28, 28]


def test_late_fusion_is_56_56_56_28() -> None:
    assert [layer.channels for layer in convolutions(merge(("rgb", "depth")))] == [
        (56, 56),
        (56, 56),
        (56, 28),
    ]


def test_widths_that_torch_cannot_train_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="at least 16 channels everywhere, got 8"):
        NetworkShape(skips=(8, 16))
