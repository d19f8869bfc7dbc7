"""The internal representation every format is read into: meshes, materials, textures, hierarchy, evidence.

All values are immutable; editing means `dataclasses.replace`. Arrays are not copied: treat them as read-only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from pydantic import ConfigDict

from schemas.appearance.material import Material, Texture
from schemas.arrays import Float32Array, FloatArray, IntArray
from schemas.evidence import Evidence
from schemas.identifiers import unique_identifiers
from schemas.mechanism import Mechanism
from schemas.stated_physics import StatedContact, StatedMass

MESH_FALLBACK = "mesh"  # The id of a mesh whose name has no letter or digit.
Axis = Literal["x", "y", "z"]


@dataclass(frozen=True)
class Mesh:
    """Triangles with per-corner attributes, so that welding points never harms UV seams or hard edges.

    points     (n, 3) float64, in the frame of the model (node transforms already applied), source units and axes
               until canonicalisation, metres and z-up after it.
    triangles  (m, 3) int32, counter-clockwise seen from outside.
    normals    (m, 3, 3) float32 unit corner normals, or None.
    uvs        one (m, 3, 2) float32 array per UV set, v pointing up (USD convention).
    colors     (m, 3, 4) float32 linear RGBA, or None.
    material   index into Model.materials, or None.
    source_path  where the mesh stood in the source hierarchy, e.g. "/scene/handle/mesh_0".
    id         an identifier, unique within the model; given once, at intake (`Model.with_mesh_ids`), empty before.
               Parts, USD prims and files refer to the mesh by it.
    link       name of the link of the model's mechanism that it belongs to; "" in an object without one.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    name: str
    points: FloatArray
    triangles: IntArray
    normals: Float32Array | None = None
    uvs: tuple[Float32Array, ...] = ()
    colors: Float32Array | None = None
    material: int | None = None
    source_path: str = ""
    id: str = ""
    link: str = ""


@dataclass(frozen=True)
class Node:
    """One node of the source hierarchy, kept for provenance and part proposals; `X_PN` is row-major 4x4."""

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    path: str
    X_PN: FloatArray
    meshes: tuple[int, ...] = ()


@dataclass(frozen=True)
class Model:
    """A source asset in memory.

    `meters_per_unit` and `up_axis` are Evidence: `declared` when the format or file states them, `default` when
    it does not. `hints` are texts that may reveal units or axes (comments, generator names), verbatim.
    `metadata` holds statements of the file about itself (author, licence, copyright, generator), `masses` and
    `contacts` its statements on the physics of its meshes. `mechanism` says how its links move, if it has several.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    meshes: tuple[Mesh, ...]
    materials: tuple[Material, ...]
    textures: tuple[Texture, ...]
    nodes: tuple[Node, ...]
    meters_per_unit: Evidence[float]
    up_axis: Evidence[Axis]
    hints: tuple[str, ...] = ()
    metadata: dict[str, str] = field(default_factory=dict[str, str])
    masses: tuple[StatedMass, ...] = ()
    contacts: tuple[StatedContact, ...] = ()
    mechanism: Mechanism | None = None

    @property
    def triangle_count(self) -> int:
        """Triangles over all meshes."""
        return sum(len(m.triangles) for m in self.meshes)

    def with_mesh_ids(self) -> Model:
        """The model with an id for every mesh, made from its name; ids that meshes had are replaced."""
        ids = unique_identifiers((mesh.name for mesh in self.meshes), MESH_FALLBACK)
        return replace(self, meshes=tuple(replace(m, id=i) for m, i in zip(self.meshes, ids, strict=True)))

    @property
    def meshes_by_id(self) -> Mapping[str, Mesh]:
        """The meshes by their ids, in order. Raises ValueError unless every mesh has an id of its own."""
        result = {mesh.id: mesh for mesh in self.meshes}
        if "" in result or len(result) < len(self.meshes):
            raise ValueError("meshes of a model without ids of their own; `with_mesh_ids` gives them")
        return result
