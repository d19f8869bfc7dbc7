"""Stated masses (kg, kg m2) and contacts of a glTF file: KHR_physics_rigid_bodies (draft) and OMI_physics_body."""

from __future__ import annotations

from typing import Final, cast, get_args

import numpy as np

from assetkit.readers.gltf.json import Json
from assetkit.readers.gltf.nodes import PlacedNode
from geom.mass.principal_axes import inertia_from_principal, rotated_tensor
from geom.pose import apply, to_wxyz
from schemas.diagnostics import Diagnostic, finding
from schemas.model import Mesh, Node
from schemas.stated_physics import Combine, StatedContact, StatedMass

KHR: Final = "KHR_physics_rigid_bodies"
OMI: Final = "OMI_physics_body"
_ORIGIN, _NO_TURN = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)


class GltfPhysics:
    """The bodies of a scene: nodes with a `motion`, each with the meshes that move with it."""

    def __init__(
        self, document: Json, placed: tuple[PlacedNode, ...], nodes: tuple[Node, ...], meshes: tuple[Mesh, ...]
    ) -> None:
        self._document = document
        self._json = document.items("nodes")
        self._placed = {node.index: node for node in placed}
        self._own = {p.index: [meshes[m] for m in node.meshes] for p, node in zip(placed, nodes, strict=True)}

    def masses(self) -> tuple[StatedMass, ...]:
        """One statement per moving node with a mass, in the frame of the model.

        A mass of zero means infinite (KHR) or none (OMI); an inertia with a zero is computed by the engine. The mass
        centre goes through the whole node transform; the tensor, in kg m^2 by either text, is only turned.
        """
        return tuple(
            statement
            for index in self._placed
            for name in (KHR, OMI)
            if (motion := self._motion(index, name)) is not None
            and (statement := self._mass(index, name, motion)) is not None
        )

    def contacts(self) -> tuple[StatedContact, ...]:
        """One statement per physics material, over the meshes of the nodes or bodies whose colliders use it."""
        root = self._document.object("extensions").get(KHR)
        materials = () if root is None else root.items("physicsMaterials")
        covers: dict[int, dict[str, None]] = {}
        for index in self._placed:
            extension = self._json[index].extension(KHR)
            collider = None if extension is None else extension.get("collider")
            material = None if collider is None else collider.index("physicsMaterial", materials, "physicsMaterials")
            if material is not None:
                meshes = self._own[index] or self._meshes_below(self._body_above(index))
                covers.setdefault(material, {}).update(dict.fromkeys(m.source_path for m in meshes))
        return tuple(_contact(materials[i], tuple(paths)) for i, paths in covers.items() if paths)

    def joints(self) -> tuple[Diagnostic, ...]:
        """A warning when nodes are jointed: the joints are not carried over."""
        jointed = [self._json[i] for i in self._placed if (e := self._json[i].extension(KHR)) and e.get("joint")]
        if not jointed:
            return ()
        headline = f"the source declares {len(jointed)} joints, which are not carried over"
        return (finding("asset/articulated-source", headline, where=jointed[0].where, value=len(jointed)),)

    def _motion(self, index: int, name: str) -> Json | None:
        """The `motion` of a node. The first draft of OMI_physics_body kept its members one level higher."""
        extension = self._json[index].extension(name)
        if extension is None:
            return None
        early = extension if name == OMI and extension.get("type") is not None else None
        return extension.get("motion") or early

    def _mass(self, index: int, name: str, motion: Json) -> StatedMass | None:
        mass = motion.number("mass", 0.0)
        if mass == 0.0:
            return None
        X_MN = self._placed[index].X_MN
        inertia = _inertia(motion)
        covered = self._meshes_below(index)
        return StatedMass(
            covers=tuple(dict.fromkeys(m.source_path for m in covered)),
            triangles=sum(len(m.triangles) for m in covered),
            method=name,
            where=motion.where,
            mass_kg=mass,
            centre=apply(X_MN, _vector(motion, "centerOfMass")[None])[0] if motion.get("centerOfMass") else None,
            inertia=None if inertia is None else rotated_tensor(inertia, X_MN[:3, :3]),
        )

    def _meshes_below(self, index: int) -> list[Mesh]:
        """Meshes at the node and below it, without those of bodies further down."""
        below, waiting = list[Mesh](), [index]
        while waiting:
            node = waiting.pop()
            below += self._own.get(node, [])
            children = [child.as_index(self._json, "nodes") for child in self._json[node].items("children")]
            waiting += [c for c in reversed(children) if not self._moves(c)]
        return below

    def _body_above(self, index: int) -> int:
        """The moving node at or above the node, else its root."""
        above = {c.as_index(self._json, "nodes"): i for i in self._placed for c in self._json[i].items("children")}
        while not self._moves(index) and index in above:
            index = above[index]
        return index

    def _moves(self, index: int) -> bool:
        return any(self._motion(index, name) is not None for name in (KHR, OMI))


def _inertia(motion: Json) -> np.ndarray | None:
    """The tensor in the node's frame, None when the file leaves it to the engine."""
    full = motion.get("inertiaTensor")  # First draft of OMI_physics_body.
    if full is not None:
        tensor = np.array(motion.vector("inertiaTensor", (0.0,) * 9)).reshape(3, 3)
        return tensor if tensor.any() else None
    moments = _vector(motion, "inertiaDiagonal")
    if not moments.all():
        return None
    quat_xyzw = np.array(motion.vector("inertiaOrientation", _NO_TURN))
    return inertia_from_principal(moments, to_wxyz(quat_xyzw if quat_xyzw.any() else np.array(_NO_TURN)))


def _contact(material: Json, covers: tuple[str, ...]) -> StatedContact:
    def stated(key: str) -> float | None:
        return None if material.get(key) is None else material.number(key, 0.0)

    combine = material.string("frictionCombine", "average")
    return StatedContact(
        covers=covers,
        name=material.string("name", f"material_{material.key}"),
        method=KHR,
        where=material.where,
        static_friction=stated("staticFriction"),
        dynamic_friction=stated("dynamicFriction"),
        restitution=stated("restitution"),
        combine=cast(Combine, combine) if combine in get_args(Combine) else "average",
    )


def _vector(motion: Json, key: str) -> np.ndarray:
    return np.array(motion.vector(key, _ORIGIN), dtype=np.float64)
