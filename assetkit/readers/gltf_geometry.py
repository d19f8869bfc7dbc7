"""Triangles of the whole scene: every primitive baked into the model frame under each node that shows it."""

from __future__ import annotations

from typing import Final

import numpy as np

from assetkit.readers.corners import Notes
from assetkit.readers.gltf_accessors import Accessors
from assetkit.readers.gltf_buffers import Buffers
from assetkit.readers.gltf_json import Json
from assetkit.readers.gltf_nodes import PlacedNode
from assetkit.readers.gltf_primitives import Primitive, draws_triangles, read_primitive, unit_or_none
from schemas.diagnostics import InvalidInput, Location, finding
from schemas.model import Mesh, Node

MAX_TRIANGLES: Final = 20_000_000


class Geometry:
    """Reads each mesh once per set of morph weights and bakes it under every node that shows it."""

    def __init__(self, document: Json, buffers: Buffers) -> None:
        self._document = document
        self._buffers = buffers
        self._accessors = Accessors(document, buffers)
        self._meshes = document.items("meshes")
        self._materials = document.items("materials")
        self._read: dict[tuple[int, tuple[float, ...]], tuple[tuple[Json, Primitive], ...]] = {}
        self._notes = Notes()
        self._without_faces = 0

    def bake(self, placed: tuple[PlacedNode, ...]) -> tuple[tuple[Mesh, ...], tuple[Node, ...], Notes]:
        """Meshes in the model frame (`material` still counts in the file's list), nodes, and findings.

        Raises InvalidInput `asset/no-faces`, `asset/empty-geometry`, `asset/resource-limit` and as `read_primitive`.
        """
        meshes: list[Mesh] = []
        nodes: list[Node] = []
        triangles = 0
        for node in placed:
            first = len(meshes)
            for primitive, geometry in self._primitives(node):
                triangles += len(geometry.triangles)
                self._check_triangles(triangles, primitive)
                meshes.append(self._baked(node, primitive, geometry))
            nodes.append(Node(node.path, node.X_PN, tuple(range(first, len(meshes)))))
        if not meshes:
            self._fail_empty()
        return tuple(meshes), tuple(nodes), self._notes

    def _primitives(self, node: PlacedNode) -> tuple[tuple[Json, Primitive], ...]:
        if node.mesh is None:
            return ()
        mesh = self._meshes[node.mesh]
        weights = node.weights
        if weights is None:
            weights = tuple(w.as_number() for w in mesh.items("weights"))
        key = (node.mesh, weights)
        if key not in self._read:
            self._read[key] = tuple(self._read_mesh(mesh, weights))
        return self._read[key]

    def _read_mesh(self, mesh: Json, weights: tuple[float, ...]) -> list[tuple[Json, Primitive]]:
        result: list[tuple[Json, Primitive]] = []
        for primitive in mesh.require("primitives").elements():
            if not draws_triangles(primitive):
                self._without_faces += 1
                continue
            name = self._name(mesh, primitive)
            geometry, notes = read_primitive(primitive, self._accessors, self._buffers, weights, name)
            self._notes += notes
            if geometry is not None:
                result.append((primitive, geometry))
        return result

    def _name(self, mesh: Json, primitive: Json) -> str:
        name = mesh.string("name", "") or f"mesh_{mesh.key}"
        return name if len(mesh.items("primitives")) == 1 else f"{name}_{primitive.key}"

    def _baked(self, node: PlacedNode, primitive: Json, geometry: Primitive) -> Mesh:
        mesh = self._meshes[int(primitive.pointer.split("/")[2])]
        name = self._name(mesh, primitive)
        where = primitive.where.model_copy(update={"mesh": name})
        points, triangles, normals, turned = _placed(geometry, node.X_MN, where)
        uvs, colors = geometry.uvs, geometry.colors
        if turned:
            uvs = tuple(uv[:, ::-1] for uv in uvs)
            colors = None if colors is None else colors[:, ::-1]
        return Mesh(
            name=name,
            points=points,
            triangles=triangles,
            normals=normals,
            uvs=uvs,
            colors=colors,
            material=primitive.index("material", self._materials, "materials"),
            source_path=f"{node.path}/{name}",
        )

    def _check_triangles(self, triangles: int, primitive: Json) -> None:
        if triangles > MAX_TRIANGLES:
            raise InvalidInput(
                finding(
                    "asset/resource-limit",
                    "the nodes of the scene draw too many triangles in all",
                    where=primitive.where,
                    value=triangles,
                    bound=MAX_TRIANGLES,
                    unit="triangles",
                )
            )

    def _fail_empty(self) -> None:
        where = Location(file=self._document.file)
        if self._without_faces:
            headline = f"the scene has {self._without_faces} primitives of points or lines and no triangles"
            raise InvalidInput(finding("asset/no-faces", headline, where=where, value=self._without_faces))
        headline = f"the scene shows no triangles; the file has {len(self._meshes)} meshes"
        raise InvalidInput(finding("asset/empty-geometry", headline, where=where, value=len(self._meshes)))


def _placed(
    geometry: Primitive, X_MN: np.ndarray, where: Location
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, bool]:
    """Points, triangles and normals of `geometry` in the model frame, and whether corners run backwards now.

    A mirroring node (negative determinant) turns faces inside out, so their corners are reversed (glTF 2.0, 3.7.4).
    Normals follow the inverse transpose, written as cofactors times the determinant's sign so that flat scales work.
    """
    linear = X_MN[:3, :3]
    with np.errstate(all="ignore"):
        points = geometry.points @ linear.T + X_MN[:3, 3]
        turned = bool(np.linalg.det(linear) < 0.0)
        cofactors = np.cross(linear[[1, 2, 0]], linear[[2, 0, 1]]) * (-1.0 if turned else 1.0)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        headline = f"mesh '{where.mesh}' overflows when its node transforms are applied"
        raise InvalidInput(
            finding("asset/nonfinite-vertices", headline, where=where, value=len(bad), bound=0, unit="vertices")
        )
    normals = None if geometry.normals is None else unit_or_none(geometry.normals @ cofactors.T)
    if not turned:
        return points, geometry.triangles, normals, False
    return points, geometry.triangles[:, ::-1], None if normals is None else normals[:, ::-1], True
