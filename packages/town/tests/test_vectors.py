"""Vectors kept by component."""

import numpy as np
import pytest

from sunset_town.frame import Reals
from sunset_town.vectors import dot, pick, scaled

ROWS = np.array([3, 0, 3])


@pytest.fixture(params=["C", "F"])
def vectors(request: pytest.FixtureRequest) -> Reals:
    return np.arange(12, dtype=np.float32).reshape(4, 3).copy(order=request.param)


def test_picked_vectors_are_a_copy_kept_by_component(vectors: Reals) -> None:
    picked = pick(vectors, ROWS)
    np.testing.assert_array_equal(picked, [[9, 10, 11], [0, 1, 2], [9, 10, 11]])
    assert picked.flags.f_contiguous
    picked[:] = 0
    assert vectors[3, 0] == 9


def test_products_are_those_of_numpy(vectors: Reals) -> None:
    axis = np.array([1, -2, 3], dtype=np.float32)
    np.testing.assert_array_equal(dot(vectors, axis), vectors @ axis)
    np.testing.assert_array_equal(dot(vectors, vectors), (vectors * vectors).sum(axis=1))
    made = scaled(axis, np.array([2, 5], dtype=np.float32))
    np.testing.assert_array_equal(made, [[2, -4, 6], [5, -10, 15]])
    assert made.flags.f_contiguous
