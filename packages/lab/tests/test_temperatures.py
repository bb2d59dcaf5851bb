import numpy as np
import pytest

from sunset.calibration import separate
from sunset.errors import DataError
from sunset.metrics import normalised_entropy
from sunset_lab.architecture import upsampling

pytestmark = pytest.mark.thorough

pytest.importorskip("onnx")

from sunset_lab.calibrate import temperature_for  # noqa: E402  needs onnx


def test_the_temperature_gives_the_entropy_that_was_asked_for() -> None:
    rng = np.random.default_rng(0)
    constant = [
        np.repeat(np.repeat(rng.normal(0, 6, (28, 1, 1)), 72, 1), 128, 2).astype(np.float32) for _ in range(3)
    ]
    temperature = temperature_for(constant, 0.3, 256)
    entropies = [normalised_entropy(logits, temperature=temperature) for logits in constant]
    assert np.mean(entropies) == pytest.approx(0.3, abs=1e-4)


def test_an_entropy_out_of_reach_is_refused() -> None:
    with pytest.raises(DataError, match=r"No temperature from 0\.05 to 20\.0"):
        temperature_for([np.zeros((28, 72, 128), dtype=np.float32)], 0.3, 256)


@pytest.mark.parametrize("shape", [(72, 128), (288, 512)])
def test_logits_are_interpolated_to_the_width_of_the_frames(shape: tuple[int, int]) -> None:
    low = np.random.default_rng(0).normal(0, 6, (28, *shape)).astype(np.float32)
    factor = 512 // shape[1]
    temperature = temperature_for([low], 0.3, 512)
    whole = upsampling(shape[0], factor) @ low @ upsampling(shape[1], factor).T
    assert normalised_entropy(whole, temperature=temperature) == pytest.approx(0.3, rel=0.003)


def test_sets_that_do_not_overlap_are_parted_without_error_in_the_middle() -> None:
    parted = separate([np.array([1.0, 2.0]), np.array([3.0])], [np.array([7.0, 9.0])])
    assert (parted.threshold, parted.false_alarms, parted.misses) == (5.0, 0.0, 0.0)


def test_overlapping_sets_share_the_error() -> None:
    low, high = np.arange(10.0), np.arange(8.0, 18.0)
    parted = separate([low], [high])
    assert parted.false_alarms == pytest.approx(0.1)
    assert parted.misses == pytest.approx(0.1)


def test_a_small_set_counts_as_much_as_a_large_one() -> None:
    parted = separate([np.linspace(0, 1, 1000), np.array([2.0])], [np.array([3.0])])
    assert 2 < parted.threshold < 3
