import numpy as np
import pytest

from sunset_town import CARLA_IDS
from sunset_town.ground import SURFACE_LABELS, Ground, Surface
from sunset_town.layout import BlockKind, TownPlan, plan_town
from sunset_town.paving import paint_ground, parking_stalls


@pytest.fixture(scope="module")
def plan() -> TownPlan:
    return plan_town(1)


@pytest.fixture(scope="module")
def ground(plan: TownPlan) -> Ground:
    return paint_ground(plan)


def test_every_surface_has_the_id_of_a_class() -> None:
    assert len(SURFACE_LABELS) == len(Surface)
    assert set(SURFACE_LABELS.tolist()) <= set(CARLA_IDS.values())


def test_every_surface_is_painted_somewhere(ground: Ground) -> None:
    painted = np.union1d(np.unique(ground.town.image), np.unique(ground.bare.image))
    assert set(painted.tolist()) == set(Surface)


def test_street_middles_are_carriageway_and_their_sides_pavement(plan: TownPlan, ground: Ground) -> None:
    carriageway = {Surface.ASPHALT, Surface.MARKING}
    through = [street for street in plan.streets if plan.through(street)]
    street = min(through, key=lambda street: abs(street.at))
    along = np.arange(-150.0, 150.0, 0.5)
    middle = plan.warp.points(street.points(along, 0.4))
    assert set(ground.at(middle[:, 0], middle[:, 1]).tolist()) <= carriageway
    side = plan.warp.points(street.points(along, street.width / 2 + 1.5))
    found = ground.at(side[:, 0], side[:, 1])
    assert np.isin(found, (Surface.PAVING, Surface.DECK)).mean() > 0.6
    assert set(found.tolist()) <= carriageway | {Surface.PAVING, Surface.DECK, Surface.KERB}


def test_a_closed_stretch_is_no_street(plan: TownPlan, ground: Ground) -> None:
    axis, at, start = next(iter(sorted(plan.closed, key=lambda closed: abs(closed[1]) + abs(closed[2] + 30))))
    point = plan.warp.points((start + 30, at) if axis == 0 else (at, start + 30))
    assert ground.at(*point) not in (Surface.ASPHALT, Surface.PAVING, Surface.KERB)


def test_below_a_bridge_there_is_water(plan: TownPlan, ground: Ground) -> None:
    for street in plan.streets:
        x, y = plan.warp.points(plan.river_points(street.at))
        if street.axis == 1 and max(abs(x), abs(y)) < 290:
            assert ground.at(x, y) in (Surface.ASPHALT, Surface.MARKING)
            assert ground.at(x, y, bare=True) == Surface.WATER


def test_land_of_many_kinds_lies_around_the_town(ground: Ground) -> None:
    x, y = np.meshgrid(np.arange(-1000.0, 1000.0, 20.0), np.arange(-1000.0, 1000.0, 20.0))
    outside = np.maximum(np.abs(x), np.abs(y)) > 350
    kinds, counts = np.unique(ground.at(x[outside], y[outside]), return_counts=True)
    common = set(kinds[counts > 0.05 * counts.sum()].tolist())
    assert {Surface.CROPS, Surface.STUBBLE, Surface.GRASS, Surface.SHRUBS} <= common
    assert Surface.WATER in kinds
    assert Surface.ASPHALT in kinds


def test_parked_cars_fit_their_block(plan: TownPlan) -> None:
    for block in plan.blocks:
        if block.kind is BlockKind.PARKING:
            stalls = parking_stalls(block)
            assert len(stalls) > 5
            assert (stalls > block.low).all()
            assert (stalls < block.high).all()


def test_the_ground_cannot_be_changed(ground: Ground) -> None:
    with pytest.raises(ValueError, match="read-only"):
        ground.town.image[0, 0] = 1
