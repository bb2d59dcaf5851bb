import struct
import zlib
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from sunset.classes import CARLA_IDS
from sunset.data import Frame
from sunset.data.conventions import IDS_OF_NO_CLASS, SYNDRONE
from sunset.data.pixels import (
    COLOUR_JPEG,
    COLOUR_PNG,
    DEPTH_PNG,
    LABEL_PNG,
    counts_of_metres,
    picture,
    resample,
)
from sunset.errors import DataError
from sunset_ros.seeding import generator

RNG = generator(3, "pixels")
KINDS = (COLOUR_JPEG, COLOUR_PNG, DEPTH_PNG, LABEL_PNG)


def _frame(height: int, width: int) -> Frame:
    """Every depth tells where it is; the label is that of its row's or column's parity."""
    rows, columns = np.mgrid[:height, :width]
    rgb = RNG.integers(0, 256, (height, width, 3), dtype=np.uint8)
    labels = np.where((rows + columns) % 2, 7, 9)
    return Frame(rgb, (rows * 256 + columns).astype(np.uint16), labels.astype(np.uint8))


def _overlaps(length: int, count: int) -> npt.NDArray[np.float64]:
    """Which share of each of `count` equal parts of a line falls on each of its `length` pixels."""
    edges = np.linspace(0, length, count + 1)
    low, high = edges[:-1, None], edges[1:, None]
    pixel = np.arange(length)[None]
    shares: npt.NDArray[np.float64] = (np.minimum(high, pixel + 1) - np.maximum(low, pixel)).clip(0)
    return shares * count / length


@pytest.mark.parametrize("size", [(9, 16), (27, 48), (45, 80), (18, 32)])
def test_colour_is_the_mean_over_a_pixels_area(size: tuple[int, int]) -> None:
    frame = _frame(108, 192)
    expected = np.einsum(
        "ij,jkc,lk->ilc", _overlaps(108, size[0]), frame.rgb.astype(float), _overlaps(192, size[1])
    )
    small = resample(frame, size)
    assert small.size == size
    np.testing.assert_allclose(small.rgb, expected, atol=0.51)


def test_depth_and_label_are_those_under_the_pixels_centre() -> None:
    frame = _frame(108, 192)
    small = resample(frame, (18, 32))
    for row, column in ((0, 0), (5, 7), (17, 31)):
        # centres are at half pixels: (5 + 0.5) * 6 = 33 is the pixel from 33 to 34
        source = (int((row + 0.5) * 6), int((column + 0.5) * 6))
        assert small.depth[row, column] == frame.depth[source]
        assert small.labels[row, column] == frame.labels[source]


def test_the_three_images_stay_aligned() -> None:
    edge = np.zeros((1080, 1920), dtype=bool)
    edge[:, 960:] = True
    frame = Frame(
        np.where(edge[..., None], [0, 0, 200], [200, 0, 0]).astype(np.uint8),
        np.where(edge, 3000, 1000).astype(np.uint16),
        np.where(edge, 100, 7).astype(np.uint8),
    )
    small = resample(frame, (144, 256))
    np.testing.assert_array_equal(small.rgb[..., 2] > 100, small.labels == 100)
    np.testing.assert_array_equal(small.depth == 3000, small.labels == 100)
    assert (small.labels[:, 128:] == 100).all()
    assert (small.labels[:, :128] == 7).all()


@pytest.mark.parametrize(
    ("size", "corner"), [((60, 80), (7, 0)), ((90, 100), (17, 0)), ((45, 120), (0, 20)), ((9, 16), (0, 0))]
)
def test_the_largest_central_part_is_taken(size: tuple[int, int], corner: tuple[int, int]) -> None:
    frame = _frame(*size)
    factor = min(size[0] / 9, size[1] / 16)
    depth = resample(frame, (9, 16)).depth
    first = corner[0] + int(factor / 2), corner[1] + int(factor / 2)
    assert divmod(int(depth[0, 0]), 256) == first
    step = depth[0, 15] % 256 - depth[0, 0] % 256
    assert step == pytest.approx(15 * factor, abs=1)


def test_no_depth_and_no_id_arises_that_was_not_there() -> None:
    frame = _frame(50, 70)
    for size in ((13, 17), (90, 160)):
        other = resample(frame, size)
        assert set(other.labels.ravel()) <= set(frame.labels.ravel())
        assert set(other.depth.ravel()) <= set(frame.depth.ravel())


def test_a_frame_of_the_right_size_is_left_alone() -> None:
    frame = _frame(9, 16)
    assert resample(frame, (9, 16)) is frame


def test_metres_become_counts_of_a_65535th_of_a_kilometre() -> None:
    metres = np.array([[0.0, 0.0152590219, 999.99, 1e30, -5.0]], dtype=np.float32)
    assert counts_of_metres(metres).tolist() == [[0, 1, 65534, 65535, 0]]


def test_ids_of_classes_and_of_none_pass_and_all_others_do_not() -> None:
    allowed = {*CARLA_IDS.values(), *IDS_OF_NO_CLASS.values()}
    assert len(allowed) == 32
    for number in range(256):
        labels = np.array([[7, number]], dtype=np.uint8)
        if number in allowed:
            assert SYNDRONE.labels(labels, "x") is labels
        else:
            with pytest.raises(DataError, match=rf"image x must hold .* got {number};"):
                SYNDRONE.labels(labels, "x")


PICTURES: dict[str, tuple[str, npt.NDArray[Any]]] = {
    COLOUR_JPEG: (".jpg", np.full((6, 8, 3), 90, dtype=np.uint8)),
    COLOUR_PNG: (".png", RNG.integers(0, 256, (6, 8, 3), dtype=np.uint8)),
    DEPTH_PNG: (".png", RNG.integers(0, 65536, (6, 8), dtype=np.uint16)),
    LABEL_PNG: (".png", RNG.integers(0, 256, (6, 8), dtype=np.uint8)),
}


def _file(kind: str) -> bytes:
    suffix, array = PICTURES[kind]
    return bytes(cv2.imencode(suffix, array)[1])


@pytest.mark.parametrize("kind", KINDS)
def test_a_picture_is_read_as_what_it_is_and_refused_as_anything_else(kind: str) -> None:
    pixels = picture(_file(kind), "x", [kind])
    assert pixels.dtype == PICTURES[kind][1].dtype
    np.testing.assert_allclose(pixels, PICTURES[kind][1], atol=1 if kind == COLOUR_JPEG else 0)
    for other in set(KINDS) - {kind}:
        with pytest.raises(DataError, match=rf"image x must be of the kind {other}, got {kind}"):
            picture(_file(kind), "x", [other])


def test_a_grey_jpeg_is_no_colour() -> None:
    grey = bytes(cv2.imencode(".jpg", PICTURES[LABEL_PNG][1])[1])
    with pytest.raises(DataError, match="got 8-bit greyscale JPEG"):
        picture(grey, "x", [COLOUR_JPEG])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [0.3, 0.5, 0.95])
def test_a_truncated_picture_is_refused(kind: str, share: float) -> None:
    data = _file(kind)
    with pytest.raises(DataError, match="image x must be a whole picture, got a damaged one: it ends"):
        picture(data[: int(len(data) * share)], "x", [kind])


@pytest.mark.parametrize("kind", [COLOUR_PNG, DEPTH_PNG, LABEL_PNG])
def test_a_damaged_png_is_refused_wherever_the_damage_is(kind: str) -> None:
    data = _file(kind)
    for place in range(26, len(data) - 4, 5):
        spoiled = bytearray(data)
        spoiled[place] ^= 0x55
        with pytest.raises(DataError, match="image x must be a whole picture"):
            picture(bytes(spoiled), "x", [kind])


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


_SIGNATURE = b"\x89PNG\r\n\x1a\n"


def test_a_png_whose_pixels_cannot_be_unpacked_is_refused() -> None:
    header = struct.pack(">IIBBBBB", 4, 4, 8, 0, 0, 0, 0)
    data = _SIGNATURE + _chunk(b"IHDR", header) + _chunk(b"IDAT", b"nothing") + _chunk(b"IEND", b"")
    with pytest.raises(DataError, match="the decoder gives up"):
        picture(data, "x", [LABEL_PNG])


@pytest.mark.parametrize(("data", "what"), [(b"", "no data"), (b"hello", "neither JPEG nor PNG")])
def test_what_is_no_picture_is_refused(data: bytes, what: str) -> None:
    with pytest.raises(DataError, match=f"got {what};"):
        picture(data, "x", [LABEL_PNG])
