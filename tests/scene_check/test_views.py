"""Pixels of the z-buffer, by hand: boxes before a camera, behind others, beside the picture, around the camera."""

from __future__ import annotations

import numpy as np
import pytest

from scene_check.views import pixels_by_object
from schemas.scene.camera_pose import CameraPose
from schemas.scene.geometry import Prism

H = 0.5**0.5
# At the origin, toward +y, z up; 2 x 2 m at a distance of 1 m fill the picture.
CAMERA = CameraPose(position_m=(0.0, 0.0, 0.0), quat_wxyz=(H, H, 0.0, 0.0), fov_deg=90.0, size=(200, 200))


def box(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Prism:
    corners = [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]]
    return Prism(np.array(corners), *z)


WALL = box((-0.5, 0.5), (1.0, 1.2), (-0.5, 0.5))


def test_a_wall_of_a_quarter_of_the_picture():
    assert pixels_by_object(CAMERA, {"wall": [WALL]})["wall"] == 100 * 100


@pytest.mark.parametrize(("right", "left_pixels"), [(-0.3, 10_000), (0.0, 5_000), (0.25, 0)])
def test_what_stands_before_it_hides_it(right: float, left_pixels: int):
    screen = box((-1.0, right), (0.5, 0.6), (-1.0, 1.0))
    assert pixels_by_object(CAMERA, {"wall": [WALL], "screen": [screen]})["wall"] == left_pixels


def test_what_is_behind_or_beside_the_camera_is_not_seen():
    behind, beside = box((-0.5, 0.5), (-2.0, -1.0), (-0.5, 0.5)), box((3.0, 4.0), (1.0, 2.0), (-0.5, 0.5))
    assert pixels_by_object(CAMERA, {"behind": [behind], "beside": [beside]}) == {"behind": 0, "beside": 0}


def test_a_floor_that_passes_under_the_camera_is_cut_where_it_begins():
    floor = box((-50.0, 50.0), (-5.0, 100.0), (-1.0, -0.5))
    assert pixels_by_object(CAMERA, {"floor": [floor]})["floor"] == pytest.approx(200 * 100, rel=0.02)
