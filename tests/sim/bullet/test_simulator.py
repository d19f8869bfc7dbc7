"""PyBullet does what the port promises: exact contact, authored mass, pair friction, equal calls equal results."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pybullet_data
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from geom.convex.support_function import diagonal, support
from geom.mass.inertia import combine, moved, of_box
from geom.pose import matrix_of, pose
from schemas.physics import CollisionShape, MassProperties, RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.port import (
    DropResult,
    DropSettings,
    World,
    natural_time_s,
    pair_value,
    stillness_for,
    world_for,
)
from tests.support.sample_bodies import DENSITY, box, boxes, capsule, contact, cylinder, hull, hull_box, sphere

TILTED = Rotation.from_euler("xyz", [30, 40, 10], degrees=True).as_matrix()


@pytest.fixture(scope="module")
def bullet():
    with BulletSimulator() as simulator:
        yield simulator


def release(body: RigidBody, R_WA: np.ndarray | None = None, gap: float = 0.01) -> np.ndarray:
    """The pose whose lowest point is `gap` diagonals above the ground."""
    R_WA = np.eye(3) if R_WA is None else R_WA
    return pose(R_WA, (0.0, 0.0, support(body.shapes, -R_WA[2:3])[0] + gap * diagonal(body.shapes)))


def settle(bullet: BulletSimulator, body: RigidBody, R_WA: np.ndarray | None = None) -> DropResult:
    size = diagonal(body.shapes)
    return bullet.drop(body, release(body, R_WA), DropSettings(48 * natural_time_s(size), world_for(size)))


def digest(result: DropResult) -> str:
    rows = (result.positions_m, result.quats_wxyz, result.linear_mps, result.angular_radps)
    return hashlib.sha256(b"".join(r.tobytes() for r in rows)).hexdigest()


L_SHAPE = boxes([((0.1, 0.04, 0.02), (0, 0, 0.01)), ((0.02, 0.04, 0.08), (-0.04, 0, 0.06))])


@pytest.mark.parametrize(
    ("body", "rest_m"),
    [
        (box((0.06, 0.05, 0.04)), 0.02),
        (hull_box((0.06, 0.05, 0.04)), 0.02),
        (sphere(0.03), 0.03),
        (cylinder(0.03, 0.08), 0.04),
        (capsule(0.02, 0.05), 0.045),
    ],
    ids=["box", "hull", "sphere", "cylinder", "capsule"],
)
def test_a_body_set_down_stands_at_its_closed_form_height(bullet, body: RigidBody, rest_m: float) -> None:
    result = settle(bullet, body)
    centre = result.positions_m[-1] + matrix_of(result.quats_wxyz[-1]) @ body.mass.centre_of_mass_m
    assert centre[2] == pytest.approx(rest_m, abs=5e-5)  # A hull with Bullet's margin would stand 1 mm higher.
    assert result.heights_m[-1] == pytest.approx(0.0, abs=5e-5)
    assert result.contacts > 0
    assert result.finite


def test_compounds_of_hulls_have_no_margin_either(bullet) -> None:
    one, other = hull_box((0.04, 0.04, 0.04)), hull_box((0.04, 0.04, 0.04))
    aside = replace(other.shapes[0], X_AS=pose(None, (0.04, 0.0, 0.0)))
    mass = combine([moved(one.mass, pose(None, p)) for p in ((0, 0, 0), (0.04, 0, 0))])
    result = settle(bullet, RigidBody("pair", (one.shapes[0], aside), mass, contact()))
    assert result.heights_m[-1] == pytest.approx(0.0, abs=5e-5)


@pytest.mark.parametrize("kind", ["box", "hull"])
@pytest.mark.parametrize("count", [17, 40])
def test_no_shape_is_dropped_however_many_there_are(bullet, kind: str, count: int) -> None:
    """Bars in a row, rising: the body must rest on the two ends of the built body."""
    make = box if kind == "box" else hull_box
    shapes = tuple(
        replace(s, X_AS=pose(None, (0.02 * i, 0.0, 0.0)) @ s.X_AS)
        for i in range(count)
        for s in make((0.02, 0.05, 0.02)).shapes
    )
    mass = moved(of_box((0.02 * count, 0.05, 0.02), DENSITY), pose(None, (0.01 * (count - 1), 0.0, 0.01)))
    body = RigidBody("row", shapes, mass, contact())
    result = settle(bullet, body)
    assert result.heights_m[-1] == pytest.approx(0.0, abs=2e-4)
    assert matrix_of(result.quats_wxyz[-1])[2, 2] == pytest.approx(1.0, abs=1e-4)


def test_a_tilted_fall_never_sinks_in_deeply(bullet) -> None:
    for body in (box((0.2, 0.14, 0.1)), L_SHAPE, box((0.09, 0.06, 0.0004)), cylinder(0.004, 0.18)):
        result = settle(bullet, body, TILTED)
        assert result.penetration_m < 0.03 * diagonal(body.shapes)
        assert result.still_since_s(stillness_for(diagonal(body.shapes))) is not None


def test_a_stick_of_one_to_a_hundred_does_not_fly_off(bullet) -> None:
    """Bullet's default free body, a multibody, throws it 60 m up."""
    body = box((0.01, 0.01, 1.0))
    result = settle(bullet, body, TILTED)
    assert result.positions_m[:, 2].max() < 1.1
    assert result.still_since_s(stillness_for(1.0)) is not None


def test_free_fall_is_a_parabola(bullet) -> None:
    body = box((0.1, 0.1, 0.1))
    world = World(substeps=8)
    result = bullet.drop(body, pose(TILTED, (0.0, 0.0, 10.0)), DropSettings(1.0, world))
    assert result.positions_m[-1, 2] == pytest.approx(10.0 - 0.5 * 9.81, abs=0.005)
    assert result.linear_mps[-1] == pytest.approx([0.0, 0.0, -9.81], abs=1e-9)
    assert np.allclose(result.quats_wxyz, result.quats_wxyz[0], atol=1e-12)


def test_mass_and_inertia_are_the_authored_ones_not_those_of_the_shape(bullet) -> None:
    """A rod with most of its inertia about one axis rolls down a slope at a = g sin / (1 + k^2 / r^2)."""
    radius, angle = 0.03, np.radians(10.0)
    gravity = (9.81 * np.sin(angle), 0.0, -9.81 * np.cos(angle))
    for gyration in (0.01, 0.02, 0.028):
        solid = sphere(radius, contact(1.0))
        mass = MassProperties(0.2, solid.mass.centre_of_mass_m, 0.2 * gyration**2 * np.eye(3))
        ball = replace(solid, mass=mass)
        result = bullet.drop(ball, release(ball, gap=0.0), DropSettings(0.5, World(gravity_mps2=gravity)))
        expected = 9.81 * np.sin(angle) / (1.0 + (gyration / radius) ** 2)
        assert result.linear_mps[-1, 0] == pytest.approx(0.5 * expected, rel=0.02)


def test_a_mass_centre_off_the_middle_tips_the_body(bullet) -> None:
    solid = box((0.1, 0.1, 0.1))
    heavy_above_edge = replace(solid.mass, centre_of_mass_m=np.array([0.055, 0.0, 0.05]))
    result = settle(bullet, replace(solid, mass=heavy_above_edge))
    assert matrix_of(result.quats_wxyz[-1])[2] == pytest.approx([-1.0, 0.0, 0.0], abs=0.01)


def test_inertia_about_turned_principal_axes_is_accepted(bullet) -> None:
    turned = TILTED @ np.diag([1e-4, 2e-4, 2.5e-4]) @ TILTED.T
    solid = box((0.1, 0.1, 0.1))
    result = settle(bullet, replace(solid, mass=replace(solid.mass, inertia_kgm2=turned)))
    assert result.positions_m[-1] == pytest.approx([0.0, 0.0, 0.0], abs=2e-3)


@pytest.mark.parametrize(
    ("rule", "body", "ground", "pair"),
    [("average", 0.6, 0.2, 0.4), ("multiply", 0.6, 0.5, 0.3), ("minimum", 0.6, 0.2, 0.2), ("maximum", 0.1, 0.5, 0.5)],
)
def test_a_box_slides_down_a_slope_iff_it_is_steeper_than_the_friction_of_the_pair(
    bullet, rule, body: float, ground: float, pair: float
) -> None:
    assert pair_value(body, ground, rule) == pytest.approx(pair)
    block = box((0.1, 0.1, 0.03), contact(body, combine=rule))
    for slope, slides in ((0.93 * pair, False), (1.1 * pair, True)):
        angle = np.arctan(slope)
        gravity = (9.81 * np.sin(angle), 0.0, -9.81 * np.cos(angle))
        world = World(ground_friction=ground, gravity_mps2=gravity)
        result = bullet.drop(block, release(block, gap=0.0), DropSettings(1.0, world))
        travelled = result.positions_m[-1, 0]
        expected = 0.5 * 9.81 * (np.sin(angle) - pair * np.cos(angle))
        assert travelled == pytest.approx(expected, rel=0.15) if slides else abs(travelled) < 2e-3


@pytest.mark.parametrize(("restitution", "rebound_m"), [(0.0, 0.0), (0.5, 0.25), (0.8, 0.64)])
def test_a_ball_bounces_about_as_the_restitution_of_the_pair_says(bullet, restitution: float, rebound_m: float) -> None:
    ball = sphere(0.03, contact(restitution=restitution, combine="maximum"))
    result = bullet.drop(ball, pose(None, (0.0, 0.0, 1.0)), DropSettings(1.0))
    assert result.positions_m[result.times_s > 0.5, 2].max() == pytest.approx(rebound_m, abs=0.12)


def test_a_ball_rolls_off_iff_the_slope_beats_the_rolling_resistance(bullet) -> None:
    ball = sphere(0.05, contact(1.0))
    lever = 0.002
    for factor, rolls in ((0.5, False), (2.0, True)):
        angle = np.arctan(factor * lever / 0.05)
        gravity = (9.81 * np.sin(angle), 0.0, -9.81 * np.cos(angle))
        world = World(ground_friction=1.0, rolling_resistance_m=lever, gravity_mps2=gravity)
        result = bullet.drop(ball, release(ball, gap=0.0), DropSettings(1.0, world))
        assert (result.positions_m[-1, 0] > 0.05) == rolls


@pytest.mark.parametrize(("size", "model"), [(0.004, 0.3), (60.0, 5.0), (400.0, 5.0)])
def test_froude_similarity_scales_the_trajectory(bullet, size: float, model: float) -> None:
    """Lengths x s, times and speeds x sqrt(s): the same motion as at the size of the model."""
    shape = np.array([0.2, 0.15, 0.1]) / np.linalg.norm([0.2, 0.15, 0.1])
    reference, scaled = box((model * shape).tolist()), box((size * shape).tolist())
    scale = size / model
    ours = bullet.drop(scaled, release(scaled, TILTED), DropSettings(0.5 * np.sqrt(scale)))
    theirs = bullet.drop(reference, release(reference, TILTED), DropSettings(0.5))
    assert len(ours.times_s) == len(theirs.times_s)
    free = slice(0, 40)  # Beyond the first impacts rounding grows, as in any tumbling body.
    assert np.allclose(ours.times_s, theirs.times_s * np.sqrt(scale))
    assert np.allclose(ours.positions_m[free], theirs.positions_m[free] * scale, rtol=1e-6, atol=1e-6 * size)
    assert np.allclose(ours.quats_wxyz[free], theirs.quats_wxyz[free], atol=1e-6)
    assert np.allclose(ours.linear_mps[free], theirs.linear_mps[free] * np.sqrt(scale), atol=1e-5 * np.sqrt(size))
    assert np.allclose(ours.angular_radps[free], theirs.angular_radps[free] / np.sqrt(scale), rtol=1e-5, atol=1e-6)
    assert matrix_of(ours.quats_wxyz[-1]) == pytest.approx(matrix_of(theirs.quats_wxyz[-1]), abs=1e-3)


@pytest.mark.parametrize("size", [0.005, 0.3, 4.0, 6.0, 100.0])
def test_a_body_at_rest_sinks_in_by_less_than_its_two_thousandth_and_a_millimetre(bullet, size: float) -> None:
    resting = box((0.7 * size, 0.6 * size, 0.3 * size))
    result = bullet.drop(resting, release(resting, gap=0.001 * size), DropSettings(8.0 * np.sqrt(size / 9.81)))
    assert abs(result.heights_m[-1]) < min(0.0005 * size, 0.001)


def test_a_drop_does_not_depend_on_the_drops_before_it(bullet) -> None:
    starts = [release(L_SHAPE, R) for R in Rotation.random(4, rng=np.random.default_rng(0)).as_matrix()]
    settings = DropSettings(0.6)
    together = [digest(r) for r in bullet.drop_many(L_SHAPE, starts, settings)]
    with BulletSimulator() as other:
        other.drop(box((0.3, 0.2, 0.1)), release(box((0.3, 0.2, 0.1)), TILTED), DropSettings(0.2))
        alone = [digest(other.drop(L_SHAPE, X, settings)) for X in reversed(starts)]
    assert together == alone[::-1]


PROCESS = """
import numpy as np, trimesh
from tests.sim.bullet.test_simulator import TILTED, L_SHAPE, BulletSimulator, digest, hull, release, DropSettings
body = hull(trimesh.creation.icosphere(subdivisions=1, radius=0.05).apply_scale([1.0, 0.7, 0.5]))
with BulletSimulator() as bullet:
    print([digest(bullet.drop(b, release(b, TILTED), DropSettings(1.0))) for b in (body, L_SHAPE)])
"""


def test_every_process_finds_the_same_bits_and_prints_nothing() -> None:
    runs = [subprocess.run([sys.executable, "-c", PROCESS], capture_output=True, check=True) for _ in range(2)]
    assert runs[0].stdout == runs[1].stdout
    assert runs[0].stdout.count(b"\n") == 1  # PyBullet's greeting goes to standard error.


def test_still_bodies_stop_the_simulation_early(bullet) -> None:
    body = box((0.1, 0.1, 0.1))
    still = stillness_for(diagonal(body.shapes))
    result = bullet.drop(body, release(body), DropSettings(20.0, still=still))
    assert result.times_s[-1] < 2.0
    assert result.still_since_s(still) is not None
    assert bullet.drop(body, release(body), DropSettings(0.02)).still_since_s(still) is None


def test_leaving_the_patch_is_noticed(bullet) -> None:
    ball = sphere(0.05, contact(1.0))
    world = World(gravity_mps2=(2.0, 0.0, -9.6))
    assert bullet.drop(ball, release(ball), DropSettings(1.0, world, patch_radius_m=0.3)).left_patch
    assert not bullet.drop(ball, release(ball), DropSettings(1.0, patch_radius_m=0.3)).left_patch


def test_a_diverging_motion_is_reported_and_its_rows_left_out(bullet) -> None:
    body = box((0.1, 0.1, 0.1))
    result = bullet.drop(body, release(body), DropSettings(5.0, World(gravity_mps2=(0.0, 0.0, 2000.0))))
    assert not result.finite
    assert np.isfinite(result.positions_m).all()
    assert np.isfinite(result.heights_m).all()


def test_a_body_the_engine_cannot_hold_is_an_error_not_a_wrong_simulation(bullet) -> None:
    body = box((0.1, 0.1, 0.1))
    impossible = replace(body, mass=replace(body.mass, inertia_kgm2=np.zeros((3, 3))))
    with pytest.raises(RuntimeError, match="push"):
        bullet.drop(impossible, release(body), DropSettings(0.1))
    assert bullet.drop(body, release(body), DropSettings(0.1)).finite


def test_simulators_are_independent_and_close_twice() -> None:
    body = box((0.1, 0.1, 0.1))
    first, second = BulletSimulator(), BulletSimulator()
    second.close()
    second.close()
    assert first.drop(body, release(body), DropSettings(0.1)).finite
    first.close()


def test_real_hulls_settle(bullet) -> None:
    for name in ("duck_vhacd.obj", "cube.obj", "lego/lego.obj"):
        mesh = trimesh.load_mesh(f"{pybullet_data.getDataPath()}/{name}", process=False).convex_hull
        mesh.apply_scale(0.2 / np.linalg.norm(mesh.extents))
        result = settle(bullet, hull(mesh), TILTED)
        assert abs(result.heights_m[-1]) < 1e-3
        assert result.penetration_m < 0.01
        assert result.speeds_mps[-1] < 0.02


def test_shapes_keep_their_pose(bullet) -> None:
    """A cylinder lying along x inside its body stands on its side."""
    X_AS = pose(Rotation.from_euler("y", 90, degrees=True).as_matrix(), (0.0, 0.0, 0.03))
    upright = cylinder(0.03, 0.1)
    mass = moved(replace(upright.mass, centre_of_mass_m=np.zeros(3)), X_AS)
    lying = RigidBody("lying", (CollisionShape("cylinder", (0.03, 0.1), X_AS),), mass, contact())
    result = settle(bullet, lying)
    assert result.positions_m[-1, 2] == pytest.approx(0.0, abs=1e-4)
    assert np.abs(matrix_of(result.quats_wxyz[-1])[2, 0]) < 1e-3
