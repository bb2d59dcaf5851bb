"""Many vectors as an array (N, 3) in Fortran's order: each component is contiguous, which is faster in numpy."""

import numpy as np
import numpy.typing as npt

from sunset_town.frame import Reals

Rows = npt.NDArray[np.integer]


def dot(vectors: Reals, axis: Reals) -> Reals:
    """Return the products (N,) of vectors (N, 3) with vectors (N, 3) or a vector (3,), added in a fixed order."""
    result: Reals = vectors[:, 0] * axis[..., 0] + vectors[:, 1] * axis[..., 1] + vectors[:, 2] * axis[..., 2]
    return result


def scaled(vector: Reals, factors: Reals) -> Reals:
    """Return a vector (3,) times each of the factors (N,), as (N, 3)."""
    return np.multiply.outer(vector, factors).T


def pick(vectors: Reals, rows: Rows) -> Reals:
    """Return the vectors (M, 3) of the given rows (M,), a copy."""
    return vectors.T.take(rows, axis=1).T
