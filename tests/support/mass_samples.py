"""Meshes for the tests of mass, and the way from meshes to mass evidence that a file would take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import trimesh
from numpy.testing import assert_allclose

from assetkit.geometry.canonical_model import canonicalize
from assetkit.mass.estimate import MassEvidence, mass_evidence
from assetkit.options import Options
from assetkit.physics.mass_inputs import mass_inputs_of
from assetkit.stage import Canonical, Draft, Intake
from geom.features.cavities import find_cavities
from geom.mass.inertia import moved, of_box
from geom.pose import pose
from schemas.appearance.material import Material
from schemas.evidence import Evidence, declared
from schemas.model import Mesh
from schemas.physics import MassProperties
from tests.support.package_samples import mesh_from
from tests.support.package_samples import model as model_of

WOOD, STEEL = 650.0, 7850.0
NOWHERE = (0.0, 0.0, 0.0)
METRES = declared(1.0, "test")


def weighed(
    meshes: Sequence[Mesh],
    options: Options | None = None,
    *,
    unit: Evidence[float] = METRES,
    file: str = "wood.obj",
    materials: Sequence[Material] = (),
) -> tuple[MassEvidence, Canonical, MassProperties]:
    """The evidence, the canonical object and the mass properties in the frame of the meshes."""
    model = replace(model_of(meshes, materials), meters_per_unit=unit)
    points = np.concatenate([m.points for m in meshes])
    x, y, z = (float(v) for v in np.ptp(points, axis=0))
    item = Intake("obj", (), model, (x, y, z))
    canonical = canonicalize(item, file, options or Options()).value
    assert canonical is not None
    mass_inputs = mass_inputs_of(Draft("case", file, item, canonicalize=canonical), canonical)
    mass = mass_evidence(canonical.solid, [file], replace(mass_inputs, cavities=find_cavities(canonical.solid)))
    back = pose(None, -np.asarray(canonical.section.origin_offset_m))
    return mass, canonical, moved(mass.properties, back)


def box(size, at=NOWHERE, name="part") -> Mesh:
    mesh = trimesh.creation.box(size)
    mesh.apply_translation(at)
    return mesh_from(mesh, name)


def ball(radius, at=NOWHERE, subdivisions=4) -> Mesh:
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    mesh.apply_translation(at)
    return mesh_from(mesh, "ball")


def join_meshes(*meshes: Mesh) -> Mesh:
    offsets = np.cumsum([0, *(len(m.points) for m in meshes)])
    return Mesh(
        "joined",
        np.concatenate([m.points for m in meshes]),
        np.concatenate([m.triangles + np.int32(o) for m, o in zip(meshes, offsets, strict=False)]).astype(np.int32),
    )


def inside_out(mesh: Mesh) -> Mesh:
    return replace(mesh, triangles=mesh.triangles[:, ::-1].copy())


def with_faces(mesh: Mesh, extra) -> Mesh:
    return replace(mesh, triangles=np.concatenate([mesh.triangles, np.array(extra, dtype=np.int32)]))


def solid_box(size, at=NOWHERE, density=WOOD) -> MassProperties:
    return moved(of_box(size, density), pose(None, at))


def as_modelled(mesh: Mesh, density=WOOD) -> MassProperties:
    """Of the triangles as they stand, by trimesh."""
    body = trimesh.Trimesh(mesh.points, mesh.triangles, process=False)
    body.density = density
    return MassProperties(body.mass, body.center_mass, body.moment_inertia)


def assert_same(got: MassProperties, truth: MassProperties, rtol: float) -> None:
    """Mass relative, centre and tensor relative to the size of the body (radius of gyration)."""
    gyration = float(np.sqrt(np.trace(truth.inertia_kgm2) / truth.mass_kg))
    assert_allclose(got.mass_kg, truth.mass_kg, rtol=rtol)
    assert_allclose(got.centre_of_mass_m, truth.centre_of_mass_m, atol=rtol * gyration)
    assert_allclose(got.inertia_kgm2, truth.inertia_kgm2, atol=rtol * np.abs(truth.inertia_kgm2).max())
