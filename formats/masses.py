"""Mass, mass centre and inertia of a link, in its frame: as declared, or from its shapes filled evenly."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from geom.mass.inertia import combine, moved, of_box, of_capsule, of_cylinder, of_sphere, scaled
from schemas.arrays import FloatArray
from schemas.physics import MassProperties, VolumeProperties
from schemas.robot_description import DescribedLink, DescribedShape, Inertial, MeshReference

MeshVolume = Callable[[MeshReference], VolumeProperties | None]


def _of_ellipsoid(half_m: tuple[float, ...], density_kgm3: float) -> MassProperties:
    a, b, c = half_m
    mass_kg = density_kgm3 * 4.0 / 3.0 * np.pi * a * b * c
    inertia_kgm2 = mass_kg / 5.0 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b])
    return MassProperties(float(mass_kg), np.zeros(3), inertia_kgm2)


_OF_SIZE: Mapping[str, Callable[[tuple[float, ...], float], MassProperties]] = {
    "box": of_box,
    "sphere": lambda size_m, density: of_sphere(size_m[0], density),
    "cylinder": lambda size_m, density: of_cylinder(size_m[0], size_m[1], density),
    "capsule": lambda size_m, density: of_capsule(size_m[0], size_m[1], density),
    "ellipsoid": _of_ellipsoid,
}


def link_mass(link: DescribedLink, mesh_volume: MeshVolume | None = None) -> MassProperties | None:
    """None for a link without mass. `mesh_volume` gives the volume of a mesh in its shape's frame.

    Without it, and where it gives None, a link with a mesh that should weigh has unknown mass: None as well. A mass
    without a tensor counts as a point.
    """
    if link.inertia_source == "declared" and link.inertial is not None:
        return inertial_mass(link.inertial)
    if link.inertia_source != "shapes":
        return None
    masses: list[MassProperties] = []
    for shape in link.shapes:
        if shape.mass_kg is not None or shape.density_kgm3 is not None:
            mass = _shape_mass(shape, mesh_volume)
            if mass is None:
                return None
            masses.append(moved(mass, shape.X_LS))
    return combine(masses) if masses else None


def inertial_mass(inertial: Inertial) -> MassProperties | None:
    """A declared inertial in the frame of the link; None where its mass is not positive."""
    if inertial.mass_kg <= 0.0:
        return None
    tensor: FloatArray = np.zeros((3, 3)) if inertial.inertia_kgm2 is None else inertial.inertia_kgm2
    return moved(MassProperties(inertial.mass_kg, np.zeros(3), tensor), inertial.X_LI)


def _shape_mass(shape: DescribedShape, mesh_volume: MeshVolume | None) -> MassProperties | None:
    """Mass of one shape in its frame; None where its volume is not known."""
    if shape.kind in _OF_SIZE and shape.problem is None:
        even = _OF_SIZE[shape.kind](shape.size_m, 1.0)
    else:
        volume = mesh_volume(shape.mesh) if mesh_volume is not None and shape.mesh is not None else None
        if volume is None:
            return None
        even = volume.filled(1.0)
    density = shape.mass_kg / even.mass_kg if shape.mass_kg is not None else shape.density_kgm3
    return None if density is None else scaled(even, density)
