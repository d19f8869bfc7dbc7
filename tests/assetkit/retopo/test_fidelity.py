"""The judge of light models: no difference is none, known differences have known figures, and shading counts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from assetkit.retopo.bake import bake
from assetkit.retopo.fidelity import compare_views
from assetkit.retopo.remesh import remeshed
from render.camera import STANDARD_VIEWS
from schemas.evidence import declared
from schemas.model import Model
from tests.assetkit.retopo.things import bumpy_sphere, checkered_cube, picture, with_meshes

PX = 256


def test_a_model_is_like_itself_in_all_views(tmp_path: Path) -> None:
    model = checkered_cube(4)
    views = compare_views(model, model, tmp_path, PX)
    assert set(views) == {view.name for view in STANDARD_VIEWS}
    assert {(v.silhouette_iou, v.colour_error_255) for v in views.values()} == {(1.0, 0.0)}


def test_a_smaller_ball_loses_the_square_of_its_radius(tmp_path: Path) -> None:
    """Seen from afar the silhouettes are circles; the box of the pictures is that of the source."""
    model = bumpy_sphere(4)
    (ball,) = model.meshes
    views = compare_views(model, with_meshes(model, replace(ball, points=0.9 * ball.points)), tmp_path, PX)
    for view in views.values():
        assert view.silhouette_iou == pytest.approx(0.81, abs=0.015)


def test_other_colours_are_noticed_where_the_object_is_and_nowhere_else(tmp_path: Path) -> None:
    model = checkered_cube(4)
    grey = replace(model, textures=(picture("checker", np.full((8, 8, 3), 128, dtype=np.uint8)),))
    views = compare_views(model, grey, tmp_path, PX)
    assert min(view.colour_error_255 for view in views.values()) > 20.0
    assert {view.silhouette_iou for view in views.values()} == {1.0}


def test_pictures_stand_on_the_ground_whatever_is_up_in_the_source(tmp_path: Path) -> None:
    """A slanted object with y up gives the figures of the same object with z up."""
    (ball,) = bumpy_sphere(3).meshes
    egg = replace(ball, points=ball.points * (0.5, 0.7, 1.0), normals=None)
    thin = replace(egg, points=egg.points * (1.0, 1.0, 0.8))
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # z up to y up
    upright = with_meshes(bumpy_sphere(3), egg)
    y_up = replace(upright, up_axis=declared("y", "test"))
    lying = [replace(m, points=m.points @ turn.T) for m in (egg, thin)]
    first = compare_views(upright, with_meshes(upright, thin), tmp_path, PX)
    second = compare_views(with_meshes(y_up, lying[0]), with_meshes(y_up, lying[1]), tmp_path, PX)
    for name, view in first.items():
        assert second[name].silhouette_iou == pytest.approx(view.silhouette_iou, abs=2e-3)


def test_a_normal_map_of_bumps_restores_the_shading_that_the_light_mesh_lost(tmp_path: Path) -> None:
    """By the renderer, which reads the package's maps its own way."""
    model = bumpy_sphere()
    light = remeshed(model.meshes, 600, 512)
    assert not isinstance(light, str)
    baked = bake(model, model.meshes, light, 512)

    def error(result: Model) -> float:
        views = compare_views(model, result, tmp_path, PX)
        return float(np.mean([view.colour_error_255 for view in views.values()]))

    whole = replace(model, meshes=baked.meshes, materials=baked.materials, textures=baked.textures)
    bare = replace(whole, materials=(replace(baked.materials[0], normal_texture=None),))
    with_map, without = error(whole), error(bare)
    assert with_map < 0.5 * without
    assert with_map < 3.0
