"""The mass table: hard shapes against closed forms and an independent integration, and the laws that always hold.

Every case goes through intake's model, canonicalisation, repairs, the solid and the composition of its materials, as a
file would. The judge knows only where matter is: it counts Sobol points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose
from scipy.stats import qmc

from assetkit.mass.bounds import MAX_SPAN
from assetkit.mass.estimate import MassEvidence
from assetkit.options import Options
from assetkit.stage import Canonical
from geom.mass.inertia import combine, inertia_about, is_physical
from schemas.appearance.material import Material, Volume
from schemas.arrays import BoolArray, FloatArray
from schemas.model import Mesh
from schemas.physics import MassProperties
from tests.support.mass_samples import (
    NOWHERE,
    STEEL,
    WOOD,
    as_modelled,
    assert_same,
    ball,
    box,
    inside_out,
    join_meshes,
    solid_box,
    weighed,
    with_faces,
)
from tests.support.package_samples import mesh_from
from tests.support.present import present


def less(whole: MassProperties, hole: MassProperties) -> MassProperties:
    """`whole` without `hole`, which it contains."""
    mass = whole.mass_kg - hole.mass_kg
    centre = (whole.mass_kg * whole.centre_of_mass_m - hole.mass_kg * hole.centre_of_mass_m) / mass
    return MassProperties(mass, centre, inertia_about(whole, centre) - inertia_about(hole, centre))


def in_box(size, at=NOWHERE) -> Callable[[FloatArray], BoolArray]:
    return lambda x: np.asarray((np.abs(x - np.array(at)) <= np.array(size) / 2).all(axis=1))


def in_ball(radius, at=NOWHERE) -> Callable[[FloatArray], BoolArray]:
    return lambda x: np.linalg.norm(x - np.array(at), axis=1) <= radius


@dataclass(frozen=True)
class Case:
    """Meshes, where matter is, and (for tessellated round things None) the exact mass properties."""

    meshes: tuple[Mesh, ...]
    density: Callable[[FloatArray], FloatArray]
    exact: MassProperties | None


A, B = ((0.2, 0.1, 0.1), NOWHERE), ((0.1, 0.06, 0.2), (0.08, 0.02, 0.05))
SHARED = ((0.07, 0.06, 0.1), (0.065, 0.02, 0.0))  # The box where A and B overlap.
CUBE, ROOM, CORE = (0.2, 0.2, 0.2), (0.12, 0.12, 0.12), (0.06, 0.06, 0.06)
HEAD, HANDLE = ((0.05, 0.14, 0.05), (0.2, 0.0, 0.0)), ((0.4, 0.03, 0.03), NOWHERE)
OVERLAPPING = less(combine([solid_box(*A), solid_box(*B)]), solid_box(*SHARED))


def union_of(*parts) -> Callable[[FloatArray], FloatArray]:
    return lambda x: WOOD * np.any([part(x) for part in parts], axis=0)


def shells(*parts) -> Callable[[FloatArray], FloatArray]:
    """Matter between the first and second, inside the third ..."""
    return lambda x: WOOD * (np.sum([part(x) for part in parts], axis=0) % 2 == 1)


def hammer(x: FloatArray) -> FloatArray:
    return np.where(in_box(*HEAD)(x), STEEL, WOOD * in_box(*HANDLE)(x))


def split_face(mesh: Mesh) -> Mesh:
    """One face cut by a point a hundredth of a micrometre from its edge: a sliver 1e-7 as high as it is long."""
    a, b, c = mesh.triangles[0]
    middle = 0.5 * (mesh.points[a] + mesh.points[b])
    inward = mesh.points[c] - middle
    points = np.vstack([mesh.points, middle + 1e-8 * inward / np.linalg.norm(inward)])
    new = len(mesh.points)
    faces = np.vstack([mesh.triangles[1:], [[a, b, new], [b, c, new], [c, a, new]]])
    return replace(mesh, points=points, triangles=faces.astype(np.int32))


def some_flipped(mesh: Mesh) -> Mesh:
    """Every third face runs the other way."""
    third = (np.arange(len(mesh.triangles)) % 3 == 0)[:, None]
    return replace(mesh, triangles=np.where(third, mesh.triangles[:, ::-1], mesh.triangles))


def needle(mesh: Mesh) -> Mesh:
    """A closed splinter of a micrometre's width stands on the box."""
    splinter = trimesh.creation.box((1e-6, 1e-6, 0.002))
    splinter.apply_translation((0.0, 0.0, 0.0505))
    return join_meshes(mesh, mesh_from(splinter))


PLAIN = box(*A)
TABLE = {
    "overlapping boxes in one mesh": Case(
        (join_meshes(box(*A), box(*B)),), union_of(in_box(*A), in_box(*B)), OVERLAPPING
    ),
    "overlapping boxes, a mesh each": Case((box(*A), box(*B)), union_of(in_box(*A), in_box(*B)), OVERLAPPING),
    "a box inside a box of the same winding": Case(
        (join_meshes(box(CUBE), box(ROOM)),), union_of(in_box(CUBE)), solid_box(CUBE)
    ),
    "touching boxes": Case(
        (box(*A), box((0.1, 0.1, 0.1), (0.15, 0, 0))),
        union_of(in_box((0.3, 0.1, 0.1), (0.05, 0, 0))),
        solid_box((0.3, 0.1, 0.1), (0.05, 0, 0)),
    ),
    "overlapping balls": Case(
        (ball(0.1), ball(0.1, (0.12, 0, 0))), union_of(in_ball(0.1), in_ball(0.1, (0.12, 0, 0))), None
    ),
    "a cavity": Case(
        (join_meshes(box(CUBE), inside_out(box(ROOM, (0.02, 0, 0)))),),
        shells(in_box(CUBE), in_box(ROOM, (0.02, 0, 0))),
        less(solid_box(CUBE), solid_box(ROOM, (0.02, 0, 0))),
    ),
    "a hollow ball": Case(
        (join_meshes(ball(0.1), inside_out(ball(0.09))),),
        shells(in_ball(0.1), in_ball(0.09)),
        less(as_modelled(ball(0.1)), as_modelled(ball(0.09))),
    ),
    "three shells, one in the other": Case(
        (join_meshes(box(CUBE), inside_out(box(ROOM)), box(CORE)),),
        shells(in_box(CUBE), in_box(ROOM), in_box(CORE)),
        combine([less(solid_box(CUBE), solid_box(ROOM)), solid_box(CORE)]),
    ),
    "all faces inside out": Case((inside_out(PLAIN),), union_of(in_box(*A)), solid_box(*A)),
    "one of two bodies inside out": Case(
        (join_meshes(box(*A), inside_out(box(CORE, (0.2, 0, 0)))),),
        union_of(in_box(*A), in_box(CORE, (0.2, 0, 0))),
        combine([solid_box(*A), solid_box(CORE, (0.2, 0, 0))]),
    ),
    "a third of the faces flipped": Case(
        (some_flipped(ball(0.1)),),
        union_of(in_ball(0.1)),
        as_modelled(ball(0.1)),
    ),
    "a sliver face": Case((split_face(PLAIN),), union_of(in_box(*A)), solid_box(*A)),
    "a splinter on top": Case((needle(PLAIN),), union_of(in_box(*A)), solid_box(*A)),
    "degenerate faces": Case(
        (with_faces(PLAIN, [[0, 0, 1], [2, 2, 2], [3, 1, 3]]),), union_of(in_box(*A)), solid_box(*A)
    ),
    "every face twice": Case((with_faces(PLAIN, PLAIN.triangles),), union_of(in_box(*A)), solid_box(*A)),
    "the same shell twice": Case((join_meshes(PLAIN, PLAIN),), union_of(in_box(*A)), solid_box(*A)),
    "an unwelded soup of faces": Case(
        (Mesh("soup", PLAIN.points[PLAIN.triangles].reshape(-1, 3), np.arange(36, dtype=np.int32).reshape(-1, 3)),),
        union_of(in_box(*A)),
        solid_box(*A),
    ),
    "steel head on a wooden handle": Case(
        (box(*HANDLE, "wood_handle"), box(*HEAD, "steel_head")),
        hammer,
        combine([solid_box((0.375, 0.03, 0.03), (-0.0125, 0, 0)), solid_box(*HEAD, STEEL)]),
    ),
}


@cache
def outcome(name: str) -> tuple[MassEvidence, Canonical, MassProperties]:
    return weighed(TABLE[name].meshes)


@pytest.mark.parametrize("name", TABLE)
def test_closed_form(name):
    _, canonical, got = outcome(name)
    assert canonical.solid.kind == "closed"
    assert is_physical(got.inertia_kgm2)
    exact = TABLE[name].exact
    if exact is not None:
        assert_same(got, exact, 1e-6)


@pytest.mark.parametrize("name", TABLE)
def test_independent_integration(name):
    points = np.concatenate([m.points for m in TABLE[name].meshes])
    judged = counted(TABLE[name].density, points.min(axis=0), points.max(axis=0))
    assert_same(outcome(name)[2], judged, rtol=0.01)


def counted(density: Callable[[FloatArray], FloatArray], low: FloatArray, high: FloatArray) -> MassProperties:
    """Mass properties from 2^16 Sobol points in a box; a few tenths of a percent for shapes that fill much of it."""
    x = low + qmc.Sobol(3, rng=np.random.default_rng(0)).random_base2(16) * (high - low)
    mass = density(x) * np.prod(high - low) / len(x)
    centre = mass @ x / mass.sum()
    r = x - centre
    second = np.einsum("i,ij,ik->jk", mass, r, r)
    return MassProperties(float(mass.sum()), centre, np.trace(second) * np.eye(3) - second)


# Open surfaces.


def half_ball(radius=0.1) -> Mesh:
    """The lower half of a spherical sheet, rim up."""
    angle = np.linspace(0.0, np.pi / 2, 17)
    profile = radius * np.stack([np.sin(angle), -np.cos(angle)], axis=1)
    return mesh_from(trimesh.creation.revolve(profile, sections=48), "bowl")


def test_a_declared_wall_makes_a_shell_with_its_closed_form():
    """Half a spherical sheet: m = 2 pi r^2 t rho, centre r/2 below the rim, I = 2/3 m r^2 and 5/12 m r^2."""
    r, t = 0.1, 0.002
    found, canonical, got = weighed([half_ball(r)], Options(shell_thickness_m=t))
    mass = 2 * np.pi * r**2 * t * WOOD
    truth = MassProperties(mass, np.array([0, 0, -r / 2]), mass * r**2 * np.diag([5 / 12, 5 / 12, 2 / 3]))
    assert canonical.solid.kind == "shell"
    assert_same(got, truth, rtol=0.01)
    wall = canonical.section.wall_thickness_m
    assert wall is not None
    assert (wall.value, wall.source) == (t, "declared")
    assert found.mass_kg.bounds == pytest.approx((mass * 350 / 650, mass * 950 / 650), rel=0.01)


def test_an_undeclared_wall_is_little_believed_and_may_be_a_filled_body():
    undeclared, canonical, _ = weighed([half_ball()])
    with_wall, _, _ = weighed([half_ball()], Options(shell_thickness_m=0.002))
    assert canonical.section.wall_thickness_m is not None
    assert canonical.section.wall_thickness_m.source == "default"
    assert undeclared.mass_kg.confidence < 0.5 * with_wall.mass_kg.confidence
    assert "wall thickness unknown" in undeclared.mass_kg.method
    assert "filled" in undeclared.mass_kg.method
    low, high = present(undeclared.mass_kg.bounds)
    assert low < 0.5 * undeclared.mass_kg.value
    assert high > 5.0 * undeclared.mass_kg.value
    assert high <= MAX_SPAN * low * (1 + 1e-9)


def scraps() -> Mesh:
    """Confetti in a box: neither a body nor a sheet."""
    rng = np.random.default_rng(4)
    corners = rng.uniform(-0.1, 0.1, (1500, 1, 3)) + rng.uniform(-0.004, 0.004, (1500, 3, 3))
    return Mesh("scraps", corners.reshape(-1, 3), np.arange(4500, dtype=np.int32).reshape(-1, 3))


def test_what_is_neither_body_nor_sheet_falls_back_to_its_hull_unless_a_wall_is_declared():
    found, canonical, got = weighed([scraps()])
    assert canonical.solid.kind == "hull"
    hull = trimesh.convex.convex_hull(scraps().points)
    assert got.mass_kg == pytest.approx(WOOD * hull.volume, rel=1e-6)
    assert found.mass_kg.confidence < 0.2
    assert "convex hull stands in" in found.mass_kg.method
    assert present(found.mass_kg.bounds)[0] < 0.2 * found.mass_kg.value
    _, canonical, got = weighed([scraps()], Options(shell_thickness_m=0.001))
    sheet = trimesh.Trimesh(scraps().points, scraps().triangles, process=False)
    assert canonical.solid.kind == "shell"
    assert got.mass_kg == pytest.approx(WOOD * sheet.area * 0.001, rel=1e-6)


def test_a_thickness_that_a_material_hints_is_used_with_doubt():
    glass = Material("glass", volume=Volume(thickness=0.003))
    _, canonical, _ = weighed([replace(half_ball(), material=0)], materials=[glass])
    wall = canonical.section.wall_thickness_m
    assert wall is not None
    assert (wall.value, wall.source, wall.bounds) == (0.003, "inferred", (0.0015, 0.006))
    assert canonical.solid.wall_thickness_m == 0.003


# Far away, mirrored, scaled, turned.


@pytest.mark.parametrize("distance_m", [1e4, 1e5, 1e6])
@pytest.mark.parametrize("single", [False, True], ids=["double", "single"])
def test_far_from_the_origin_only_the_input_loses_digits(distance_m, single):
    shift = distance_m * np.array([1.0, -0.5, 0.25])
    size = 20.0 if single else 0.2
    mesh = ball(size, subdivisions=3)
    points = mesh.points + shift
    stored = points.astype(np.float32).astype(np.float64) if single else points
    _, _, got = weighed([replace(mesh, points=stored)])
    near = as_modelled(replace(mesh, points=stored - shift))  # What the rounded input truly holds.
    assert got.mass_kg == pytest.approx(near.mass_kg, rel=1e-6)
    assert_allclose(got.centre_of_mass_m - shift, near.centre_of_mass_m, atol=1e-6 * size + 1e-9 * distance_m)
    assert_allclose(got.inertia_kgm2, near.inertia_kgm2, atol=1e-6 * near.inertia_kgm2.max())
    rounding = float(np.finfo(np.float32 if single else np.float64).eps) * distance_m / size
    ideal = as_modelled(mesh)
    assert got.mass_kg == pytest.approx(ideal.mass_kg, rel=max(1e-6, 3.0 * rounding))


def test_a_mirrored_body_has_the_mirrored_centre_and_tensor():
    meshes = (box(*A), box(*B))
    mirror = np.diag([-1.0, 1.0, 1.0])
    flipped = [inside_out(replace(m, points=m.points @ mirror)) for m in meshes]
    _, _, got = weighed(flipped)
    truth = MassProperties(
        OVERLAPPING.mass_kg, mirror @ OVERLAPPING.centre_of_mass_m, mirror @ OVERLAPPING.inertia_kgm2 @ mirror
    )
    assert_same(got, truth, 1e-6)
