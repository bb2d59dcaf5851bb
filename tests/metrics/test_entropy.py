import math

import numpy as np
import pytest

from sunset.metrics import normalised_entropy


def test_uniform_logits_have_entropy_one() -> None:
    assert normalised_entropy(np.full((28, 3, 4), 7.5)) == pytest.approx(1.0)


def test_sure_logits_have_entropy_zero() -> None:
    logits = np.zeros((28, 3, 4), dtype=np.float32)
    logits[5] = 1000
    assert normalised_entropy(logits) == 0.0


def test_two_even_classes_of_four_are_half() -> None:
    logits = np.full((4, 1, 1), -1e9)
    logits[:2] = 0
    assert normalised_entropy(logits) == pytest.approx(0.5)  # log 2 / log 4


def test_known_distribution() -> None:
    p = (0.7, 0.2, 0.1)
    expected = -sum(x * math.log(x) for x in p) / math.log(3)
    assert normalised_entropy(np.log(np.array(p)).reshape(3, 1, 1)) == pytest.approx(expected)


def test_entropy_is_over_classes_and_not_over_pixels() -> None:
    # one sure pixel and one that knows nothing: the mean is a half, whatever their order
    logits = np.zeros((3, 1, 2))
    logits[0, 0, 0] = 1000
    assert normalised_entropy(logits) == pytest.approx(0.5)


def test_does_not_change_when_a_number_is_added_to_all_logits() -> None:
    logits = np.random.default_rng(0).normal(size=(28, 5, 6))
    assert normalised_entropy(logits + 1e4) == pytest.approx(normalised_entropy(logits))


def test_higher_temperature_is_less_sure() -> None:
    logits = np.random.default_rng(0).normal(size=(28, 5, 6))
    assert normalised_entropy(logits, temperature=2) > normalised_entropy(logits)
    assert normalised_entropy(logits, temperature=2) == pytest.approx(normalised_entropy(logits / 2))


@pytest.mark.parametrize("shape", [(28,), (28, 3), (1, 3, 4), (28, 0, 4), (2, 28, 3, 4)])
def test_other_shapes_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="shape"):
        normalised_entropy(np.zeros(shape))


def test_temperature_zero_is_refused() -> None:
    with pytest.raises(ValueError, match="greater than 0"):
        normalised_entropy(np.zeros((2, 1, 1)), temperature=0)
