"""Acceptance passes sound bodies of every size and shape, and names what is wrong with the others."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from assetkit.acceptance.body_checks import body_checks
from assetkit.acceptance.judge_body import AcceptanceResult, accept
from assetkit.acceptance.settling import settle_and_drop
from geom.convex.support_function import bounds, surface
from geom.pose import pose
from schemas.acceptance import AcceptanceSection
from schemas.diagnostics import Severity
from schemas.physics import CollisionShape, RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.fake import FakeSimulator
from sim.port import DropResult, world_for
from tests.support.sample_bodies import box, boxes, capsule, contact, cylinder, hull, hull_box, sphere

FILE = Path("assets/part/part.usda")


@pytest.fixture(scope="module")
def bullet():
    with BulletSimulator() as simulator:
        yield simulator


def visible(body: RigidBody) -> tuple[np.ndarray, np.ndarray]:
    """The colliders' own surface."""
    points, triangles, count = [], [], 0
    for shape in body.shapes:
        p, t = surface(shape)
        points.append(p)
        triangles.append(np.asarray(t) + count)
        count += len(p)
    return np.concatenate(points), np.concatenate(triangles)


def judge(simulator, body: RigidBody, visual=None, **extra) -> AcceptanceResult:
    return accept(FILE, simulator, body=body, visual=visual or visible(body), **extra)


def codes(result: AcceptanceResult) -> list[str]:
    return [d.code for d in result.diagnostics]


def failed(result: AcceptanceResult) -> list[str]:
    return [c.name for c in result.section.checks if not c.passed]


SOUND = {
    "box": box((0.1, 0.08, 0.05)),
    "hull": hull_box((0.1, 0.08, 0.05)),
    "ball": sphere(0.03, contact(restitution=0.5)),
    "can": cylinder(0.033, 0.12),
    "compound": boxes([((0.1, 0.04, 0.02), (0, 0, 0.01)), ((0.02, 0.04, 0.08), (-0.04, 0, 0.06))]),
    "card": box((0.09, 0.06, 0.0004)),
    "tall": box((0.02, 0.02, 0.4)),
    "tiny": box((0.006, 0.004, 0.005)),
    "building": box((56.0, 9.0, 63.0)),
    "toy car in wrong units": box((400.0, 180.0, 120.0)),
    "slippery": box((0.1, 0.1, 0.1), contact(0.0)),
    "bouncy": box((0.1, 0.08, 0.05), contact(restitution=0.9)),
}


@pytest.mark.parametrize("name", SOUND)
def test_sound_bodies_pass_without_remark(bullet, name: str) -> None:
    result = judge(bullet, SOUND[name])
    assert failed(result) == []
    assert codes(result) == []
    assert result.passed
    assert result.section.simulator == bullet.name
    assert result.section.stable_poses
    assert all(e.source == "measured" for e in result.section.stable_poses)


def test_many_hulls_pass_in_a_second_or_two(bullet) -> None:
    rng = np.random.default_rng(0)
    blobs = []
    for _ in range(10):
        directions = rng.normal(size=(60, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        blobs.append(hull(trimesh.convex.convex_hull(0.02 * directions)))
    places = np.concatenate([rng.uniform(-0.08, 0.08, (10, 2)), rng.uniform(0.0, 0.1, (10, 1))], axis=1)
    shapes = tuple(replace(b.shapes[0], X_AS=pose(None, p)) for b, p in zip(blobs, places, strict=True))
    low, high = bounds(shapes)
    shift = np.array([-(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]])
    shapes = tuple(replace(s, X_AS=pose(None, s.X_AS[:3, 3] + shift)) for s in shapes)
    solid = box((0.16, 0.16, 0.1))
    result = judge(bullet, RigidBody("blobs", shapes, solid.mass, contact()))
    assert failed(result) == []


@pytest.mark.parametrize(
    "body",
    [
        boxes([((0.02, 0.02, 0.2), (0, 0, 0.1)), ((0.2, 0.02, 0.02), (0.11, 0, 0.19))]),
        box((0.004, 0.004, 1.0)),
        capsule(0.01, 0.1),
        hull(trimesh.creation.icosphere(subdivisions=1, radius=0.03)),
        hull(trimesh.creation.cone(0.04, 0.1).apply_transform(np.diag([1.0, -1.0, -1.0, 1.0]))),
    ],
    ids=["top-heavy", "needle on end", "capsule on end", "faceted ball on a corner", "cone on its tip"],
)
def test_toppling_is_told_but_is_no_failure(bullet, body: RigidBody) -> None:
    low, high = bounds(body.shapes)
    shift = np.array([-(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]])
    shapes = tuple(replace(s, X_AS=pose(None, s.X_AS[:3, 3] + shift)) for s in body.shapes)
    mass = replace(body.mass, centre_of_mass_m=np.asarray(body.mass.centre_of_mass_m) + shift)
    result = judge(bullet, replace(body, shapes=shapes, mass=mass))
    assert codes(result) == ["asset/reference-pose-topples"]
    assert result.diagnostics[0].severity is Severity.INFO
    assert failed(result) == []
    assert not any(e.value.quat_wxyz == pytest.approx((1, 0, 0, 0)) for e in result.section.stable_poses)


def test_extent_on_record_is_compared(bullet) -> None:
    body = box((0.1, 0.08, 0.05))
    assert judge(bullet, body, extent_m=(0.1, 0.08, 0.05)).passed
    wrong = judge(bullet, body, extent_m=(0.1, 0.08, 0.06))
    assert failed(wrong) == ["extent_equals_record"]
    assert codes(wrong) == ["asset/package-invalid"]
    assert wrong.diagnostics[0].where.file == FILE.name


def test_a_frame_off_the_bottom_centre_is_found(bullet) -> None:
    points, triangles = visible(box((0.1, 0.08, 0.05)))
    assert failed(judge(bullet, box((0.1, 0.08, 0.05)), (points + np.array([0.0, 0.0, 0.02]), triangles))) == [
        "origin_at_bottom_centre"
    ]


def test_colliders_beside_the_visible_surface_are_misaligned(bullet) -> None:
    body = box((0.1, 0.08, 0.05))
    beside = replace(body, shapes=(replace(body.shapes[0], X_AS=pose(None, (0.02, 0.0, 0.025))),))
    result = judge(bullet, beside, visible(body))
    assert codes(result) == ["asset/render-collision-misaligned"]
    assert result.diagnostics[0].bound == 0.05
    assert not result.passed


def test_a_collider_that_covers_half_of_what_is_seen_is_misaligned(bullet) -> None:
    """The boxes agree, but between two plates nothing is solid."""
    plates = boxes([((0.1, 0.1, 0.005), (0, 0, 0.0025)), ((0.1, 0.1, 0.005), (0, 0, 0.0975))])
    result = judge(bullet, plates, visible(box((0.1, 0.1, 0.1))))
    assert failed(result) == ["visual_outside_collider_p95"]


def inside_out() -> RigidBody:
    body = hull_box((0.1, 0.1, 0.1))
    shape = body.shapes[0]
    assert shape.triangles is not None
    return replace(body, shapes=(replace(shape, triangles=shape.triangles[:, ::-1]),))


def flat() -> RigidBody:
    points = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]]) - [0.05, 0.05, 0.0]
    shape = CollisionShape("hull", (), np.eye(4), points, np.array([[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]]))
    return replace(box((0.1, 0.1, 0.01)), shapes=(shape,))


def test_a_sliver_that_single_precision_turns_does_not_make_a_hull_concave():
    """The side of a thin rim is a strip 1e-6 wide: its plane is noise, its points are where they belong."""
    ring = np.array([[np.cos(a), np.sin(a)] for a in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)]) * 0.05
    low, high = (np.column_stack([ring, np.full(24, z)]) for z in (0.0, 1e-6))
    top = np.array([[0.0, 0.0, 0.1]])
    body = hull(trimesh.Trimesh(np.concatenate([low, high, top]).astype(np.float32)).convex_hull)
    shape = body.shapes[0]
    assert shape.points is not None
    rough = replace(shape, points=shape.points.astype(np.float32).astype(np.float64))
    bulges = {c.name: c for c in body_checks(replace(body, shapes=(rough,)))}
    assert bulges["hull_not_convex_by"].passed


def with_mass(**changes) -> RigidBody:
    body = box((0.1, 0.1, 0.1))
    return replace(body, mass=replace(body.mass, **changes))


@pytest.mark.parametrize(
    ("body", "name"),
    [
        (replace(box((0.1, 0.1, 0.1)), shapes=()), "collider_count"),
        (boxes([((0.1, 0.1, 0.01), (0, 0, 0.01 * i + 0.005)) for i in range(65)]), "collider_count_limit"),
        (hull(trimesh.creation.icosphere(subdivisions=2, radius=0.05)), "hull_points"),
        (inside_out(), "hull_not_convex_by"),
        (flat(), "collider_thickness"),
        (with_mass(mass_kg=0.0), "mass"),
        (with_mass(mass_kg=float("nan")), "mass"),
        (with_mass(centre_of_mass_m=np.array([0.0, 0.0, 0.5])), "mass_centre_outside_box"),
        (with_mass(inertia_kgm2=np.diag([1e-3, 1e-3, 3e-3])), "inertia_triangle_surplus"),
        (with_mass(inertia_kgm2=np.diag([-1e-3, 1e-3, 1e-3])), "inertia_smallest_moment"),
        (with_mass(inertia_kgm2=np.full((3, 3), np.nan)), "inertia_smallest_moment"),
        (with_mass(inertia_kgm2=np.eye(3) * 100.0), "radius_of_gyration"),
    ],
)
def test_a_body_that_makes_no_sense_is_invalid_and_never_simulated(body: RigidBody, name: str) -> None:
    class Unused(FakeSimulator):
        def drop(self, body, X_WA, settings):
            raise AssertionError("not to be simulated")

    result = judge(Unused(), body, visible(box((0.1, 0.1, 0.1))))
    assert name in failed(result)
    assert codes(result) == ["asset/package-invalid"]
    assert result.section.stable_poses == ()


class Tampered(FakeSimulator):
    """A simulator in which something goes wrong at the end of every drop."""

    def __init__(self, tamper) -> None:
        self.tamper = tamper

    def drop(self, body, X_WA, settings) -> DropResult:
        return self.tamper(super().drop(body, X_WA, settings))

    def drop_many(self, body, poses_WA, settings):
        return tuple(self.drop(body, X, settings) for X in poses_WA)


@pytest.mark.parametrize(
    ("tamper", "name"),
    [
        (lambda r: replace(r, finite=False), "settle_finite"),
        (lambda r: replace(r, heights_m=r.heights_m - 0.03), "settle_penetration"),
        (lambda r: replace(r, heights_m=r.heights_m + 0.03), "settle_height_over_ground"),
        (lambda r: replace(r, speeds_mps=r.speeds_mps * 0.0 + 0.3), "settle_final_speed"),
        (lambda r: replace(r, left_patch=True), "settle_left_patch"),
        (lambda r: replace(r, positions_m=r.positions_m + np.linspace(0, 0.1, len(r.times_s))[:, None] * [1, 0, 0]),
         "settle_drift"),
    ],
)  # fmt: skip
def test_what_a_solid_thing_does_not_do_is_unstable_settling(tamper, name: str) -> None:
    result = judge(Tampered(tamper), box((0.1, 0.1, 0.1)))
    assert name in failed(result)
    assert "asset/unstable-settling" in codes(result)
    assert not result.passed


def test_nothing_at_rest_is_told() -> None:
    restless = Tampered(lambda r: replace(r, speeds_mps=r.speeds_mps + np.linspace(0.3, 0.1, len(r.times_s))))
    result = judge(restless, box((0.1, 0.1, 0.1)))
    assert codes(result) == ["asset/no-stable-pose"]
    assert result.passed  # Its energy decreases: it is on its way to rest.


def test_drop_penetration_is_bounded_by_size_and_by_simready(bullet) -> None:
    for size, bound in ((0.1, 0.05 * 0.1 * 3**0.5), (2.0, 0.1), (50.0, 0.05 * 50.0 * 3**0.5)):
        settling = settle_and_drop(box((size, size, size)), bullet)
        check = next(c for c in settling.checks if c.name == "drop_penetration")
        assert check.bound == pytest.approx(bound)
        assert check.passed
        assert not settling.toppled


def test_the_record_survives_json(bullet) -> None:
    section = judge(bullet, box((0.1, 0.08, 0.05))).section
    assert AcceptanceSection.model_validate_json(section.model_dump_json()) == section


def test_the_judgement_is_deterministic(bullet) -> None:
    body = SOUND["compound"]
    with BulletSimulator() as other:
        assert judge(bullet, body) == judge(other, body)


THIN = {
    "card": (0.085, 0.054, 0.0008),
    "sheet": (0.2, 0.2, 0.0005),
    "plate": (0.2, 0.2, 0.002),
    "lath": (0.3, 0.02, 0.002),
}


@pytest.mark.parametrize("name", THIN)
def test_a_thin_plate_settles_however_it_was_modelled(bullet, name: str) -> None:
    """On its edge, on a corner or flat: it falls over at most, and lies on the ground in the end."""
    upright = [Rotation.identity(), *(Rotation.from_euler(axis, 90.0, degrees=True) for axis in "xy")]
    for R_AM in (*upright, *Rotation.random(3, rng=np.random.default_rng(0))):
        plate = trimesh.creation.box(THIN[name])
        plate.vertices = R_AM.apply(plate.vertices)
        checks = {c.name: c for c in settle_and_drop(hull(plate), bullet).checks}
        assert [c.name for c in checks.values() if not c.passed] == []
        assert checks["settle_penetration"].value < 2e-3 * np.linalg.norm(THIN[name])


def test_what_topples_is_inside_the_ground_for_as_far_as_it_flies_in_a_step(bullet) -> None:
    """A millimetre or more, but never further than the tip of a rod flies; thickness has no part in it."""
    depths = []
    for thickness in (0.0005, 0.001, 0.002):
        plate = hull_box((0.2, thickness, 0.2))
        size = np.linalg.norm((0.2, thickness, 0.2))
        impact = next(c for c in settle_and_drop(plate, bullet).checks if c.name == "settle_impact_penetration")
        world = world_for(float(size))
        assert impact.value < np.sqrt(3.0 * 9.81 * size) * world.timestep_s
        depths.append(impact.value)
    assert min(depths) > 1e-3
