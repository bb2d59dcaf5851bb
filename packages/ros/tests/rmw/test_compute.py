import pytest

from sunset_ros.errors import InvalidInputError, MiddlewareError
from sunset_ros.rmw.sim._network import ComputeModel


def draw(seed: int, node: str, count: int, jitter: float = 0.1) -> list[int]:
    sampler = ComputeModel({"camera": 0.002, "depth": 0.002}, jitter, seed).sampler(node)
    assert sampler is not None
    return [sampler() for _ in range(count)]


def test_durations_vary_uniformly_within_the_jitter() -> None:
    durations = draw(1, "camera", 2000)
    assert 1_800_000 <= min(durations) < 1_805_000
    assert 2_195_000 < max(durations) <= 2_200_000
    assert sum(durations) / len(durations) == pytest.approx(2_000_000, rel=0.01)


def test_durations_depend_on_seed_and_node_only() -> None:
    assert draw(1, "camera", 5) == draw(1, "camera", 5)
    assert draw(1, "camera", 5) != draw(2, "camera", 5)
    assert draw(1, "camera", 5) != draw(1, "depth", 5)


def test_without_jitter_durations_are_exact() -> None:
    assert set(draw(3, "camera", 10, jitter=0.0)) == {2_000_000}


def test_a_node_that_comes_back_continues_its_stream() -> None:
    model = ComputeModel({"camera": 0.002}, 0.1, 1)
    first, second = model.sampler("camera"), model.sampler("camera")
    assert first is not None
    assert second is not None
    assert [first(), second(), first()] == draw(1, "camera", 3)


def test_a_node_that_is_not_listed_has_no_sampler() -> None:
    assert ComputeModel({"camera": 0.002}, 0.1, 1).sampler("monitor") is None


@pytest.mark.parametrize("seconds", [-0.001, float("nan"), float("inf")])
def test_durations_must_be_possible(seconds: float) -> None:
    with pytest.raises(MiddlewareError, match=r"node 'camera' must be at least 0 s, got"):
        ComputeModel({"camera": seconds}, 0.1, 1)


@pytest.mark.parametrize("jitter", [-0.1, 1.0, float("nan")])
def test_jitter_must_be_in_range(jitter: float) -> None:
    with pytest.raises(MiddlewareError, match=r"must be in \[0, 1\), got"):
        ComputeModel({}, jitter, 1)


def test_the_seed_must_be_valid() -> None:
    with pytest.raises(InvalidInputError, match="seed"):
        ComputeModel({}, 0.1, -1)


def test_a_node_of_the_same_name_elsewhere_has_no_part_in_it() -> None:
    model = ComputeModel({"/managed/camera": 0.002}, 0.1, 1)
    assert model.sampler("/other/camera") is None
    assert model.sampler("/managed/camera") is not None
