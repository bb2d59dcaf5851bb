import pytest

from sunset.evaluation.intervals import quantile, within

TABLE = [
    (2, 1.886, 4.303, 9.925, 31.599),
    (3, 1.638, 3.182, 5.841, 12.924),
    (8, 1.397, 2.306, 3.355, 5.041),
    (30, 1.310, 2.042, 2.750, 3.646),
    (40, 1.303, 2.021, 2.704, 3.551),
    (1000, 1.282, 1.962, 2.581, 3.300),
]
"""Printed tables of Student's t: degrees of freedom, and the quantiles of 80, 95, 99 and 99.9 %, two-sided."""


@pytest.mark.parametrize("row", TABLE)
def test_quantiles_and_probabilities_are_those_of_the_tables(row: tuple[float, ...]) -> None:
    degrees, *quantiles = row
    for confidence, t in zip((0.8, 0.95, 0.99, 0.999), quantiles, strict=True):
        assert quantile(confidence, degrees) == pytest.approx(t, abs=6e-4)
        assert within(t, degrees) == pytest.approx(confidence, abs=2e-4)


def test_between_whole_degrees_they_are_those_of_scipy() -> None:
    t = pytest.importorskip("scipy.stats").t
    for degrees in (2.0, 2.5, 7.3, 161.0, 1e5):
        assert quantile(0.95, degrees) == pytest.approx(t.ppf(0.975, degrees), rel=1e-9)
        assert within(3.0, degrees) == pytest.approx(1 - 2 * t.sf(3.0, degrees), abs=1e-9)


def test_nothing_is_within_0_and_all_within_infinity() -> None:
    assert within(0.0, 3.0) == 0
    assert within(float("inf"), 3.0) == pytest.approx(1)
