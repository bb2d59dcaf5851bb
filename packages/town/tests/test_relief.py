import numpy as np
import pytest

from sunset_town.layout import TownPlan, plan_town
from sunset_town.town import make_terrain


@pytest.fixture(scope="module", params=[1, 6])
def plan(request: pytest.FixtureRequest) -> TownPlan:
    return plan_town(request.param)


def test_the_town_rolls_gently_and_hills_rise_around_it(plan: TownPlan) -> None:
    u, v = np.meshgrid(np.arange(-300, 301, 5.0), np.arange(-300, 301, 5.0))
    heights = plan.relief.streets(np.stack([u, v], axis=-1))
    assert 2 < np.ptp(heights) < 20
    assert np.abs(np.diff(heights, axis=0)).max() / 5 < 0.2
    ring = np.linspace(0, 2 * np.pi, 60)
    hills = plan.relief.streets(1150 * np.column_stack([np.cos(ring), np.sin(ring)]))
    assert np.median(hills) > 25
    assert plan.relief.streets((0.0, 0.0)) == pytest.approx(0)


def test_the_river_is_level_below_its_banks_and_below_its_bridges(plan: TownPlan) -> None:
    u = np.arange(-300.0, 300.0, 7.0)
    middle = plan.river_points(u)
    water = plan.relief.ground(middle[np.abs(u - plan.relief.rail) > 20])
    assert np.ptp(water) == 0
    bank = middle + np.array([0.0, plan.relief.river_width / 2 + 5])
    drop = plan.relief.streets(bank) - water[0]
    assert drop.min() > 1
    assert drop.max() < 4
    for street in plan.streets:
        if street.axis == 1 and abs(street.at) < 300:
            deck = plan.relief.streets(plan.river_points(street.at))
            assert deck - water[0] > 1


def test_the_railway_has_one_grade_and_streets_pass_under_it(plan: TownPlan) -> None:
    v = np.arange(-300.0, 300.0, 3.0)
    np.testing.assert_allclose(np.diff(plan.relief.railway(v), 2), 0, atol=1e-9)
    for street in plan.streets:
        if street.axis == 0 and abs(street.at) < 300:
            point = (plan.relief.rail, street.at)
            assert plan.relief.railway(street.at) - plan.relief.streets(point) > 4.2
            assert plan.relief.ground(point) == pytest.approx(plan.relief.streets(point), abs=0.01)
    block = np.array([(plan.relief.rail, street.at + 25.0) for street in plan.streets if street.axis == 0])
    free = block[plan.relief.off_water(block) > 8]
    raised = np.isclose(plan.relief.ground(free), plan.relief.railway(free[:, 1]))
    assert raised.mean() > 0.9


def test_the_mesh_covers_the_ground_to_the_horizon_without_a_gap(plan: TownPlan) -> None:
    terrain = make_terrain(plan)
    assert len(terrain.bare) == len(terrain.mesh) < 80_000
    corners = terrain.mesh.triangles.astype(np.float64)
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]) / 2
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(3000.0**2, rel=0.02)
