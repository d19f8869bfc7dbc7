"""Walks the COLLADA scene graph: the pose and the material bindings of each instance of a geometry."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from assetkit.readers.collada.xml import Document, Element
from schemas.diagnostics import InvalidInput, finding
from schemas.model import Node

MAX_NODES = 100_000
MAX_DEPTH = 500


@dataclass(frozen=True)
class Placement:
    """One instance of a geometry. X_WG places it in the model; `bindings` maps material symbols to instances."""

    geometry: Element
    X_WG: np.ndarray
    path: str
    name: str
    bindings: dict[str, Element]


def read_scene(document: Document) -> tuple[tuple[Placement, ...], tuple[Node, ...]]:
    """Every geometry instance below the scene, depth first, and all nodes of the hierarchy.

    Skins keep their bind shape, morphs their base shape. Cameras and lights are passed over. Where the scene
    shows no geometry although the file has some, every geometry is placed once, untransformed.
    Raises InvalidInput: `asset/cyclic-reference`, `asset/resource-limit`, `asset/parse-error` for a bad transform,
    `asset/missing-dependency` for instances from other files.
    """
    placements: list[Placement] = []
    nodes: list[Node] = []
    taken: dict[str, int] = {}
    # A stack, not recursion: depth is the file's choice. Each entry: node, parent path, X_WP, instance_node chain.
    root = _visual_scene(document)
    stack: list[tuple[Element, str, np.ndarray, tuple[str, ...]]] = []
    if root is not None:
        stack = [(n, "", np.eye(4), ()) for n in reversed(root.findall("node"))]
    while stack:
        element, parent, X_WP, chain = stack.pop()
        if len(nodes) >= MAX_NODES or len(chain) > MAX_DEPTH:
            _too_many(document, element)
        label = (element.get("name") or element.get("id") or "node").replace("/", "_")
        path = f"{parent}/{label}"
        taken[path] = taken.get(path, 0) + 1
        if taken[path] > 1:
            path = f"{path}_{taken[path]}"
        X_PN = _transform(element, document)
        X_WN = X_WP @ X_PN
        nodes.append(Node(path, X_PN))
        placements += _placements(element, X_WN, path, label, document)
        children = [(n, path, X_WN, chain) for n in element.findall("node")]
        for instance in element.findall("instance_node"):
            target = _target(instance, "node", document)
            if target is not None:
                name = target.get("id") or ""
                if name in chain or target is element:
                    _cycle(document, instance, name)
                children.append((target, path, X_WN, (*chain, name)))
        stack += reversed(children)
    if not placements:
        for geometry in document.root.iter("geometry"):
            name = geometry.get("name") or geometry.get("id") or "geometry"
            placements.append(Placement(geometry, np.eye(4), "/" + name.replace("/", "_"), name, {}))
    return tuple(placements), tuple(nodes)


def _visual_scene(document: Document) -> Element | None:
    instance = document.root.find("scene/instance_visual_scene")
    scene = None if instance is None else document.find(instance.get("url"), "visual_scene")
    return scene if scene is not None else document.root.find("library_visual_scenes/visual_scene")


def _placements(node: Element, X_WN: np.ndarray, path: str, label: str, document: Document) -> Iterator[Placement]:
    for instance in node:
        if instance.tag not in {"instance_geometry", "instance_controller"}:
            continue
        X_WG, tag = X_WN, instance.tag.removeprefix("instance_")
        target = _target(instance, tag, document)
        seen: set[str] = set()
        while target is not None and target.tag == "controller":
            body = next((e for e in target if e.tag in {"skin", "morph"}), None)
            if body is None or (target.get("id") or "") in seen:
                target = None
                break
            seen.add(target.get("id") or "")
            shape = body.find("bind_shape_matrix")
            if shape is not None:
                X_WG = X_WG @ _matrix(shape, document)
            url = body.get("source")
            target = document.find(url, "geometry")
            target = document.find(url, "controller") if target is None else target
        if target is not None:
            symbols = {m.get("symbol") or "": m for m in instance.iter("instance_material")}
            yield Placement(target, X_WG, path, label, symbols)


def _target(instance: Element, tag: str, document: Document) -> Element | None:
    url = (instance.get("url") or "").strip()
    if url and not url.startswith("#") and document.find(url, tag) is None:
        raise InvalidInput(
            finding(
                "asset/missing-dependency",
                f"'{url}' is in another file, which is not followed",
                where=document.place(instance),
                value=url,
            )
        )
    return document.find(url, tag)


def _transform(node: Element, document: Document) -> np.ndarray:
    """(4, 4) X_PN of a node: the product of its transform elements in document order."""
    X = np.eye(4)
    for element in node:
        if element.tag in _TRANSFORMS:
            X = X @ _matrix(element, document)
    return X


def _matrix(element: Element, document: Document) -> np.ndarray:
    """(4, 4) matrix of one transform element; column vectors, as COLLADA has it.

    Raises InvalidInput `asset/parse-error` for the wrong count of numbers or values that are not finite.
    """
    count, make = _TRANSFORMS[element.tag]
    try:
        values = document.numbers(element)
    except ValueError:
        values = np.zeros(0)
    if len(values) == 0 and element.tag != "bind_shape_matrix":
        return np.eye(4)  # an empty element states no transform
    if len(values) != count or not np.isfinite(values).all():
        raise InvalidInput(
            finding(
                "asset/parse-error",
                f"<{element.tag}> needs {count} finite numbers",
                where=document.place(element),
                value=len(values),
                bound=count,
            )
        )
    return make(values)


def _translate(v: np.ndarray) -> np.ndarray:
    X = np.eye(4)
    X[:3, 3] = v
    return X


def _scale(v: np.ndarray) -> np.ndarray:
    return np.diag([*v, 1.0])


def _rotate(v: np.ndarray) -> np.ndarray:
    """Rotation by v[3] degrees about v[:3] (Rodrigues)."""
    length = float(np.linalg.norm(v[:3]))
    X = np.eye(4)
    if length == 0.0:
        return X
    x, y, z = v[:3] / length
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = math.radians(v[3])
    X[:3, :3] += math.sin(angle) * K + (1.0 - math.cos(angle)) * (K @ K)
    return X


def _look_at(v: np.ndarray) -> np.ndarray:
    """Eye, interest point, up: the node looks along its -z."""
    back = v[:3] - v[3:6]
    right = np.cross(v[6:9], back)
    if not np.linalg.norm(back) or not np.linalg.norm(right):
        return _translate(v[:3])
    back, right = back / np.linalg.norm(back), right / np.linalg.norm(right)
    X = _translate(v[:3])
    X[:3, :3] = np.stack([right, np.cross(back, right), back], axis=1)
    return X


def _skew(v: np.ndarray) -> np.ndarray:
    """Shear by v[0] degrees: v[1:4] is the axis rotated about, v[4:7] the axis translated along (RenderMan)."""
    along, about = v[4:7], v[1:4]
    X = np.eye(4)
    if np.linalg.norm(along) and np.linalg.norm(about):
        X[:3, :3] += math.tan(math.radians(v[0])) * np.outer(
            along / np.linalg.norm(along), about / np.linalg.norm(about)
        )
    return X


def _square(v: np.ndarray) -> np.ndarray:
    return v.reshape(4, 4)


_TRANSFORMS = {
    "matrix": (16, _square),
    "bind_shape_matrix": (16, _square),
    "translate": (3, _translate),
    "rotate": (4, _rotate),
    "scale": (3, _scale),
    "lookat": (9, _look_at),
    "skew": (7, _skew),
}


def _too_many(document: Document, element: Element) -> None:
    raise InvalidInput(
        finding(
            "asset/resource-limit",
            "the node hierarchy expands without reasonable bound",
            where=document.place(element),
            bound=MAX_NODES,
            unit="nodes",
        )
    )


def _cycle(document: Document, instance: Element, name: str) -> None:
    raise InvalidInput(
        finding("asset/cyclic-reference", f"node '{name}' contains itself", where=document.place(instance), value=name)
    )
