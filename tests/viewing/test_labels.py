"""Labels as a page has them."""

import numpy as np
import pytest
from tests.viewing.unpacking import unpack

from sunset.viewing.pictures import pack_labels


@pytest.mark.parametrize("shape", [(1, 1), (3, 7), (144, 256), (300, 400)])
@pytest.mark.parametrize("classes", [1, 2, 28, 256])
def test_labels_come_back_as_they_were(shape: tuple[int, int], classes: int) -> None:
    generator = np.random.default_rng(3)
    labels = generator.integers(0, classes, shape, dtype=np.uint8)
    labels[: shape[0] // 2] = classes - 1  # more equal pixels than two bytes count, in the largest

    assert np.array_equal(unpack(pack_labels(labels), *shape), labels)


def test_labels_of_a_scene_take_little_space() -> None:
    scene = np.zeros((144, 256), np.uint8)
    scene[40:100, 60:200] = 5

    assert len(pack_labels(scene)) < 300
