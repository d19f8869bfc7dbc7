"""Each mode shows what it is there for, at the place where the camera puts it; sheets hold all views."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from render.camera import STANDARD_VIEWS
from render.modes.draw import MODES, draw_mode
from render.modes.physics import inertia_box_m
from render.modes.request import DrawnMass, Mode, ModeRequest, views_around
from render.modes.wire import edges_of
from schemas.appearance.material import Material, TextureUse
from schemas.arrays import FloatArray
from schemas.model import Model
from schemas.physics import CollisionShape
from tests.support.drawn import FRONT, PX, RED, at, box, image, model, upright

SIZE = (0.4, 0.2, 0.6)
PAINTED = model(box(SIZE, at=(0.0, 0.0, 0.3)), materials=(Material("red", base_color=RED),))
FACE = (0.2, 0.05, 0.4)  # of the front, off its middle
edge = st.floats(0.05, 2.0)


def drawn(mode: Mode, folder: Path, content: Model = PAINTED, **more: object) -> dict[str, np.ndarray]:
    folder.mkdir(exist_ok=True)
    request = replace(ModeRequest(mode, content, str(folder), "a box", ("0.4 m",), size_px=PX), **more)
    return {name: np.asarray(Image.open(path)).astype(int) for name, path in draw_mode(request).items()}


def mass_of_box(size: tuple[float, float, float], centre: tuple[float, float, float]) -> DrawnMass:
    a, b, c = np.square(size)
    return DrawnMass("box", 3.0, np.array(centre), 3.0 / 12.0 * np.array([b + c, a + c, a + b]), np.eye(3))


def redness(color: FloatArray) -> float:
    return float(color[0] - color[1:].max())


def test_every_mode_has_a_row() -> None:
    assert set(MODES) == set(get_args(Mode))


@pytest.mark.parametrize("mode", get_args(Mode))
def test_a_picture_of_each_view_and_a_sheet_twice_the_same(mode: Mode, tmp_path: Path) -> None:
    first, second = drawn(mode, tmp_path / "a"), drawn(mode, tmp_path / "b")
    sides = {f"{mode}_{view.name.removeprefix('view_')}" for view in STANDARD_VIEWS}
    assert set(first) == sides | {mode}
    assert all((first[name] == second[name]).all() for name in first)
    assert all(first[name].shape == (PX, PX, 3) for name in sides)
    assert first[mode].shape[1] > 4 * PX
    assert first[mode].shape[0] > PX


def test_beauty_shows_the_material(tmp_path: Path) -> None:
    assert redness(at(drawn("beauty", tmp_path)["beauty_front"], PAINTED, FRONT, FACE)) > 60.0


def test_glass_is_clear_only_where_its_texture_has_glass(tmp_path: Path) -> None:
    """Left half glass, right half a label, before a dark wall."""
    halves = np.zeros((8, 8, 3))
    halves[:, :4] = 255
    glass = Material("glass", transmission=1.0, transmission_texture=TextureUse("halves", channel="r"))
    dark = Material("dark", base_color=(0.01, 0.01, 0.01))
    wall = replace(upright(x=-0.5, material=1), uvs=())
    content = model(upright(), wall, materials=(glass, dark), textures=(image("halves", halves),))
    seen = drawn("beauty", tmp_path, content)["beauty_front"]
    through, label = at(seen, content, FRONT, (0, -0.5, 1.0)).mean(), at(seen, content, FRONT, (0, 0.5, 1.0)).mean()
    assert label > through + 60.0


def test_wire_hides_the_material_and_draws_lines(tmp_path: Path) -> None:
    seen = drawn("wire", tmp_path)["wire_front"]
    assert abs(redness(at(seen, PAINTED, FRONT, FACE))) < 10.0
    diagonal = at(seen, PAINTED, FRONT, (0.2, 0.0, 0.3))  # of the two triangles in front
    assert diagonal.mean() < at(seen, PAINTED, FRONT, FACE).mean() - 8.0


def test_edges_are_counted_once() -> None:
    """Twelve edges and six diagonals; corners of faces that lie at one place are one."""
    mesh = PAINTED.meshes[0]
    edges = edges_of(mesh.points[mesh.triangles])
    assert len(edges) == 18
    lengths = np.sort(np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1))
    assert lengths[:4] == pytest.approx([0.2] * 4)


def test_parts_have_the_colours_of_the_legend(tmp_path: Path) -> None:
    two = model(
        box((0.1, 0.2, 0.2), at=(0, -0.1, 0.1)), box((0.1, 0.2, 0.2), at=(0, 0.1, 0.1)), materials=(Material("m"),)
    )
    part_of = np.repeat([0, 1], 12)
    seen = drawn("parts", tmp_path, two, parts=("left", "right"), part_of=part_of)["parts_front"]
    one, other = (at(seen, two, FRONT, (0.05, y, 0.15)) for y in (-0.1, 0.1))
    assert np.abs(one - other).max() > 60.0
    swapped = drawn("parts", tmp_path, two, parts=("left", "right"), part_of=1 - part_of)["parts_front"]
    assert at(swapped, two, FRONT, (0.05, -0.1, 0.15)) == pytest.approx(other, abs=12.0)


def test_collision_shows_shapes_where_they_are(tmp_path: Path) -> None:
    X_AS = np.eye(4)
    X_AS[2, 3] = 0.45
    shape = CollisionShape("box", (0.41, 0.21, 0.3), X_AS)
    seen = drawn("collision", tmp_path, shapes=(shape,))["collision_front"]
    without = drawn("collision", tmp_path)["collision_front"]
    upper, lower = (0.2, 0.05, 0.5), (0.2, 0.05, 0.1)
    assert np.abs(at(seen, PAINTED, FRONT, upper) - at(without, PAINTED, FRONT, upper)).max() > 30.0
    assert np.abs(at(seen, PAINTED, FRONT, lower) - at(without, PAINTED, FRONT, lower)).max() < 4.0


def test_physics_shows_the_mass_centre_where_it_is(tmp_path: Path) -> None:
    for height in (0.15, 0.45):
        seen = drawn("physics", tmp_path, masses=(mass_of_box(SIZE, (0.0, 0.0, height)),))["physics_front"]
        centre, elsewhere = (0.0, 0.0, height), (0.0, 0.0, 0.6 - height)
        assert redness(at(seen, PAINTED, FRONT, centre)) > 40.0
        assert redness(at(seen, PAINTED, FRONT, elsewhere)) < 20.0


@given(st.tuples(edge, edge, edge))
def test_the_box_of_inertia_of_a_box_is_that_box(size: tuple[float, float, float]) -> None:
    assert inertia_box_m(mass_of_box(size, (0.0, 0.0, 0.0))) == pytest.approx(size)


@given(st.integers(1, 36))
def test_views_go_around(count: int) -> None:
    views = views_around(count)
    assert len({view.name for view in views}) == count
    if count != 4:
        assert {view.azimuth_deg for view in views} == {360.0 * k / count for k in range(count)}
