"""Checks of texture coordinates: each textured mesh has those that its material reads, and they span an area."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from schemas.appearance.optics import effective
from schemas.arrays import Float32Array
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.model import Mesh, Model

# Coordinates of a picture of 16384 texels a side, the largest that is released, are 6e-5 apart.
_LEAST_SPAN = 1e-5


def check_coordinates(model: Model) -> tuple[Diagnostic, ...]:
    """A finding per mesh and set of coordinates that is missing, not finite, or in one point.

    Only the sets that the textures of the mesh's material read count, and only of meshes with triangles.
    """
    return tuple(note for mesh in model.meshes for note in _of_mesh(model, mesh))


def _of_mesh(model: Model, mesh: Mesh) -> Iterator[Diagnostic]:
    if mesh.material is None or len(mesh.triangles) == 0:
        return
    material = model.materials[mesh.material]
    uses = effective(material).texture_uses.values()
    where = Location(prim=mesh.source_path or mesh.name)
    for uv_set in sorted({use.uv_set for use in uses}):
        if uv_set >= len(mesh.uvs):
            headline = f"mesh '{mesh.name}' has no set {uv_set} of texture coordinates for material '{material.name}'"
            yield finding("asset/missing-texture-coordinates", headline, where=where, value=len(mesh.uvs))
            continue
        uvs = mesh.uvs[uv_set]
        bad = ~np.isfinite(uvs.reshape(len(uvs), -1)).all(axis=1)
        if bad.any():
            headline = f"{int(bad.sum())} of {len(uvs)} triangles of mesh '{mesh.name}' have coordinates that are none"
            yield finding("asset/nonfinite-texture-coordinates", headline, where=where, value=int(bad.sum()))
        if not bad.all() and in_one_point(uvs[~bad]):
            headline = f"all texture coordinates of mesh '{mesh.name}' in set {uv_set} lie in one point"
            yield finding("asset/collapsed-texture-coordinates", headline, where=where, bound=_LEAST_SPAN)


def in_one_point(uvs: Float32Array) -> bool:
    """Whether coordinates (m, 3, 2) span less than a texel of the largest picture, in both directions."""
    flat = uvs.reshape(-1, 2)
    return bool(np.ptp(flat, axis=0).max() < _LEAST_SPAN)
