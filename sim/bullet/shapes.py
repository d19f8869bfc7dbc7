"""Collision shapes in PyBullet: one compound of primitives and convex hulls (m, body frame), without margins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from geom.convex.support_function import surface
from schemas.arrays import FloatArray, IntArray
from schemas.physics import CollisionShape

_SLOTS = 16  # of createCollisionShapeArray
PARKED_M = 1000.0  # Height at which a body waits out of reach of all others.


@dataclass(frozen=True)
class _Slot:
    """One entry of createCollisionShapeArray; fields that the kind does not use keep their defaults."""

    kind: int
    position_m: Sequence[float] = (0.0, 0.0, 0.0)
    quat_xyzw: Sequence[float] = (0.0, 0.0, 0.0, 1.0)
    half_extents_m: Sequence[float] = (1.0, 1.0, 1.0)
    radius_m: float = 1.0
    length_m: float = 1.0
    file: str = ""


def compound(shapes: Sequence[CollisionShape], scale: float, folder: Path, client: int) -> int:
    """The engine's handle of the compound of all shapes; it reads `folder` again when a body is made of it.

    Primitives for which no slot is left become hulls.
    """
    primitives = [shape for shape in shapes if shape.kind != "hull"]
    hulls = [shape for shape in shapes if shape.kind == "hull"]
    kept = _SLOTS - 1 if hulls or len(primitives) > _SLOTS else _SLOTS
    hulls, primitives = hulls + primitives[kept:], primitives[:kept]
    slots = [_primitive(shape, scale) for shape in primitives]
    if hulls:
        file = folder / "hulls.obj"
        file.write_text(_obj([surface(hull) for hull in hulls], scale), encoding="ascii")
        slots.append(_Slot(pybullet.GEOM_MESH, file=str(file)))
    return pybullet.createCollisionShapeArray(
        shapeTypes=[slot.kind for slot in slots],
        halfExtents=[slot.half_extents_m for slot in slots],
        radii=[slot.radius_m for slot in slots],
        lengths=[slot.length_m for slot in slots],
        fileNames=[slot.file for slot in slots],
        collisionFramePositions=[slot.position_m for slot in slots],
        collisionFrameOrientations=[slot.quat_xyzw for slot in slots],
        physicsClientId=client,
    )


def clear_margins(collision: int, count: int, client: int) -> None:
    """Set the margins of a compound to 0; RuntimeError unless it has `count` members."""
    passing = pybullet.createMultiBody(0, collision, basePosition=[0.0, 0.0, PARKED_M], physicsClientId=client)
    pybullet.changeDynamics(passing, -1, collisionMargin=0.0, physicsClientId=client)
    held = len(pybullet.getCollisionShapeData(passing, -1, physicsClientId=client))
    pybullet.removeBody(passing, physicsClientId=client)
    if held != count:
        raise RuntimeError(f"the engine holds {held} collision shapes, not {count}")


def _primitive(shape: CollisionShape, scale: float) -> _Slot:
    """The engine's description of a box, sphere, capsule or cylinder."""
    sizes = [float(s) * scale for s in shape.size_m]
    position_m = (shape.X_AS[:3, 3] * scale).tolist()
    quat_xyzw = Rotation.from_matrix(shape.X_AS[:3, :3]).as_quat().tolist()
    if shape.kind == "box":
        return _Slot(pybullet.GEOM_BOX, position_m, quat_xyzw, half_extents_m=[s / 2.0 for s in sizes])
    if shape.kind == "sphere":
        return _Slot(pybullet.GEOM_SPHERE, position_m, quat_xyzw, radius_m=sizes[0])
    kind = pybullet.GEOM_CAPSULE if shape.kind == "capsule" else pybullet.GEOM_CYLINDER
    return _Slot(kind, position_m, quat_xyzw, radius_m=sizes[0], length_m=sizes[1])


def _obj(surfaces: Sequence[tuple[FloatArray, IntArray]], scale: float) -> str:
    """Wavefront OBJ text with one `o` group per convex surface (points (n, 3), triangles (m, 3))."""
    lines, first = [], 1
    for index, (points, triangles) in enumerate(surfaces):
        lines.append(f"o hull_{index}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in (np.asarray(points, dtype=np.float64) * scale).tolist()]
        lines += [f"f {a} {b} {c}" for a, b, c in (np.asarray(triangles) + first).tolist()]
        first += len(points)
    return "\n".join([*lines, ""])
