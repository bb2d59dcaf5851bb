from itertools import combinations

import numpy as np
import pytest

from sunset_town import TOWNS, TownError
from sunset_town.layout import BlockKind, plan_town


def test_a_town_number_gives_the_same_plan_every_time() -> None:
    assert plan_town(3) == plan_town(3)


def test_no_two_towns_share_their_streets() -> None:
    plans = [plan_town(number) for number in TOWNS]
    for one, other in combinations(plans, 2):
        assert not {street.at for street in one.streets[1:]} & {
            street.at for street in other.streets[1:] if street.at > -400
        }


@pytest.mark.parametrize("number", TOWNS)
def test_every_town_has_every_kind_of_block_and_an_avenue(number: int) -> None:
    plan = plan_town(number)
    assert {block.kind for block in plan.blocks} == set(BlockKind)
    assert any(street.avenue for street in plan.streets)
    assert all(min(block.size) > 10 for block in plan.blocks)


@pytest.mark.parametrize("number", [0, 9, -1])
def test_an_unknown_town_is_named_in_the_error(number: int) -> None:
    with pytest.raises(TownError, match=rf"from 1 to 8, got {number}"):
        plan_town(number)


def test_headings_follow_the_bent_grid() -> None:
    warp = plan_town(1).warp
    u = np.linspace(-200, 200, 2001)
    line = warp.points(np.column_stack([u, np.full_like(u, 30.0)]))
    measured = np.arctan2(np.diff(line[:, 1]), np.diff(line[:, 0]))
    stated = warp.headings(np.column_stack([(u[1:] + u[:-1]) / 2, np.full(len(u) - 1, 30.0)]), 0)
    np.testing.assert_allclose(stated, measured, atol=1e-4)


def test_closed_stretches_make_junctions_of_three_arms() -> None:
    for number in TOWNS:
        plan = plan_town(number)
        assert len(plan.closed) > 5
        lost: list[tuple[float, float]] = []
        for street in plan.streets:
            crossings = [other.at for other in plan.crossings(street)]
            for axis, at, start in plan.closed:
                if (axis, at) == (street.axis, street.at):
                    ends = start, crossings[crossings.index(start) + 1]
                    lost += [(end, at) if axis == 0 else (at, end) for end in ends]
        assert len(lost) == len(set(lost)) == 2 * len(plan.closed)


def test_blocks_do_not_overlap() -> None:
    for number in TOWNS:
        for one, other in combinations(plan_town(number).blocks, 2):
            apart = np.maximum(np.subtract(one.low, other.high), np.subtract(other.low, one.high))
            assert apart.max() >= 0


def test_warping_stretches_the_grid_by_little() -> None:
    for number in TOWNS:
        warp = plan_town(number).warp
        grid = np.stack(np.meshgrid(np.arange(-300, 300, 20.0), np.arange(-300, 300, 20.0)), axis=-1)
        for step in ((1.0, 0.0), (0.0, 1.0)):
            lengths = np.linalg.norm(warp.points(grid + step) - warp.points(grid), axis=-1)
            assert lengths.min() > 0.9
            assert lengths.max() < 1.1
