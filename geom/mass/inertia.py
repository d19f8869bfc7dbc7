"""Volume (m3) or mass (kg), centre (m) and inertia tensor of bodies in the axes of the given points; exact.

Surfaces give `VolumeProperties`, to be filled with a density; analytic solids of one density give `MassProperties`.
Every body reduces to three moments about some point: volume, first moment and second moment `S = ∫ x xᵀ dV`; they add,
and the inertia per density is `tr(S) 1 - S`. Tetrahedra and triangles have closed moments (Blow and Binstock 2004, "How
to find the inertia tensor of a 3D solid body"; equal to Mirtich 1996 and Eberly 2002, "Polyhedral mass properties"):

    S of a tetrahedron (0, a, b, c) of volume V = V/20 (a aᵀ + b bᵀ + c cᵀ + s sᵀ),  s = a + b + c
    S of a triangle (a, b, c) of area A         = A/12 (a aᵀ + b bᵀ + c cᵀ + s sᵀ)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geom.mesh.surface_distance import triangle_areas
from schemas.arrays import FloatArray, IntArray
from schemas.physics import MassProperties, VolumeProperties

TRIANGLE_INEQUALITY_TOLERANCE = 1e-9


def enclosed_volume(points: FloatArray, triangles: IntArray) -> VolumeProperties:
    """The volume inside a closed, outward triangle surface; points (n, 3), triangles (m, 3).

    Signed tetrahedra from the centre of the points, so that a far-away origin costs no precision. Inward shells
    subtract. A volume of zero or below means that the surface is not closed and outward; the caller decides.
    """
    origin = _middle(points)
    a, b, c = np.moveaxis(points[triangles] - origin, 1, 0)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    s = a + b + c
    second = sum(np.einsum("i,ij,ik->jk", volume, v, v) for v in (a, b, c, s)) / 20.0
    return _about_centre(float(volume.sum()), np.asarray(volume @ s) / 4.0, np.asarray(second), origin)


def sheet_volume(points: FloatArray, triangles: IntArray, thickness_m: float) -> VolumeProperties:
    """The volume of an open surface grown to a wall: each triangle a plate of `thickness_m`, half on each side.

    The plate's own second moment across, `V t² / 12`, is included, so that a flat sheet has a positive definite tensor.
    """
    origin = _middle(points)
    corners = points[triangles] - origin
    areas = triangle_areas(corners)
    corners, areas = corners[areas > 0.0], areas[areas > 0.0]
    a, b, c = np.moveaxis(corners, 1, 0)
    volume = thickness_m * areas
    s = a + b + c
    normals = np.cross(b - a, c - a) / (2.0 * areas[:, None])
    second = sum(np.einsum("i,ij,ik->jk", volume, v, v) for v in (a, b, c, s)) / 12.0
    across = np.einsum("i,ij,ik->jk", volume * thickness_m**2 / 12.0, normals, normals)
    return _about_centre(float(volume.sum()), np.asarray(volume @ s) / 3.0, np.asarray(second + across), origin)


def box_volume(size_m: Sequence[float], X_AB: FloatArray) -> VolumeProperties:
    """The volume of a box of full edge lengths (x, y, z), centred on the origin of frame B, in frame A."""
    x, y, z = size_m
    volume = x * y * z
    second = volume / 12.0 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
    return VolumeProperties(volume, *_moved(np.zeros(3), second, X_AB))


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
    return MassProperties(body.mass_kg, *_moved(body.centre_of_mass_m, body.inertia_kgm2, X_AB))


def inertia_about(body: MassProperties, point_m: FloatArray) -> FloatArray:
    """Inertia (3, 3) about `point_m` instead of the mass centre: the parallel-axis theorem (Huygens, Steiner)."""
    return _about(point_m, body.mass_kg, body.centre_of_mass_m, body.inertia_kgm2)


def combine(bodies: Sequence[MassProperties]) -> MassProperties:
    """Mass properties of one rigid body made of several that do not overlap. Raises ValueError for no bodies."""
    if not bodies:
        raise ValueError("no bodies to combine")
    return MassProperties(*_combined([(b.mass_kg, b.centre_of_mass_m, b.inertia_kgm2) for b in bodies]))


def combine_volumes(volumes: Sequence[VolumeProperties]) -> VolumeProperties:
    """The volume of several regions together; overlaps count twice. Raises ValueError for no regions."""
    if not volumes:
        raise ValueError("no volumes to combine")
    return VolumeProperties(*_combined([(v.volume_m3, v.centre_m, v.second_moment_m5) for v in volumes]))


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


def _about_centre(volume_m3: float, first: FloatArray, second: FloatArray, origin: FloatArray) -> VolumeProperties:
    """From moments about `origin` to those about the centre."""
    if volume_m3 == 0.0:
        return VolumeProperties(0.0, origin, np.zeros((3, 3)))
    offset = first / volume_m3
    central = second - volume_m3 * np.outer(offset, offset)
    return VolumeProperties(volume_m3, origin + offset, _symmetric(np.trace(central) * np.eye(3) - central))


def _combined(parts: Sequence[tuple[float, FloatArray, FloatArray]]) -> tuple[float, FloatArray, FloatArray]:
    """Sum of (mass or volume, centre, tensor about the centre)."""
    total = sum(amount for amount, _, _ in parts)
    # Relative to the first centre: far from the origin the sum of products would lose the differences.
    base = parts[0][1]
    centre = base + np.asarray(sum(amount * (of_part - base) for amount, of_part, _ in parts)) / total
    return total, centre, np.asarray(sum(_about(centre, *part) for part in parts))


def _about(point_m: FloatArray, amount: float, centre_m: FloatArray, tensor: FloatArray) -> FloatArray:
    """Parallel-axis theorem for a mass or a volume with its tensor (3, 3) about its centre."""
    r = np.asarray(point_m) - centre_m
    return tensor + amount * (r @ r * np.eye(3) - np.outer(r, r))


def _moved(centre_m: FloatArray, tensor: FloatArray, X_AB: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Centre and tensor, given in frame B, in frame A."""
    R_AB = X_AB[:3, :3]
    return R_AB @ centre_m + X_AB[:3, 3], _symmetric(R_AB @ tensor @ R_AB.T)


def _middle(points: FloatArray) -> FloatArray:
    return 0.5 * (points.min(axis=0) + points.max(axis=0))


def _symmetric(matrix: FloatArray) -> FloatArray:
    return 0.5 * (matrix + matrix.T)
