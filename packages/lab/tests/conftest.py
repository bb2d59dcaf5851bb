import numpy as np
import pytest
from tests.cli.conftest import complaint
from tests.conftest import flight

from sunset_lab import FrameSet
from sunset_lab.frames import FrameSets

__all__ = ["complaint", "flight", "sets"]  # the first two are fixtures of other tests, too


def painted(count: int, seed: int) -> FrameSet:
    """Frames of rectangles: a class's colour and depth are always the same."""
    rng = np.random.default_rng(seed)
    colours = np.random.default_rng(99).integers(0, 256, (28, 3), dtype=np.uint8)
    labels = np.zeros((count, 144, 256), dtype=np.uint8)
    for image in labels:
        for _ in range(25):
            top, left = rng.integers(0, 120), rng.integers(0, 220)
            image[top : top + 30, left : left + 45] = rng.integers(0, 28)
    return FrameSet(colours[labels], 2500 + 60 * labels.astype(np.uint16), labels)


@pytest.fixture(scope="session")
def sets() -> FrameSets:
    return FrameSets(*(painted(12, seed) for seed in range(4)))
