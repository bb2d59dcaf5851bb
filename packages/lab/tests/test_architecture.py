import numpy as np
import pytest

from sunset.errors import InvalidInputError
from sunset_lab import MODALITIES, TrainingConfig
from sunset_lab.architecture import (
    Concat,
    Conv,
    Layer,
    MaxPool,
    Pool,
    Resize,
    Shuffle,
    Spread,
    convolutions,
    merge,
)
from sunset_lab.shapes import LiteShape, ReferenceShape

pytestmark = pytest.mark.thorough


def sources(layer: Layer) -> tuple[str, ...]:
    match layer:
        case Concat():
            return layer.sources
        case Conv():
            return (layer.source, layer.add) if layer.add else (layer.source,)
        case Spread():
            return (layer.source, layer.like)
        case MaxPool() | Pool() | Resize() | Shuffle():
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
        case MaxPool() | Pool() | Resize() | Spread():
            return known[layer.source]


@pytest.mark.parametrize(
    "shape",
    [
        LiteShape(),
        LiteShape(stem=16, widths=(16, 24, 40), blocks=(2, 1, 3), rates=(3,)),
        ReferenceShape(),
        ReferenceShape(width=16, blocks=(1, 2, 1, 1), pyramid=24),
    ],
)
def test_every_layer_has_sources_before_it_whose_channels_fit(shape: LiteShape | ReferenceShape) -> None:
    known = {"rgb.input": 3, "depth.input": 3}
    for layer in TrainingConfig(shape=shape).plan(MODALITIES):
        assert set(sources(layer)) <= set(known), layer
        assert layer.name not in known
        known[layer.name] = channels(layer, known)
    assert [known[f"{name}.logits"] for name in MODALITIES] == [28, 28, 28]


def test_late_fusion_is_56_56_56_28() -> None:
    found = [layer.channels for layer in convolutions(merge(8))]
    assert found == [(56, 56), (56, 56), (56, 28)]


@pytest.mark.parametrize(
    ("dilation", "size", "rows", "padding"),
    [(1, 18, slice(0, 3), 1), (17, 18, slice(0, 3), 17), (18, 18, slice(1, 2), 0), (1, 1, slice(1, 2), 0)],
)
def test_rows_of_a_kernel_that_only_ever_see_padding_are_left_out(
    dilation: int, size: int, rows: slice, padding: int
) -> None:
    layer = Conv("y", "x", (16, 16), "w", dilation=dilation)
    assert layer.taps(size) == rows
    assert layer.padding(size) == padding


@pytest.mark.parametrize(("size", "dilation"), [(18, 12), (18, 9), (18, 4), (32, 24), (7, 6)])
def test_regions_cover_a_result_and_see_what_its_kernel_sees(size: int, dilation: int) -> None:
    rng = np.random.default_rng(0)
    source, kernel = rng.normal(size=size), rng.normal(size=3)
    padded = np.pad(source, dilation)
    whole = sum(kernel[tap] * padded[tap * dilation : tap * dilation + size] for tap in range(3))
    layer = Conv("y", "x", (16, 16), "w", dilation=dilation)
    parts = []
    for seen, used in layer.regions(size):
        values, taps = source[seen], kernel[used]
        length = len(values) - dilation * (len(taps) - 1)
        parts.append(sum(tap * values[i * dilation :][:length] for i, tap in enumerate(taps)))
    assert np.allclose(np.concatenate(parts), whole)


@pytest.mark.parametrize(
    ("size", "dilation", "expected"), [(18, 12, True), (18, 4, True), (32, 4, False), (18, 24, False)]
)
def test_regions_are_worth_it_where_padding_is_wide(size: int, dilation: int, expected: bool) -> None:
    assert Conv("y", "x", (16, 16), "w", dilation=dilation).worth_cutting(size) is expected


def test_an_output_stride_that_the_weights_cannot_run_at_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="must be 8, 16 or 32, got 4"):
        ReferenceShape().branch("rgb", 4)
    with pytest.raises(InvalidInputError, match="of 'lite' is 2, got 8"):
        LiteShape().branch("rgb", 8)
