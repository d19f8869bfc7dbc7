"""Mass, mass centre and inertia tensor of bodies, exact for their geometry, in the axes of the given points (kg, m).

Every body reduces to three moments about some point: mass, first moment and second moment `S = ∫ x xᵀ dm`; they add,
and `I = tr(S) 1 - S`. Tetrahedra and triangles have closed moments (Blow and Binstock 2004, "How to find the inertia
tensor of a 3D solid body"; equal to Mirtich 1996 and Eberly 2002, "Polyhedral mass properties"):

    S of a tetrahedron (0, a, b, c) of volume V = V/20 (a aᵀ + b bᵀ + c cᵀ + s sᵀ),  s = a + b + c
    S of a triangle (a, b, c) of area A         = A/12 (a aᵀ + b bᵀ + c cᵀ + s sᵀ)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geom.mesh.surface_distance import triangle_areas
from schemas.arrays import FloatArray, IntArray
from schemas.physics import MassProperties

TRIANGLE_INEQUALITY_TOLERANCE = 1e-9


def of_closed_surface(points: FloatArray, triangles: IntArray, density_kgm3: float) -> MassProperties:
    """Mass properties of the volume inside a closed, outward triangle surface; points (n, 3), triangles (m, 3).

    Signed tetrahedra from the centre of the points, so that a far-away origin costs no precision. Inward shells
    subtract. A mass of zero or below means that the surface is not closed and outward; the caller decides.
    """
    origin = _middle(points)
    a, b, c = np.moveaxis(points[triangles] - origin, 1, 0)
    mass = density_kgm3 * np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    s = a + b + c
    second = sum(np.einsum("i,ij,ik->jk", mass, v, v) for v in (a, b, c, s)) / 20.0
    return _about_centre(float(mass.sum()), np.asarray(mass @ s) / 4.0, np.asarray(second), origin)


def of_sheet(points: FloatArray, triangles: IntArray, thickness_m: float, density_kgm3: float) -> MassProperties:
    """Mass properties of an open surface grown to a wall: each triangle a plate of `thickness_m`, half on each side.

    The plate's own second moment across, `m t² / 12`, is included, so that a flat sheet has a positive definite tensor.
    """
    origin = _middle(points)
    corners = points[triangles] - origin
    areas = triangle_areas(corners)
    corners, areas = corners[areas > 0.0], areas[areas > 0.0]
    a, b, c = np.moveaxis(corners, 1, 0)
    mass = density_kgm3 * thickness_m * areas
    s = a + b + c
    normals = np.cross(b - a, c - a) / (2.0 * areas[:, None])
    second = sum(np.einsum("i,ij,ik->jk", mass, v, v) for v in (a, b, c, s)) / 12.0
    across = np.einsum("i,ij,ik->jk", mass * thickness_m**2 / 12.0, normals, normals)
    return _about_centre(float(mass.sum()), np.asarray(mass @ s) / 3.0, np.asarray(second + across), origin)


def of_box(size_m: Sequence[float], density_kgm3: float) -> MassProperties:
    """Mass properties of a box of full edge lengths (x, y, z), centred on the origin."""
    x, y, z = size_m
    mass = density_kgm3 * x * y * z
    return MassProperties(mass, np.zeros(3), mass / 12.0 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y]))


def of_sphere(radius_m: float, density_kgm3: float) -> MassProperties:
    """Mass properties of a ball centred on the origin."""
    mass = density_kgm3 * 4.0 / 3.0 * np.pi * radius_m**3
    return MassProperties(mass, np.zeros(3), 0.4 * mass * radius_m**2 * np.eye(3))


def of_cylinder(radius_m: float, height_m: float, density_kgm3: float) -> MassProperties:
    """Mass properties of a cylinder along z, centred on the origin."""
    mass = density_kgm3 * np.pi * radius_m**2 * height_m
    across = mass * (3.0 * radius_m**2 + height_m**2) / 12.0
    return MassProperties(mass, np.zeros(3), np.diag([across, across, 0.5 * mass * radius_m**2]))


def of_capsule(radius_m: float, height_m: float, density_kgm3: float) -> MassProperties:
    """Mass properties of a capsule along z, centred on the origin; `height_m` without its caps.

    Two half balls, each with its mass centre 3r/8 beyond the end of the cylinder, and the cylinder.
    """
    tube = of_cylinder(radius_m, height_m, density_kgm3)
    cap = of_sphere(radius_m, density_kgm3).mass_kg / 2.0
    # Half ball: 2/5 m r² about the centre of its flat face, on every axis through it.
    about_face = 0.4 * cap * radius_m**2
    centre_offset = 3.0 * radius_m / 8.0
    across = about_face - cap * centre_offset**2 + cap * (centre_offset + height_m / 2.0) ** 2
    inertia = tube.inertia_kgm2 + 2.0 * np.diag([across, across, about_face])
    return MassProperties(tube.mass_kg + 2.0 * cap, np.zeros(3), inertia)


def moved(body: MassProperties, X_AB: FloatArray) -> MassProperties:
    """`body`, given in frame B, expressed in frame A; `X_AB` (4, 4) is the pose of B in A."""
    R_AB = X_AB[:3, :3]
    centre = R_AB @ body.centre_of_mass_m + X_AB[:3, 3]
    return MassProperties(body.mass_kg, centre, _symmetric(R_AB @ body.inertia_kgm2 @ R_AB.T))


def inertia_about(body: MassProperties, point_m: FloatArray) -> FloatArray:
    """Inertia (3, 3) about `point_m` instead of the mass centre: the parallel-axis theorem (Huygens, Steiner)."""
    r = np.asarray(point_m) - body.centre_of_mass_m
    return body.inertia_kgm2 + body.mass_kg * (r @ r * np.eye(3) - np.outer(r, r))


def combine(bodies: Sequence[MassProperties]) -> MassProperties:
    """Mass properties of one rigid body made of several that do not overlap. Raises ValueError for no bodies."""
    if not bodies:
        raise ValueError("no bodies to combine")
    mass = sum(b.mass_kg for b in bodies)
    # Relative to the first centre: far from the origin the sum of products would lose the differences.
    base = bodies[0].centre_of_mass_m
    centre = base + np.asarray(sum(b.mass_kg * (b.centre_of_mass_m - base) for b in bodies)) / mass
    return MassProperties(mass, centre, np.asarray(sum(inertia_about(b, centre) for b in bodies)))


def scaled(body: MassProperties, factor: float) -> MassProperties:
    """Mass properties of the same shape at `factor` times the density."""
    return MassProperties(body.mass_kg * factor, body.centre_of_mass_m, body.inertia_kgm2 * factor)


def is_physical(inertia_kgm2: FloatArray, tolerance: float = TRIANGLE_INEQUALITY_TOLERANCE) -> bool:
    """True iff some body has this tensor: finite, symmetric, positive moments, none above the sum of the others.

    `tolerance` is relative to the largest moment; a lamina meets the triangle inequality with equality.
    """
    if not np.isfinite(inertia_kgm2).all():
        return False
    largest = np.abs(inertia_kgm2).max()
    if np.abs(inertia_kgm2 - inertia_kgm2.T).max() > tolerance * largest:
        return False
    low, middle, high = np.linalg.eigvalsh(inertia_kgm2)
    return bool(low > 0.0 and high <= low + middle + tolerance * high)


def _about_centre(mass: float, first: FloatArray, second: FloatArray, origin: FloatArray) -> MassProperties:
    """From moments about `origin` to mass properties about the mass centre."""
    if mass == 0.0:
        return MassProperties(0.0, origin, np.zeros((3, 3)))
    offset = first / mass
    central = second - mass * np.outer(offset, offset)
    return MassProperties(mass, origin + offset, _symmetric(np.trace(central) * np.eye(3) - central))


def _middle(points: FloatArray) -> FloatArray:
    return 0.5 * (points.min(axis=0) + points.max(axis=0))


def _symmetric(matrix: FloatArray) -> FloatArray:
    return 0.5 * (matrix + matrix.T)
