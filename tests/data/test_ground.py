import numpy as np
import pytest

from sunset.classes import CARLA_IDS
from sunset.data.ground import SURFACE_LABELS, Ground, Surface, paint_ground, parking_stalls
from sunset.data.layout import BlockKind, TownPlan, plan_town


@pytest.fixture(scope="module")
def plan() -> TownPlan:
    return plan_town(1)


@pytest.fixture(scope="module")
def ground(plan: TownPlan) -> Ground:
    return paint_ground(plan)


def test_every_surface_has_the_id_of_a_class() -> None:
    assert len(SURFACE_LABELS) == len(Surface)
    assert set(SURFACE_LABELS.tolist()) <= set(CARLA_IDS.values())


def test_every_surface_but_none_is_painted_somewhere(ground: Ground) -> None:
    assert set(np.unique(ground.surfaces).tolist()) == set(Surface) - {Surface.FIELD}


def test_street_middles_are_carriageway_and_their_sides_pavement(plan: TownPlan, ground: Ground) -> None:
    carriageway = {Surface.ASPHALT, Surface.MARKING, Surface.RAIL}
    street = min(plan.streets, key=lambda street: abs(street.at))
    along = np.arange(-150.0, 150.0, 0.5)
    middle = plan.warp.points(street.points(along, 0.4))
    assert set(ground.at(middle[:, 0], middle[:, 1]).tolist()) <= carriageway
    side = plan.warp.points(street.points(along, street.width / 2 + 1.5))
    found = ground.at(side[:, 0], side[:, 1])
    assert np.isin(found, (Surface.PAVING, Surface.DECK)).mean() > 0.6
    assert set(found.tolist()) <= carriageway | {Surface.PAVING, Surface.DECK, Surface.KERB}


def test_fields_lie_outside_the_town(ground: Ground) -> None:
    assert ground.at([301.0, -5000.0], [0.0, 301.0]).tolist() == [Surface.FIELD, Surface.FIELD]


def test_parked_cars_fit_their_block(plan: TownPlan) -> None:
    for block in plan.blocks:
        if block.kind is BlockKind.PARKING:
            stalls = parking_stalls(block)
            assert len(stalls) > 5
            assert (stalls > block.low).all()
            assert (stalls < block.high).all()


def test_the_ground_cannot_be_changed(ground: Ground) -> None:
    with pytest.raises(ValueError, match="read-only"):
        ground.surfaces[0, 0] = 1
