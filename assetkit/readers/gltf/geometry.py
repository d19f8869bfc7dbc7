"""Triangles of the whole scene: every primitive baked into the model frame under each node that shows it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from assetkit.readers.common.corners import MAX_TRIANGLES, Notes
from assetkit.readers.gltf.accessors import Accessors
from assetkit.readers.gltf.buffers import Buffers
from assetkit.readers.gltf.instances import instances
from assetkit.readers.gltf.json import Json
from assetkit.readers.gltf.nodes import PlacedNode
from assetkit.readers.gltf.primitives import Primitive, draws_triangles, read_primitive, unit_or_none
from assetkit.readers.gltf.skins import Skins, posed
from schemas.diagnostics import InvalidInput, Location, Severity, finding
from schemas.model import Mesh, Node


class Geometry:
    """Reads each mesh once per set of morph weights and bakes it under every node that shows it."""

    def __init__(self, document: Json, buffers: Buffers) -> None:
        self._document = document
        self._buffers = buffers
        self._accessors = Accessors(document, buffers)
        self._meshes = document.items("meshes")
        self._nodes = document.items("nodes")
        self._materials = document.items("materials")
        self._read: dict[tuple[int, tuple[float, ...], bool], tuple[tuple[Json, Primitive], ...]] = {}
        self._notes = Notes()
        self._without_faces = 0
        # Lengths in the frame of a mesh, by index of its material: metres per unit at each place that is drawn.
        self.scales_of_material: dict[int, list[float]] = {}

    def bake(self, placed: tuple[PlacedNode, ...]) -> tuple[tuple[Mesh, ...], tuple[Node, ...], Notes]:
        """Meshes in the model frame (`material` still counts in the file's list), nodes, and findings.

        Raises InvalidInput `asset/no-faces`, `asset/empty-geometry`, `asset/resource-limit` and as `read_primitive`.
        """
        meshes: list[Mesh] = []
        nodes: list[Node] = []
        triangles = 0
        skins = Skins(self._document, self._accessors, placed)
        for node in placed:
            first = len(meshes)
            X_MJ = None if node.mesh is None else skins.of(node)
            copies = None if node.mesh is None else instances(self._nodes[node.index], self._accessors)
            for primitive, geometry in self._primitives(node, skinned=X_MJ is not None):
                triangles += len(geometry.triangles) * (1 if copies is None else len(copies))
                self._check_triangles(triangles, primitive)
                if X_MJ is not None and geometry.influences is not None:
                    held = posed(geometry, X_MJ, primitive.where)
                    meshes.append(self._baked(node, primitive, held, np.eye(4)))
                elif copies is None:
                    meshes.append(self._baked(node, primitive, geometry, node.X_MN))
                else:
                    baked = (
                        self._baked(node, primitive, geometry, node.X_MN @ X_NC, i) for i, X_NC in enumerate(copies)
                    )
                    meshes.extend(baked)
            nodes.append(Node(node.path, node.X_PN, tuple(range(first, len(meshes)))))
        if not meshes:
            self._fail_empty()
        if self._without_faces:
            headline = f"{self._without_faces} primitives of points or lines were left out"
            where = Location(file=self._document.file)
            self._notes += Notes((finding("asset/geometry-left-out", headline, where=where, severity=Severity.INFO),))
        return tuple(meshes), tuple(nodes), self._notes

    def _primitives(self, node: PlacedNode, *, skinned: bool) -> tuple[tuple[Json, Primitive], ...]:
        if node.mesh is None:
            return ()
        mesh = self._meshes[node.mesh]
        weights = node.weights
        if weights is None:
            weights = tuple(w.as_number() for w in mesh.items("weights"))
        key = (node.mesh, weights, skinned)
        if key not in self._read:
            self._read[key] = tuple(self._read_mesh(mesh, weights, skinned))
        return self._read[key]

    def _read_mesh(self, mesh: Json, weights: tuple[float, ...], skinned: bool) -> list[tuple[Json, Primitive]]:
        result: list[tuple[Json, Primitive]] = []
        for primitive in mesh.require("primitives").elements():
            if not draws_triangles(primitive):
                self._without_faces += 1
                continue
            name = self._name(mesh, primitive)
            geometry, notes = read_primitive(primitive, self._accessors, self._buffers, weights, name, skinned=skinned)
            self._notes += notes
            if geometry is not None:
                result.append((primitive, geometry))
        return result

    def _name(self, mesh: Json, primitive: Json) -> str:
        name = mesh.string("name", "") or f"mesh_{mesh.key}"
        return name if len(mesh.items("primitives")) == 1 else f"{name}_{primitive.key}"

    def _baked(
        self, node: PlacedNode, primitive: Json, geometry: Primitive, X_MG: np.ndarray, copy: int | None = None
    ) -> Mesh:
        mesh = self._meshes[int(primitive.pointer.split("/")[2])]
        name = self._name(mesh, primitive)
        where = primitive.where.model_copy(update={"mesh": name})
        placed = _placed(geometry, X_MG, where)
        name = name if copy is None else f"{name}_{copy}"
        return Mesh(
            name=name,
            points=placed.points,
            triangles=placed.triangles,
            normals=placed.normals,
            uvs=placed.uvs,
            colors=placed.colors,
            material=self._material(primitive, X_MG),
            source_path=f"{node.path}/{name}",
        )

    def _material(self, primitive: Json, X_MG: np.ndarray) -> int | None:
        index = primitive.index("material", self._materials, "materials")
        if index is not None:
            scale = abs(float(np.linalg.det(X_MG[:3, :3]))) ** (1.0 / 3.0)
            self.scales_of_material.setdefault(index, []).append(scale)
        return index

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


def _placed(geometry: Primitive, X_MG: np.ndarray, where: Location) -> Primitive:
    """`geometry` in the model frame.

    A mirroring transform (negative determinant) turns faces inside out, so their corners are reversed (glTF 2.0,
    3.7.4). Normals follow the inverse transpose, written as cofactors times the determinant's sign so that flat scales
    work.
    """
    linear = X_MG[:3, :3]
    with np.errstate(all="ignore"):
        points = geometry.points @ linear.T + X_MG[:3, 3]
        mirrored = bool(np.linalg.det(linear) < 0.0)
        cofactors = np.cross(linear[[1, 2, 0]], linear[[2, 0, 1]]) * (-1.0 if mirrored else 1.0)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        headline = f"mesh '{where.mesh}' overflows when its node transforms are applied"
        raise InvalidInput(
            finding("asset/nonfinite-vertices", headline, where=where, value=len(bad), bound=0, unit="vertices")
        )
    normals = None if geometry.normals is None else unit_or_none(geometry.normals @ cofactors.T)
    placed = replace(geometry, points=points, normals=normals)
    return placed.reversed() if mirrored else placed
