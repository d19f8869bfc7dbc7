"""Input and output types of the bounded edits: a mesh among all meshes in, the edited mesh with figures out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from geom.mesh.edit import merge_surfaces
from geom.repair.fill_uncertainty import ShapeUncertainty
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh

Counts = Mapping[str, float]
Surface = tuple[FloatArray, IntArray]


@dataclass(frozen=True)
class EditContext:
    """One mesh on its way through the edits, and all meshes at this point, of which it is number `index`."""

    source: Mesh
    index: int
    meshes: Sequence[Mesh]

    @property
    def mesh(self) -> Mesh:
        """The mesh as edited so far."""
        return self.meshes[self.index]

    @property
    def others(self) -> Surface:
        """The surface of the other meshes."""
        points, triangles, _ = merge_surfaces([m for i, m in enumerate(self.meshes) if i != self.index])
        return points, triangles


@dataclass(frozen=True)
class Edit:
    """An edited mesh; `before` and `after` are None when nothing was wrong enough to be reported.

    `uncertainty` is how far the edit may have moved the surface from the true shape, where that is not the distance
    between the surfaces before and after: see `assetkit.geometry.distortion`.
    """

    mesh: Mesh
    before: Counts | None = None
    after: Counts = field(default_factory=dict[str, float])
    uncertainty: ShapeUncertainty | None = None
