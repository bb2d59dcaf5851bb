"""The costs of a run's decisions, added up."""

from sunset.metrics import Cost, RunMetrics, Timeline, score


def with_costs(*costs: Cost) -> RunMetrics:
    return score(Timeline(thresholds={"entropy_threshold": 0.2, "sharpness_threshold": 0.1}, costs=costs))


def test_costs_are_sums_until_the_end_of_the_measured_time() -> None:
    metrics = with_costs(
        Cost(-1.0, "tiny", 100, 2, 0.25),
        Cost(3.0, "large", 50, 1, 0.5),
        Cost(3.0, think_s=1.5),
        Cost(9.0, "tiny", 7, 1),
        Cost(20.0, "late", 1000, 1000, 1.0, 9.0),
    )
    assert (metrics.tokens_in, metrics.tokens_out, metrics.price, metrics.think_s) == (157, 4, 0.75, 1.5)
    assert metrics.models_asked == ("tiny", "large")


def test_a_run_without_costs_has_no_figures_of_them() -> None:
    metrics = with_costs()
    assert {metrics.tokens_in, metrics.tokens_out, metrics.price, metrics.think_s} == {None}
    assert metrics.models_asked == ()


def test_a_sum_stays_in_the_range_of_figures() -> None:
    assert with_costs(Cost(1.0, price=10.0**6), Cost(2.0, price=10.0**6)).price == 10**6
