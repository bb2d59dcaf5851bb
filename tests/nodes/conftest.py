"""Tiny images for the tests of nodes."""

from collections.abc import Callable

import numpy as np
import pytest

from sunset.image_messages import image_of_bgr, image_of_depth
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header
from sunset_ros.seeding import generator

HEIGHT, WIDTH = 36, 64


def header(stamp: float) -> Header:
    nanoseconds = round(stamp * 1e9)
    time = Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
    return Header(stamp=time, frame_id="camera")


@pytest.fixture
def rgb() -> Callable[[float], Image]:
    """Make a colour image of random pixels, the same for the same stamp in seconds."""

    def make(stamp: float) -> Image:
        rng = generator(round(stamp * 1000), "rgb")
        return image_of_bgr(header(stamp), rng.integers(0, 256, (HEIGHT, WIDTH, 3), dtype=np.uint8))

    return make


@pytest.fixture
def depth() -> Callable[[float], Image]:
    """Make a depth image with both extremes in it."""

    def make(stamp: float) -> Image:
        counts = np.full((HEIGHT, WIDTH), 3000, dtype=np.uint16)
        counts[:, :8], counts[:, -8:] = 0, 65535
        return image_of_depth(header(stamp), counts)

    return make
