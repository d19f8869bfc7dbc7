"""Bodies of assets: prisms hold the shapes in any orientation; places are those that collision shapes leave free."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geom.convex.hull import hull_shape
from geom.convex.support_function import surface
from geom.pose import matrix_of, pose
from scenec.bind.asset_library import AssetLibrary, swing_and_yaw
from scenec.bind.prisms import prisms_between, scaled, stance_of
from schemas.diagnostics import InvalidInput
from schemas.physics import CollisionShape, ShapeKind
from schemas.scene.geometry import Stance
from schemas.scene.program import AuthoredPolygon, BoxAsset, CylinderAsset, FixedAsset
from tests.support.scene import library as scene_library

QUATS = st.integers(0, 10**6).map(lambda seed: np.roll(Rotation.random(rng=np.random.default_rng(seed)).as_quat(), 1))
SIZES = st.floats(0.01, 0.5)
KINDS: tuple[ShapeKind, ...] = get_args(ShapeKind)


@st.composite
def shapes(draw: st.DrawFn) -> CollisionShape:
    """One shape of any kind anywhere."""
    kind = draw(st.sampled_from(KINDS))
    X_AS = pose(matrix_of(draw(QUATS)), (draw(SIZES), draw(SIZES), draw(SIZES)))
    if kind == "hull":
        points = np.random.default_rng(draw(st.integers(0, 10**6))).normal(size=(20, 3)) * 0.1
        shape = hull_shape(points)
        assert shape is not None
        return shape
    count = {"box": 3, "sphere": 1}.get(kind, 2)
    return CollisionShape(kind, tuple(draw(SIZES) for _ in range(count)), X_AS)


def quat_of(quat: np.ndarray) -> tuple[float, float, float, float]:
    w, x, y, z = (float(q) for q in quat)
    return w, x, y, z


@settings(max_examples=150, deadline=None)
@given(shapes(), QUATS)
def test_a_prism_holds_its_shape_tightly_in_any_orientation(shape: CollisionShape, quat: np.ndarray):
    stance = stance_of([shape], quat_of(quat), "any")
    points = surface(shape)[0] @ matrix_of(quat).T
    (prism,) = stance.prisms
    outline = shapely.Polygon(prism.outline_m)
    assert outline.buffer(1e-9).contains(shapely.MultiPoint(points[:, :2]))
    assert outline.area <= 1.02 * shapely.MultiPoint(points[:, :2]).convex_hull.area
    over = points[:, 2] + stance.origin_height_m
    assert over.min() >= -1e-9
    assert over.max() <= prism.high_m + 1e-9
    assert over.max() - over.min() >= 0.98 * prism.high_m
    assert shapely.LinearRing(prism.outline_m).is_ccw


@settings(max_examples=60, deadline=None)
@given(shapes(), QUATS, st.floats(0.2, 5.0))
def test_a_scaled_shape_has_scaled_prisms(shape: CollisionShape, quat: np.ndarray, scale: float):
    def figures(stance: Stance) -> np.ndarray:
        (prism,) = stance.prisms
        outline = shapely.Polygon(prism.outline_m)
        return np.array([*outline.bounds, np.sqrt(outline.area), prism.high_m, stance.origin_height_m])

    once, larger = (stance_of([s], quat_of(quat), "any") for s in (shape, scaled(shape, scale)))
    assert np.allclose(figures(larger), scale * figures(once), rtol=1e-9, atol=1e-9)


@settings(max_examples=60, deadline=None)
@given(shapes(), st.floats(0.1, 0.9), st.floats(0.1, 0.9))
def test_a_piece_between_two_heights_holds_what_lies_there(shape: CollisionShape, one: float, other: float):
    points = surface(shape)[0]
    bottom, top = points[:, 2].min(), points[:, 2].max()
    low, high = (bottom + share * (top - bottom) for share in sorted((one, other)))
    i, j = np.random.default_rng(0).integers(0, len(points), (2, 40))
    corners = np.concatenate([points[i] + share * (points[j] - points[i]) for share in (0.25, 0.5)])
    there = corners[(corners[:, 2] > low) & (corners[:, 2] < high)]
    prisms = prisms_between([shape], low, high)
    outlines = shapely.union_all([shapely.Polygon(prism.outline_m).buffer(1e-9) for prism in prisms])
    assert all(outlines.contains(shapely.Point(p[:2])) for p in there)
    whole = shapely.MultiPoint(points[:, :2]).convex_hull
    assert outlines.area <= 1.02 * whole.area + 1e-9


@given(QUATS)
def test_an_orientation_is_a_swing_and_then_a_heading(quat: np.ndarray):
    swing, yaw = swing_and_yaw(quat.tolist())
    about_z = matrix_of(np.array([np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw)]))
    assert np.allclose(about_z @ matrix_of(np.array(swing)), matrix_of(quat), atol=1e-9)
    assert abs(swing[3]) < 1e-9


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> AssetLibrary:
    return AssetLibrary(scene_library.library(tmp_path_factory.mktemp("library"), cubes=0))


BIN = FixedAsset(type="fixed", id="bin")


def test_a_package_has_its_places_at_its_scale(library: AssetLibrary):
    for scale in (1.0, 2.0):
        floor = library.surface(BIN, scale, "auto", "floor")
        inside = library.volume(BIN, scale, "auto", "inside")
        assert floor is not None
        assert inside is not None
        assert np.isclose(floor.polygon.area, 0.18 * 0.13 * scale**2)
        assert np.isclose(floor.origin_P_m[2], 0.01 * scale)
        assert np.isclose(inside.height_m, 0.07 * scale)
        assert np.isclose(library.body(BIN, scale).mass_kg or 0.0, (library.body(BIN).mass_kg or 0.0) * scale**3)
    assert library.surface(BIN, 1.0, "no_such", "x") is None


def test_a_drawn_floor_is_raised_to_what_the_colliders_carry(library: AssetLibrary):
    square = ((-0.05, -0.05), (0.05, -0.05), (0.05, 0.05), (-0.05, 0.05))
    for z, carried in ((0.01, 0.01), (0.007, 0.01), (0.0, 0.0), (0.03, 0.03)):
        floor = library.surface(BIN, 1.0, AuthoredPolygon(outline=square, z=z, height=0.05), "drawn")
        assert floor is not None
        assert np.isclose(floor.origin_P_m[2], carried)
        assert np.isclose(floor.height_m, 0.05 - (carried - z))


def test_what_fills_a_drawn_volume_is_not_free(library: AssetLibrary):
    wide = ((-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2))
    volume = library.volume(BIN, 1.0, AuthoredPolygon(outline=wide, z=0.01, height=0.14), "drawn")
    assert volume is not None
    # Outside of the walls there is more room than inside; over the rim, at 7 cm, all is free.
    areas = [layer.area for low, _, layer in volume.layers if low >= 0.07 - 1e-9]
    assert areas
    assert np.allclose(areas, 0.16)
    assert np.isclose(volume.layers[0][2].area, 0.16 - 0.2 * 0.15)


def test_round_tops_lie_inside_and_round_footprints_outside(library: AssetLibrary):
    can = CylinderAsset(type="cylinder", radius_m=0.04, height_m=0.1)
    top = library.surface(can, 1.0, "top", "top")
    assert top is not None
    circle = shapely.Point(0.0, 0.0).buffer(0.04, 256)
    footprint = shapely.Polygon(library.body(can).resting_orientations[0].prisms[0].outline_m)
    assert circle.buffer(1e-6).contains(top.polygon)
    assert footprint.contains(circle.buffer(-1e-6))


def test_the_same_asset_is_read_once(library: AssetLibrary):
    box = BoxAsset(type="box", size_m=(0.1, 0.1, 0.1))
    assert library.body(box) is library.body(BoxAsset(type="box", size_m=(0.1, 0.1, 0.1)))
    assert library.body(box) is not library.body(box, 2.0)


def test_what_is_no_package_is_told(library: AssetLibrary, tmp_path: Path):
    for folder, name, code in ((library, "bim", "unknown"), (library, "torn", "unusable"), (None, "bin", "unknown")):
        with pytest.raises(InvalidInput) as caught:
            (folder or AssetLibrary(None)).body(FixedAsset(type="fixed", id=name))
        assert caught.value.diagnostic.code == f"scene/{code}-asset"
    with pytest.raises(InvalidInput, match="did you mean `bin`"):
        library.body(FixedAsset(type="fixed", id="bim"))


def test_packages_that_come_and_go_are_known_after_a_refresh(tmp_path: Path):
    library = AssetLibrary(tmp_path)
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
    (tmp_path / "a" / "record.json").write_text("{}")
    assert library.names == ("a",)
    (tmp_path / "b" / "record.json").write_text("{}")
    library.refresh()
    assert library.names == ("a", "b")
    (tmp_path / "a" / "record.json").unlink()
    library.refresh()
    assert library.names == ("b",)


def test_a_rejected_package_is_refused(tmp_path: Path):
    scene_library.cube(tmp_path, "bad", outcome="rejected")
    with pytest.raises(InvalidInput) as caught:
        AssetLibrary(tmp_path).body(FixedAsset(type="fixed", id="bad"))
    assert caught.value.diagnostic.code == "scene/unusable-asset"


def test_how_an_asset_rests_is_not_known_once_its_shape_has_changed(tmp_path: Path):
    scene_library.rod(tmp_path)
    payloads = tmp_path / "rod" / "usd" / "payloads"
    looks, physics = payloads / "rod_materials.usda", payloads / "rod_physics.usda"
    looks.write_text(looks.read_text() + "# another colour\n")
    assert AssetLibrary(tmp_path).body(FixedAsset(type="fixed", id="rod"), orientation="stable").resting_orientations
    physics.write_text(physics.read_text().replace("0.2", "0.3"))
    with pytest.raises(InvalidInput, match=r"rod_physics\.usda"):
        AssetLibrary(tmp_path).body(FixedAsset(type="fixed", id="rod"))


@settings(max_examples=60, deadline=None)
@given(shapes(), QUATS)
def test_sections_hold_the_shape_at_each_height(shape: CollisionShape, quat: np.ndarray):
    stance = stance_of([shape], quat_of(quat), "any", sections=True)
    points = surface(shape)[0] @ matrix_of(quat).T + [0.0, 0.0, stance.origin_height_m]
    assert stance.prisms[0].low_m == pytest.approx(0.0, abs=1e-9)
    for below, above in pairwise(stance.prisms):
        assert below.high_m == pytest.approx(above.low_m, abs=1e-12)
    for prism in stance.prisms:
        here = points[(points[:, 2] >= prism.low_m) & (points[:, 2] <= prism.high_m), :2]
        beyond = shapely.distance(shapely.Polygon(prism.outline_m), shapely.points(here))
        assert np.max(beyond, initial=0.0) < 1e-6


def test_what_tapers_is_cut_up_and_what_does_not_is_whole():
    upright = (1.0, 0.0, 0.0, 0.0)
    block = stance_of([CollisionShape("box", (0.1, 0.06, 0.04), np.eye(4))], upright, "any", sections=True)
    ball = stance_of([CollisionShape("sphere", (0.03,), np.eye(4))], upright, "any", sections=True)
    assert len(block.prisms) == 1
    foot, *_, top = (shapely.Polygon(prism.outline_m).area for prism in ball.prisms)
    assert max(foot, top) < 0.05 * max(shapely.Polygon(prism.outline_m).area for prism in ball.prisms)
