"""The node hierarchy: the pose of each node in the model, metres (glTF 2.0, sections 3.5 and 3.6.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assetkit.readers.gltf.json import Json
from schemas.diagnostics import InvalidInput, Label, finding

_IDENTITY: Final = tuple(float(i % 5 == 0) for i in range(16))
# Paths repeat the names above them; a deep chain of long names would grow without bound.
MAX_PATH_CHARACTERS: Final = 64 * 2**20


@dataclass(frozen=True)
class PlacedNode:
    """A node of the scene, number `index` in the file.

    `X_PN` and `X_MN` place it in its parent and in the model: row-major 4x4, metres.
    """

    index: int
    path: str
    X_PN: np.ndarray
    X_MN: np.ndarray
    mesh: int | None
    weights: tuple[float, ...] | None


def place_nodes(document: Json) -> tuple[PlacedNode, ...]:
    """All nodes of the default scene, parents before children, children in file order.

    Without a default scene: the only scene, else all root nodes. Any depth works.
    Raises InvalidInput: `asset/cyclic-reference` when a node contains itself or has several parents,
    `asset/schema-error` for wrong types, `asset/resource-limit` when paths exceed 64 MiB in all.
    """
    nodes, meshes = document.items("nodes"), document.items("meshes")
    children = tuple(tuple(c.as_index(nodes, "nodes") for c in node.items("children")) for node in nodes)
    has_parent = _check_tree(nodes, children)
    placed: list[PlacedNode] = []
    visited: set[int] = set()
    characters = 0
    waiting = [(root, "", np.eye(4)) for root in reversed(_roots(document, nodes, has_parent))]
    while waiting:
        index, parent_path, X_MP = waiting.pop()
        if index in visited:
            raise _cyclic(nodes[index], "the scene reaches the node twice")
        visited.add(index)
        node = nodes[index]
        path = f"{parent_path}/{node.string('name', '') or f'node_{index}'}"
        characters += len(path)
        if characters > MAX_PATH_CHARACTERS:
            headline = "node paths grow beyond 64 MiB"
            raise InvalidInput(
                finding(
                    "asset/resource-limit",
                    headline,
                    where=node.where,
                    value=characters,
                    bound=MAX_PATH_CHARACTERS,
                    unit="characters",
                )
            )
        X_PN = _local_transform(node)
        with np.errstate(all="ignore"):  # Overflow shows as a non-finite vertex where it matters.
            X_MN = X_MP @ X_PN
        weights = node.get("weights")
        numbers = None if weights is None else tuple(w.as_number() for w in weights.elements())
        placed.append(PlacedNode(index, path, X_PN, X_MN, node.index("mesh", meshes, "meshes"), numbers))
        waiting.extend((child, path, X_MN) for child in reversed(children[index]))
    return tuple(placed)


def _check_tree(nodes: tuple[Json, ...], children: tuple[tuple[int, ...], ...]) -> list[bool]:
    """Whether each node has a parent, once it is certain that the nodes form trees."""
    parent: list[int | None] = [None] * len(nodes)
    for index, below in enumerate(children):
        for child in below:
            first = parent[child]
            if first is not None:
                raise _cyclic(nodes[child], "the node has several parents", nodes[first], nodes[index])
            parent[child] = index
    reached = [index for index, above in enumerate(parent) if above is None]
    for index in reached:  # Grows while it is walked: breadth first from the roots.
        reached.extend(children[index])
    if len(reached) < len(nodes):
        inside = min(set(range(len(nodes))) - set(reached))
        raise _cyclic(nodes[inside], "the node contains itself")
    return [above is not None for above in parent]


def _roots(document: Json, nodes: tuple[Json, ...], has_parent: list[bool]) -> list[int]:
    scenes = document.items("scenes")
    scene = document.index("scene", scenes, "scenes")
    if scene is None and len(scenes) != 1:
        return [index for index in range(len(nodes)) if not has_parent[index]]
    listed = scenes[scene or 0].items("nodes")
    return list(dict.fromkeys(n.as_index(nodes, "nodes") for n in listed))


def _local_transform(node: Json) -> np.ndarray:
    """The node's pose in its parent: `matrix` (column-major in the file), or translation, rotation and scale."""
    if node.get("matrix") is not None:
        X_PN = np.array(node.vector("matrix", _IDENTITY)).reshape(4, 4).T
        if not np.allclose(X_PN[3], (0.0, 0.0, 0.0, 1.0), rtol=0.0, atol=1e-6):
            raise node.require("matrix").schema_error("the matrix is not affine")
        X_PN[3] = (0.0, 0.0, 0.0, 1.0)
        return X_PN
    X_PN = np.eye(4)
    rotation = rotations(np.array([node.vector("rotation", (0.0, 0.0, 0.0, 1.0))]))[0]
    X_PN[:3, :3] = rotation * node.vector("scale", (1.0, 1.0, 1.0))
    X_PN[:3, 3] = node.vector("translation", (0.0, 0.0, 0.0))
    return X_PN


def rotations(quats_xyzw: np.ndarray) -> np.ndarray:
    """(n, 3, 3) rotations of (n, 4) quaternions of any length; the zero quaternion turns nothing."""
    largest = np.abs(quats_xyzw).max(axis=1, keepdims=True)
    q = np.where(largest > 0.0, quats_xyzw / np.where(largest > 0.0, largest, 1.0), [0.0, 0.0, 0.0, 1.0])
    x, y, z, w = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _cyclic(node: Json, headline: str, *others: Json) -> InvalidInput:
    labels = tuple(Label(where=o.where, text="parent") for o in others)
    return InvalidInput(finding("asset/cyclic-reference", headline, where=node.where, labels=labels))
