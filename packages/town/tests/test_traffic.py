import numpy as np
import pytest

from sunset_town.layout import plan_town
from sunset_town.traffic import HALF_M, KINDS, PHASE_S, Traffic, make_traffic

VEHICLES = ("saloon", "hatchback", "van", "truck", "bus")


@pytest.fixture(scope="module")
def traffic() -> Traffic:
    return make_traffic(plan_town(1))


def _vehicles(traffic: Traffic) -> np.ndarray:
    return np.isin(traffic.kinds, [KINDS.index(name) for name in VEHICLES])


def test_everything_that_can_move_is_on_the_road(traffic: Traffic) -> None:
    assert {KINDS[kind] for kind in traffic.kinds} == set(KINDS)


def test_movers_go_forwards_and_never_too_fast(traffic: Traffic) -> None:
    moved = np.zeros(len(traffic.kinds), dtype=bool)
    for time in np.arange(0.5, 2 * PHASE_S, 3.1):
        before, headings = traffic.poses(float(time))
        after, _ = traffic.poses(float(time) + 0.05)
        delta = (after - before)[:, :2].astype(np.float64)
        steps = np.linalg.norm(delta, axis=1)
        walks = steps < 5
        assert walks.mean() > 0.99
        assert np.quantile(steps[walks], 0.999) < 18 * 0.05
        along = delta[:, 0] * np.cos(headings) + delta[:, 1] * np.sin(headings)
        going = walks & (steps > 0.02)
        assert (along[going] > 0.9 * steps[going]).mean() > 0.995
        moved |= going
    assert moved[_vehicles(traffic)].mean() > 0.5


def test_no_two_vehicles_meet(traffic: Traffic) -> None:
    for time in np.arange(0.0, 4 * PHASE_S, 1.3):
        positions, _ = traffic.poses(float(time))
        points = positions[_vehicles(traffic), :2]
        points = points[np.abs(points).max(axis=1) < 300]
        apart = np.linalg.norm(points[:, None] - points[None], axis=-1)
        np.fill_diagonal(apart, 99)
        assert apart.min() > 2


def test_one_axis_stands_while_the_other_goes(traffic: Traffic) -> None:
    for time, standing in ((7.0, 1), (PHASE_S + 7.0, 0)):
        before, after = (traffic.poses(time + late)[0] for late in (0.0, 0.5))
        steps = np.linalg.norm(after - before, axis=1)[: len(traffic.hops.axes)]
        assert steps[traffic.hops.axes == standing].max() == 0
        assert (steps[traffic.hops.axes != standing] > 0.3).mean() > 0.2


def test_walkers_come_round_again_and_trains_too(traffic: Traffic) -> None:
    rounds = traffic.rounds
    period = 2 * rounds.size[5].sum() / abs(rounds.speeds[5])
    np.testing.assert_allclose(rounds.places(0.0)[0][5], rounds.places(period)[0][5], atol=1e-6)
    trains = traffic.trains
    period = 2 * HALF_M / abs(trains.speeds[0])
    np.testing.assert_allclose(trains.places(0.0)[0], trains.places(period)[0], atol=1e-6)


def test_vehicles_keep_to_the_right(traffic: Traffic) -> None:
    hops = traffic.hops
    for street in traffic.plan.streets:
        on = (hops.axes == street.axis) & (np.abs(hops.across - street.at) < street.width / 2)
        on &= hops.signs != 0
        offsets = (hops.across[on] - street.at) * hops.signs[on]
        assert (offsets < 0).all() if street.axis == 0 else (offsets > 0).all()


def test_everything_stands_on_its_street_and_trains_above(traffic: Traffic) -> None:
    positions, _ = traffic.poses(11.0)
    carriages = traffic.kinds == KINDS.index("carriage")
    assert positions[carriages, 2].min() > 4
    near = np.abs(positions[:, :2]).max(axis=1) < 300
    assert np.abs(positions[near & ~carriages, 2]).max() < 15


def test_only_the_chosen_become_a_mesh(traffic: Traffic) -> None:
    positions, headings = traffic.poses(0.0)
    none = np.zeros(len(traffic.kinds), dtype=np.bool_)
    assert len(traffic.mesh(positions, headings, none)) == 0
    one = none.copy()
    one[7] = True
    mesh = traffic.mesh(positions, headings, one)
    points = mesh.triangles.reshape(-1, 3)
    assert np.linalg.norm((points - positions[7])[:, :2], axis=1).max() < 12
