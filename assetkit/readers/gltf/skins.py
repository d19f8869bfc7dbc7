"""Skinned meshes in the pose their joints are stored in (glTF 2.0, section 3.7.3)."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from assetkit.readers.gltf.accessors import Accessors
from assetkit.readers.gltf.json import Json
from assetkit.readers.gltf.nodes import PlacedNode
from assetkit.readers.gltf.primitives import Primitive, unit_or_none
from schemas.diagnostics import InvalidInput, Location, finding

MAX_JOINTS: Final = 65_536


class Skins:
    """The joint transforms of a document's skins: `X_MJ` takes a point of the bind space to the model frame."""

    def __init__(self, document: Json, accessors: Accessors, placed: tuple[PlacedNode, ...]) -> None:
        self._skins = document.items("skins")
        self._nodes = document.items("nodes")
        self._accessors = accessors
        self._X_MN = {node.index: node.X_MN for node in placed}

    def of(self, node: PlacedNode) -> np.ndarray | None:
        """(j, 4, 4) transforms of the joints of the node's skin; None without one, or when a joint is not shown.

        The node's own transform does not count: joints alone place the vertices (3.7.3.3).
        Raises InvalidInput `asset/schema-error` for skins that break the format.
        """
        index = self._nodes[node.index].index("skin", self._skins, "skins")
        if index is None:
            return None
        skin = self._skins[index]
        joints = [j.as_index(self._nodes, "nodes") for j in skin.require("joints").elements()]
        if not joints or any(j not in self._X_MN for j in joints):
            return None
        X_MJ = np.array([self._X_MN[j] for j in joints])
        bind = skin.get("inverseBindMatrices")
        if bind is None:
            return X_MJ
        inverse = self._accessors.read(bind, "MAT4").astype(np.float64)
        if len(inverse) < len(joints):
            raise skin.schema_error(f"{len(inverse)} inverse bind matrices for {len(joints)} joints")
        with np.errstate(all="ignore"):
            return X_MJ @ inverse[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)


def posed(geometry: Primitive, X_MJ: np.ndarray, where: Location) -> Primitive:
    """`geometry` posed by its joints (linear blend skinning), in the model frame.

    A vertex without weights follows the first joint. Where the joints mirror, corners run the other way.
    Raises InvalidInput `asset/schema-error` for a weighted joint that is not there and `asset/nonfinite-vertices`.
    """
    if geometry.influences is None:
        return geometry
    joints, weights = geometry.influences
    weights = np.where(np.isfinite(weights) & (weights > 0.0), weights, 0.0)
    if (joints[weights > 0.0] >= len(X_MJ)).any():
        headline = f"a vertex follows joint {int(joints[weights > 0.0].max())} of {len(X_MJ)}"
        raise InvalidInput(finding("asset/schema-error", headline, where=where))
    total = weights.sum(axis=1, keepdims=True)
    weights = np.where(total > 0.0, weights / np.where(total > 0.0, total, 1.0), np.eye(weights.shape[1])[0])
    with np.errstate(all="ignore"):
        blend = np.zeros((len(geometry.points), 3, 4))
        for column in range(weights.shape[1]):  # One at a time: all at once would need the memory of every influence.
            reach = np.minimum(joints[:, column], len(X_MJ) - 1)
            blend += weights[:, column, None, None] * X_MJ[reach, :3]
        A = blend[:, :, :3]
        points = np.einsum("nij,nj->ni", A, geometry.points) + blend[:, :, 3]
        mirrored = bool(np.median(np.linalg.det(A)) < 0.0)
        cofactors = np.cross(A[:, [1, 2, 0]], A[:, [2, 0, 1]]) * (-1.0 if mirrored else 1.0)
    if not np.isfinite(points).all():
        raise InvalidInput(finding("asset/nonfinite-vertices", "the joints throw vertices out of range", where=where))
    normals = geometry.normals
    if normals is not None:
        normals = unit_or_none(np.einsum("mcij,mcj->mci", cofactors[geometry.triangles], normals.astype(np.float64)))
    moved = replace(geometry, points=points, normals=normals, influences=None)
    return moved.reversed() if mirrored else moved
