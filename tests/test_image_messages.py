"""Messages to arrays and back."""

import copy
import pickle

import numpy as np
import pytest

from sunset.errors import DataError
from sunset.image_messages import (
    array_of_bgr,
    array_of_depth,
    array_of_labels,
    bgr_of,
    depth_of,
    digest_of_data,
    image_of_bgr,
    image_of_depth,
    image_of_labels,
    stamp_ns,
)
from sunset.images import LazyImage, Pixels, digest_of
from sunset.system_interfaces.msg import SensorFusion
from sunset_ros.interfaces import deserialize, serialize
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header

HEADER = Header(stamp=Time(sec=3, nanosec=7), frame_id="camera")
BGR = np.arange(2 * 4 * 3, dtype=np.uint8).reshape(2, 4, 3)
DEPTH = np.array([[0, 1, 256, 65535]], dtype=np.uint16)
LABELS = np.array([[1, 2], [3, 255]], dtype=np.uint8)


def test_arrays_survive_the_way_through_a_message() -> None:
    np.testing.assert_array_equal(array_of_bgr(image_of_bgr(HEADER, BGR)), BGR)
    np.testing.assert_array_equal(array_of_depth(image_of_depth(HEADER, DEPTH)), DEPTH)
    np.testing.assert_array_equal(array_of_labels(image_of_labels(HEADER, LABELS)), LABELS)


def test_messages_say_what_they_hold() -> None:
    image = image_of_bgr(HEADER, BGR)
    assert (image.height, image.width, image.encoding, image.step) == (2, 4, "bgr8", 12)
    assert image_of_depth(HEADER, DEPTH).data.tolist() == [0, 0, 1, 0, 0, 1, 255, 255]
    assert image_of_depth(HEADER, DEPTH).step == 8
    assert image_of_labels(HEADER, LABELS).header == HEADER


def test_nothing_is_copied() -> None:
    image = image_of_bgr(HEADER, BGR)
    assert np.shares_memory(image.data, BGR)
    assert np.shares_memory(array_of_bgr(image), BGR)
    depth = image_of_depth(HEADER, DEPTH)
    assert np.shares_memory(array_of_depth(depth), DEPTH)


def test_a_view_that_is_not_contiguous_is_sent_as_it_looks() -> None:
    image = image_of_bgr(HEADER, BGR[:, ::-1])
    np.testing.assert_array_equal(array_of_bgr(image), BGR[:, ::-1])


def test_padded_rows_and_swapped_bytes_are_read() -> None:
    padded = np.arange(2 * 8, dtype=np.uint8)
    image = Image(height=2, width=2, encoding="bgr8", step=8, data=padded)
    np.testing.assert_array_equal(array_of_bgr(image), padded.reshape(2, 8)[:, :6].reshape(2, 2, 3))
    data = np.array([1, 0, 0, 2], dtype=np.uint8)
    swapped = Image(height=1, width=2, encoding="16UC1", is_bigendian=1, step=4, data=data)
    assert array_of_depth(swapped).tolist() == [[256, 2]]
    assert array_of_depth(swapped).dtype == np.uint16


def test_another_encoding_is_refused() -> None:
    with pytest.raises(DataError, match="encoding bgr8 here, got '16UC1'"):
        array_of_bgr(image_of_depth(HEADER, DEPTH))


def test_missing_bytes_are_noticed() -> None:
    image = image_of_labels(HEADER, LABELS)
    image.data = image.data[:-1]
    with pytest.raises(DataError, match="2 x 2 pixels in rows of 2 bytes cannot have 3 bytes"):
        array_of_labels(image)
    with pytest.raises(DataError, match="rows of 1 bytes"):
        array_of_labels(Image(height=1, width=2, encoding="8UC1", step=1, data=np.zeros(9, np.uint8)))


def test_stamps_are_whole_nanoseconds() -> None:
    assert stamp_ns(HEADER) == 3_000_000_007


def unseen(pixels: Pixels) -> LazyImage:
    def look() -> Pixels:
        raise AssertionError("nobody needs the pixels")

    image = LazyImage(pixels.shape[:2], look, name=lambda: b"", cache=None)
    image.digest = digest_of(pixels)
    return image


def test_an_image_goes_through_messages_without_its_pixels() -> None:
    rgb, depth = unseen(BGR), unseen(DEPTH)
    fused = SensorFusion(rgb=image_of_bgr(HEADER, rgb), depth=image_of_depth(HEADER, depth)).copy()
    assert (bgr_of(fused.rgb), depth_of(fused.depth)) == (rgb, depth)
    assert digest_of_data(fused.depth) == digest_of(DEPTH)
    assert (fused.rgb.height, fused.rgb.width, fused.rgb.step, fused.rgb.header) == (2, 4, 12, HEADER)


def test_whoever_looks_at_a_message_sees_the_pixels() -> None:
    plain = image_of_depth(HEADER, DEPTH)
    message = image_of_depth(HEADER, LazyImage.of(DEPTH))
    assert message.copy() == message == plain == message
    assert message != image_of_depth(HEADER, DEPTH + np.uint16(1))
    assert deserialize(serialize(message), Image) == plain
    assert repr(message) == repr(plain)
    assert pickle.loads(pickle.dumps(message)) == copy.deepcopy(message) == plain  # noqa: S301  our own


def test_assigned_data_replace_the_image() -> None:
    message = image_of_bgr(HEADER, LazyImage.of(BGR))
    message.data = image_of_bgr(HEADER, BGR[::-1]).data
    for each in (message, message.copy()):
        np.testing.assert_array_equal(bgr_of(each).pixels, BGR[::-1])
        assert digest_of_data(each) == digest_of(BGR[::-1])


def test_an_image_of_another_encoding_or_size_is_not_taken_for_it() -> None:
    message = image_of_bgr(HEADER, unseen(BGR))
    with pytest.raises(DataError, match="must have the encoding 16UC1 here, got 'bgr8'"):
        depth_of(message)
    message = image_of_bgr(HEADER, LazyImage.of(BGR))
    message.height = 3
    with pytest.raises(DataError, match="cannot have 24 bytes"):
        bgr_of(message)
    swapped = image_of_depth(HEADER, LazyImage.of(DEPTH))
    swapped.is_bigendian = 1
    np.testing.assert_array_equal(depth_of(swapped.copy()).pixels, DEPTH.byteswap())
