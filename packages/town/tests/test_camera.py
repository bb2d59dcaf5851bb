import numpy as np
import pytest

from sunset_town.renderer import Pose, rays


def test_the_axes_are_a_right_handed_rotation() -> None:
    axes = Pose(0, 0, 50, 1.1, 0.7, 0.2).axes()
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1)


def test_a_level_camera_facing_east_has_south_on_its_right() -> None:
    right, down, forward = Pose(0, 0, 50, 0, 0).axes()
    np.testing.assert_allclose(right, (0, -1, 0), atol=1e-12)
    np.testing.assert_allclose(down, (0, 0, -1), atol=1e-12)
    np.testing.assert_allclose(forward, (1, 0, 0), atol=1e-12)


def test_rays_advance_one_unit_along_the_line_of_sight() -> None:
    pose = Pose(0, 0, 50, 2.0, 1.0)
    found = rays(pose, (4, 6))
    assert found.shape == (4 * 6 + 5 * 7, 3)
    np.testing.assert_allclose(found @ pose.axes()[2], 1, atol=1e-6)


def test_the_horizontal_view_is_ninety_degrees_wide() -> None:
    pose = Pose(0, 0, 50, 0, 0)
    corners = rays(pose, (4, 6))[4 * 6 :].reshape(5, 7, 3)
    left, right = corners[2, 0], corners[2, -1]
    assert float(left @ right) == pytest.approx(0, abs=1e-6)
    assert left[1] > 0 > right[1]
