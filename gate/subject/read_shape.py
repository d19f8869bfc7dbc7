"""Converts meshes and implicit shapes of a stage into points and triangles in the world, metres."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from pxr import UsdGeom, UsdPhysics

from gate.subject.body import VisibleSurface
from gate.subject.frames import Frames
from gate.subject.values import integers, number, rows, text
from geom.mesh import primitives
from geom.mesh.polygon_triangulation import triangulate_polygons
from geom.pose import apply
from schemas.arrays import FloatArray, IntArray

SHAPES = ("Mesh", "Cube", "Sphere", "Cylinder", "Cylinder_1", "Cone", "Capsule", "Capsule_1", "Plane")
CONVEX_APPROXIMATIONS = ("convexHull", "boundingCube", "boundingSphere")
_COLLIDER_SEGMENTS = 24  # within 1 % of the round shape, at a quarter of the points
_CYCLE = {"X": [2, 0, 1], "Y": [1, 2, 0], "Z": [0, 1, 2]}  # cyclic, so handedness stays


def surface_of(prim: Any, frames: Frames) -> VisibleSurface:
    """The visible surface of a Mesh or implicit shape. Faces wind outwards after orientation and mirroring."""
    matrix = frames.matrix(prim)
    points, triangles = _mesh(prim) if prim.IsA(UsdGeom.Mesh) else _solid(prim)
    # A mirroring transform turns faces over, and so does a left-handed prim; both together do not. Renderers follow
    # the same rule (UsdGeomGprim, "orientation").
    if (np.linalg.det(matrix[:3, :3]) < 0.0) != (text(prim, "orientation") == UsdGeom.Tokens.leftHanded):
        triangles = triangles[:, ::-1]
    return VisibleSurface(prim, apply(matrix, points), triangles)


def collider_points(prim: Any, frames: Frames) -> FloatArray:
    """(n, 3) points on the surface of a collider, in the world; round shapes inscribed with 24 segments."""
    points = rows(prim, "points", 3) if prim.IsA(UsdGeom.Mesh) else _solid(prim, _COLLIDER_SEGMENTS)[0]
    return apply(frames.matrix(prim), points)


def approximation_of(prim: Any) -> str:
    """`physics:approximation` of a mesh collider; "none", the schema's fallback, without the API."""
    if not prim.IsA(UsdGeom.Mesh):
        return ""
    return text(prim, "physics:approximation", "none") if prim.HasAPI(UsdPhysics.MeshCollisionAPI) else "none"


def is_convex(prim: Any, approximation: str) -> bool:
    """True iff engines collide with the hull of the prim's points, or a box or ball about them."""
    return approximation in CONVEX_APPROXIMATIONS if prim.IsA(UsdGeom.Mesh) else prim.GetTypeName() in SHAPES


def topology_fault(points: int, counts: IntArray, indices: IntArray) -> str:
    """What makes a mesh undrawable: a text, "" when nothing does."""
    if len(counts) and counts.min() < 3:
        return f"a face has {int(counts.min())} corners"
    if counts.sum() != len(indices):
        return f"faceVertexCounts ask for {int(counts.sum())} corners, faceVertexIndices has {len(indices)}"
    wrong = (indices < 0) | (indices >= points)
    if wrong.any():
        return f"{int(wrong.sum())} face corners refer to none of the {points} points"
    return ""


def _mesh(prim: Any) -> tuple[FloatArray, IntArray]:
    points = rows(prim, "points", 3)
    counts, indices = integers(prim, "faceVertexCounts"), integers(prim, "faceVertexIndices")
    if len(counts) == 0 or topology_fault(len(points), counts, indices) or not np.all(np.isfinite(points)):
        return points, np.zeros((0, 3), dtype=np.int64)
    return points, indices[triangulate_polygons(points, indices, counts)[0]]


def _solid(prim: Any, segments: int = primitives.SEGMENTS) -> tuple[FloatArray, IntArray]:
    """The tessellated implicit shape in its own frame; nothing for another type or a size that is no length."""
    kind = prim.GetTypeName()
    size = {name: number(prim, name) for name in ("size", "radius", "height", "width", "length")}
    bottom, top = (number(prim, f"radius{end}", size["radius"]) for end in ("Bottom", "Top"))
    match kind:
        case "Cube":
            sizes, make = [size["size"]], partial(primitives.cube, size["size"])
        case "Sphere":
            sizes, make = [size["radius"]], partial(primitives.sphere, size["radius"], segments)
        case "Cylinder" | "Cylinder_1":
            sizes, make = (
                [size["height"], bottom, top],
                partial(primitives.cylinder, size["height"], bottom, top, segments),
            )
        case "Cone":
            lengths = [size["height"], size["radius"]]
            sizes, make = lengths, partial(primitives.cylinder, *lengths, 0.0, segments)
        case "Capsule" | "Capsule_1":
            sizes, make = (
                [bottom, top, size["height"] + bottom],
                partial(primitives.capsule, size["height"], bottom, top, segments),
            )
        case "Plane":
            sizes, make = [size["width"], size["length"]], partial(primitives.plane, size["width"], size["length"])
        case _:
            return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    if not all(np.isfinite(v) and v > 0.0 for v in sizes):
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    shape = make()
    order = _CYCLE.get(text(prim, "axis", "Z"), _CYCLE["Z"])
    return shape.points[:, order], shape.triangles
