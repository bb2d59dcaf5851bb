import numpy as np
import numpy.typing as npt
import pytest

from sunset_town import CARLA_IDS
from sunset_town.buildings import apartment, hall, house, tower
from sunset_town.meshes import Finish, Mesh, blob, box, cylinder, gable, join, place
from sunset_town.seeding import generator
from sunset_town.things import MOVERS, PROPS, THINGS, TREES

WHITE = Finish((1.0, 1.0, 1.0), "building", tinted=True)


def _area(mesh: Mesh) -> float:
    a, b, c = (mesh.triangles[:, corner].astype(np.float64) for corner in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def test_a_box_has_the_area_of_its_faces() -> None:
    assert _area(box((0, 0, 0), (1, 2, 3), WHITE)) == pytest.approx(2 * (1 * 3 + 2 * 3) + 1 * 2)
    assert _area(box((0, 0, 0), (1, 2, 3), WHITE, bottom=True)) == pytest.approx(22)


def test_a_gable_has_two_slopes_and_two_ends() -> None:
    assert _area(gable((10, 6), 0, 4, WHITE, WHITE)) == pytest.approx(2 * 10 * 5 + 2 * 6 * 4 / 2)


def test_a_cylinder_approaches_the_round_one() -> None:
    assert _area(cylinder((2, 2), (0, 5), WHITE, sides=400)) == pytest.approx(
        2 * np.pi * 2 * 5 + np.pi * 4, rel=1e-3
    )


def test_a_smooth_blob_lies_on_its_ellipsoid() -> None:
    mesh = blob(generator(1), (1, 2, 3), (2, 3, 4), WHITE, roughness=0)
    assert len(mesh) == 80
    unit = (mesh.triangles - (1, 2, 3)) / (2, 3, 4)
    np.testing.assert_allclose(np.linalg.norm(unit, axis=-1), 1, atol=1e-5)


def test_placed_copies_are_scaled_then_turned_then_moved_and_tinted() -> None:
    plain = Finish((0.5, 0.5, 0.5), "car")
    mesh = join(box((0, 0, 0), (1, 1, 1), WHITE), box((0, 0, 0), (1, 1, 1), plain))
    copies = place(
        mesh,
        np.array([(10, 20, 30), (0, 0, 0)], dtype=np.float32),
        np.array([np.pi / 2, 0], dtype=np.float32),
        np.array([(2, 1, 3), (1, 1, 1)], dtype=np.float32),
        np.array([(0.1, 0.2, 0.3), (1, 1, 1)], dtype=np.float32),
    )
    assert len(copies) == 2 * len(mesh)
    first: npt.NDArray[np.float32] = copies.triangles[: len(mesh)].reshape(-1, 3)
    np.testing.assert_allclose(first.min(axis=0), (9, 20, 30), atol=1e-5)
    np.testing.assert_allclose(first.max(axis=0), (10, 22, 33), atol=1e-5)
    np.testing.assert_allclose(copies.colours[0], (0.1, 0.2, 0.3))
    np.testing.assert_allclose(copies.colours[len(mesh) - 1], 0.5)
    assert set(copies.labels.tolist()) == {CARLA_IDS["building"], CARLA_IDS["car"]}


def test_nothing_joined_is_an_empty_mesh() -> None:
    assert len(join()) == 0


@pytest.mark.parametrize("name", MOVERS)
def test_everything_that_moves_stands_on_the_ground_and_is_longer_than_wide(name: str) -> None:
    points = MOVERS[name].triangles.reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    assert 0 <= low[2] < 0.6
    if name != "person":
        assert high[0] - low[0] > high[1] - low[1]
    np.testing.assert_allclose(low[1], -high[1], atol=1e-6)


@pytest.mark.parametrize("name", PROPS)
def test_every_prop_stands_on_the_ground(name: str) -> None:
    heights = PROPS[name].triangles[..., 2]
    assert heights.min() >= -0.01 or name == "planter"
    assert heights.max() > 0.5


def test_all_trees_but_the_two_conifers_differ() -> None:
    shapes = {THINGS[f"tree {kind}"].triangles.tobytes() for kind in range(TREES)}
    assert len(shapes) == TREES - 1


@pytest.mark.parametrize("make", [apartment, hall, house, tower])
def test_buildings_keep_within_their_plot_and_below_the_flight(make: object) -> None:
    assert callable(make)
    for seed in range(10):
        points = make(generator(seed), (18.0, 12.0)).triangles.reshape(-1, 3)
        assert np.abs(points[:, :2]).max() < 18 / 2 + 3
        assert points[:, 2].max() < 42
