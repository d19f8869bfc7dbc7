"""Errors of maps: none for equal surfaces, the known difference for others, each in its own unit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assetkit.retopo.errors import map_errors
from schemas.appearance.material import TextureUse
from schemas.model import Model
from tests.assetkit.retopo.things import checkered_cube, picture


def painted(level: int, tilt: int = 128) -> Model:
    """A cube of one grey level, also its roughness, with a normal map that leans by `tilt`."""
    model = checkered_cube(4)
    one = np.full((4, 4, 3), level, dtype=np.uint8)
    lean = np.full((4, 4, 3), (tilt, 128, 255), dtype=np.uint8)
    material = replace(
        model.materials[0],
        base_color_texture=TextureUse("grey"),
        roughness_texture=TextureUse("grey", "g"),
        normal_texture=TextureUse("lean"),
    )
    return replace(model, materials=(material,), textures=(picture("grey", one), picture("lean", lean)))


def test_equal_surfaces_have_no_errors() -> None:
    model = painted(100)
    errors = map_errors(model, model.meshes, model, model.meshes)
    assert set(errors) == {"base_color", "roughness", "normal"}
    assert max(error.p95 for error in errors.values()) < 0.05


def test_known_differences_have_known_figures() -> None:
    first, second = painted(100), painted(110, tilt=192)
    errors = map_errors(first, first.meshes, second, second.meshes)
    assert errors["base_color"].mean.value == pytest.approx(10.0, abs=0.01)
    assert errors["roughness"].p95 == pytest.approx(10.0, abs=0.01)
    leans = [np.degrees(np.arctan2(level / 127.5 - 1.0, 1.0)) for level in (192, 128)]
    assert errors["normal"].mean.value == pytest.approx(leans[0] - leans[1], abs=0.1)
    assert (errors["normal"].unit, errors["normal"].mean.source) == ("degrees", "measured")


def test_a_surface_turned_by_a_quarter_shows_its_colours_in_the_wrong_place() -> None:
    model = checkered_cube(4)
    (mesh,) = model.meshes
    shifted = replace(model, meshes=(replace(mesh, uvs=(mesh.uvs[0] + np.array([0.25, 0.0], dtype=np.float32),)),))
    assert map_errors(model, model.meshes, shifted, shifted.meshes)["base_color"].mean.value > 50.0
