"""Which way is up: by form and reference pose, whatever way an object lies in its file."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from assetkit.pose.upright import TURN_NAMED, rank_upright
from assetkit.taxonomy.tables import categories
from geom.features.upright_directions import UprightFeatures, upright_features
from schemas.arrays import FloatArray
from schemas.evidence import Evidence, declared, default
from schemas.model import Axis
from schemas.physics import Solid

Z_BY_HABIT: Evidence[Axis] = default("z", "OBJ declares no up axis")


def solid_of(mesh: trimesh.Trimesh, R: FloatArray | None = None) -> Solid:
    points = np.asarray(mesh.vertices) @ (np.eye(3) if R is None else R).T
    return Solid(points, np.asarray(mesh.faces, dtype=np.int32), "closed")


def cup() -> trimesh.Trimesh:
    """Closed, 80 mm across and 95 mm high, wall and floor of 4 mm, open along +z."""
    profile = [(0, 0), (0.04, 0), (0.04, 0.095), (0.036, 0.095), (0.036, 0.004), (0, 0.004)]
    return trimesh.creation.revolve(np.array(profile), sections=48)


def stool() -> trimesh.Trimesh:
    legs = [trimesh.creation.box((0.04, 0.04, 0.4)) for _ in range(4)]
    for leg, (x, y) in zip(legs, ((1, 1), (1, -1), (-1, 1), (-1, -1)), strict=True):
        leg.apply_translation((0.15 * x, 0.15 * y, 0.2))
    seat = trimesh.creation.box((0.36, 0.36, 0.05))
    seat.apply_translation((0, 0, 0.424))
    return trimesh.boolean.union([seat, *legs], engine="manifold")


def plate() -> trimesh.Trimesh:
    profile = [(0, 0), (0.06, 0), (0.12, 0.02), (0.12, 0.023), (0.06, 0.004), (0, 0.004)]
    return trimesh.creation.revolve(np.array(profile), sections=48)


@pytest.mark.parametrize(("mesh", "category"), [(cup(), "mug"), (stool(), "stool"), (plate(), "plate")])
@pytest.mark.parametrize("seed", range(3))
def test_an_object_turned_in_any_way_is_found_upright(mesh: trimesh.Trimesh, category: str, seed: int) -> None:
    R = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    best = rank_upright(upright_features(solid_of(mesh, R)), categories()[category], None)[0]
    assert np.array(best.up) @ R[:, 2] > np.cos(np.radians(6.0))
    assert best.probability > TURN_NAMED


def test_signs_do_not_depend_on_place_size_or_a_quarter_turn() -> None:
    R = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    before, moved = upright_features(solid_of(cup())), solid_of(cup(), R)
    after = upright_features(Solid(30.0 * moved.points + 7.0, moved.triangles, "closed"))
    for stand in before[:2]:
        other = max(after, key=lambda s: float(s.up @ R @ stand.up))
        assert _figures(stand) == pytest.approx(_figures(other), abs=0.02)


def _figures(stand: UprightFeatures) -> list[float]:
    return [stand.tip_rad, stand.water, stand.under, stand.flat, stand.round, stand.top, stand.bottom]


def test_both_ends_of_a_can_look_alike_and_this_is_on_record() -> None:
    R = Rotation.from_euler("x", 70, degrees=True).as_matrix()
    can = trimesh.creation.cylinder(0.033, 0.12, sections=48)
    best = rank_upright(upright_features(solid_of(can, R)), categories()["can"], None)[0]
    assert abs(np.array(best.up) @ R[:, 2]) > 0.99
    assert any(np.array(other) @ np.array(best.up) < -0.99 for other in best.alike)


def test_a_declared_axis_needs_more_against_it_than_a_habit() -> None:
    lying = upright_features(solid_of(cup(), Rotation.from_euler("x", 90, degrees=True).as_matrix()))
    by_habit = rank_upright(lying, categories()["mug"], Z_BY_HABIT)
    by_file = rank_upright(lying, categories()["mug"], declared("z", "upAxis"))
    assert by_habit[0].up == pytest.approx((0.0, -1.0, 0.0), abs=1e-6)
    assert by_file[0].probability < by_habit[0].probability


def test_a_block_has_no_way_up() -> None:
    assert (
        rank_upright(upright_features(solid_of(trimesh.creation.box((0.1, 0.05, 0.02)))), categories()["block"], None)
        == ()
    )


def test_what_is_flat_has_no_stand() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    assert upright_features(Solid(square, np.array([[0, 1, 2], [0, 2, 3]]), "shell")) == ()
