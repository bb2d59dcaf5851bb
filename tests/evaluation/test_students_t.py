import pytest

from sunset.evaluation.students_t import CONFIDENCES, quantile, quantiles


# from printed tables of Student's t, two-sided 5 %
@pytest.mark.parametrize(
    ("degrees", "t"),
    [
        (1, 12.706),
        (2, 4.303),
        (3, 3.182),
        (4, 2.776),
        (5, 2.571),
        (9, 2.262),
        (26, 2.056),
        (30, 2.042),
        (31, 2.040),
        (53, 2.006),
        (100, 1.984),
        (161, 1.975),
        (1000, 1.962),
    ],
)
def test_quantiles_are_those_of_the_tables(degrees: int, t: float) -> None:
    assert quantile(degrees) == pytest.approx(t, abs=6e-4)


# likewise, two-sided 20 %, 1 % and 0.1 %
@pytest.mark.parametrize(
    ("degrees", "fifth", "hundredth", "thousandth"),
    [
        (1, 3.078, 63.657, 636.619),
        (2, 1.886, 9.925, 31.599),
        (8, 1.397, 3.355, 5.041),
        (40, 1.303, 2.704, 3.551),
    ],
)
def test_quantiles_of_every_confidence_are_those_of_the_tables(
    degrees: int, fifth: float, hundredth: float, thousandth: float
) -> None:
    found = quantiles(degrees)
    for p, t in ((0.2, fifth), (0.01, hundredth), (0.001, thousandth)):
        place = CONFIDENCES.searchsorted(1 - p)
        assert found[place - 1] * 0.999 <= t <= found[place] * 1.001
        assert found[place] / found[place - 1] < 1.06  # so close are the confidences


def test_between_whole_degrees_quantiles_fall_from_one_to_the_next() -> None:
    assert quantile(3) < quantile(2.5) < quantile(2)
    assert (quantiles(3)[:] < quantiles(2.5)[:]).all()
    assert quantile(30.001) == pytest.approx(float(quantile(30)), abs=1e-4)
