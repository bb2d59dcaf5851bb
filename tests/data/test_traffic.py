import numpy as np
import pytest

from sunset.data.layout import plan_town
from sunset.data.traffic import HALF_M, KINDS, Traffic, make_traffic


@pytest.fixture(scope="module")
def traffic() -> Traffic:
    return make_traffic(plan_town(1))


def test_everything_that_can_move_is_on_the_road(traffic: Traffic) -> None:
    assert {KINDS[kind] for kind in traffic.kinds} == set(KINDS)


def test_movers_travel_at_their_speed_in_their_heading(traffic: Traffic) -> None:
    before, headings = traffic.poses(3.0)
    after, _ = traffic.poses(3.05)
    delta = (after - before)[:, :2].astype(np.float64)
    stays = np.linalg.norm(delta, axis=1) < 5
    assert stays.mean() > 0.99
    moved = np.linalg.norm(delta[stays], axis=1)
    np.testing.assert_allclose(moved, np.abs(traffic.speeds[stays]) * 0.05, rtol=0.12)
    along = delta[stays, 0] * np.cos(headings[stays]) + delta[stays, 1] * np.sin(headings[stays])
    assert (along > 0.98 * moved).all()


def test_movers_go_round_and_round(traffic: Traffic) -> None:
    index = int(np.argmax(np.abs(traffic.speeds)))
    period = 2 * HALF_M / abs(float(traffic.speeds[index]))
    np.testing.assert_allclose(traffic.poses(0.0)[0][index], traffic.poses(period)[0][index], atol=0.01)


def test_vehicles_keep_to_the_right(traffic: Traffic) -> None:
    plan = traffic.plan
    for street in plan.streets:
        on = (traffic.axes == street.axis) & (np.abs(traffic.across - street.at) < street.width / 2)
        offsets = (traffic.across[on] - street.at) * np.sign(traffic.speeds[on])
        assert (offsets < 0).all() if street.axis == 0 else (offsets > 0).all()


def test_only_the_chosen_become_a_mesh(traffic: Traffic) -> None:
    positions, headings = traffic.poses(0.0)
    none = np.zeros(len(traffic.kinds), dtype=np.bool_)
    assert len(traffic.mesh(positions, headings, none)) == 0
    one = none.copy()
    one[7] = True
    points = traffic.mesh(positions, headings, one).triangles.reshape(-1, 3)
    assert np.linalg.norm((points - positions[7])[:, :2], axis=1).max() < 12
