"""Reads a URDF as links and joints for simulation, SI: fixed joints merged, meshes as convex hulls.

Format: wiki.ros.org/urdf/XML. Nothing outside the folder of the measurement is opened.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from lxml import etree
from scipy.spatial.transform import Rotation

from geom.convex.hull import hull_shape
from geom.mass.inertia import combine, moved
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape, MassProperties

MOVABLE = ("revolute", "continuous", "prismatic")
_MAX_URDF_BYTES = 20_000_000
_MESHES = (".obj", ".stl", ".ply")


@dataclass(frozen=True)
class UrdfLink:
    """A rigid body in its own frame: mass (None: a frame without matter) and convex shapes.

    friction, restitution   from the file (`<contact>` of PyBullet), of the body alone.
    """

    name: str
    mass: MassProperties | None
    shapes: tuple[CollisionShape, ...]
    friction: float | None = None
    restitution: float | None = None


@dataclass(frozen=True)
class UrdfJoint:
    """A movable joint: `parent` and `child` index the links; X_PJ (4, 4) poses the child's frame at q = 0."""

    name: str
    parent: int
    child: int
    prismatic: bool
    axis_J: FloatArray
    X_PJ: FloatArray
    damping: float
    friction: float
    limits: tuple[float, float] | None


@dataclass(frozen=True)
class UrdfModel:
    """Links with the root first, and joints so that a parent always comes before what hangs on it."""

    links: tuple[UrdfLink, ...]
    joints: tuple[UrdfJoint, ...]


def parse_urdf(path: Path) -> Any:
    """The `<robot>` element. Raises ValueError with the reason."""
    try:
        if path.stat().st_size > _MAX_URDF_BYTES:
            raise ValueError(f"more than {_MAX_URDF_BYTES} bytes")
        robot = etree.fromstring(path.read_bytes(), etree.XMLParser(resolve_entities=False, no_network=True))
    except etree.XMLSyntaxError as error:
        raise ValueError(str(error)) from None
    except OSError as error:
        raise ValueError(error.strerror) from None
    if robot.tag != "robot":
        raise ValueError(f"no URDF: <{robot.tag}>")
    return robot


def movable_joints(robot: Any) -> list[Any]:
    """The `<joint>` elements that move by themselves, parents first, else in the order of the file."""
    joints = [j for j in robot.findall("joint") if j.get("type") in MOVABLE and j.find("mimic") is None]
    above = {_child(j): _parent(j) for j in robot.findall("joint")}

    def depth(link: str) -> int:
        steps = 0
        while link in above and steps <= len(above):
            link, steps = above[link], steps + 1
        return steps

    return sorted(joints, key=lambda j: depth(_child(j)))


def read_urdf(path: Path, root: Path) -> UrdfModel:
    """The model in the file; `root` is the folder that meshes must not leave.

    Raises ValueError for joints of other kinds, loops, several roots, links without mass or shapes without volume.
    """
    robot = parse_urdf(path)
    for joint in robot.findall("joint"):
        if joint.find("mimic") is not None or joint.get("type") not in (*MOVABLE, "fixed"):
            raise ValueError(f"joint '{joint.get('name')}' is {joint.get('type')} or mimics another: not supported")
    links = {link.get("name", ""): _link(link, path.parent, root.resolve()) for link in robot.findall("link")}
    children = [_child(j) for j in robot.findall("joint")]
    roots = [name for name in links if name not in children]
    if len(roots) != 1 or len(set(children)) != len(children) or not set(children) <= links.keys():
        raise ValueError(f"the links are no tree: {len(roots)} roots, {len(children)} joints, {len(links)} links")
    holder = {roots[0]: (roots[0], np.eye(4))}  # link -> the body that carries it, and its pose there
    order, joints = [roots[0]], []
    fixed = [j for j in robot.findall("joint") if j.get("type") == "fixed"]
    todo = [*movable_joints(robot)]
    while todo or fixed:
        placed = next((j for j in (*fixed, *todo) if _parent(j) in holder), None)
        if placed is None:
            raise ValueError("the links form a loop")
        at, X = holder[_parent(placed)]
        X = X @ _origin(placed)
        if placed.get("type") == "fixed":
            fixed.remove(placed)
            holder[_child(placed)] = (at, X)
            links[at] = _merged(links[at], links[_child(placed)], X)
        else:
            todo.remove(placed)
            holder[_child(placed)] = (_child(placed), np.eye(4))
            order.append(_child(placed))
            joints.append(_joint(placed, order.index(at), len(order) - 1, X))
    return UrdfModel(tuple(links[name] for name in order), tuple(joints))


def _parent(joint: Any) -> str:
    return joint.find("parent").get("link", "") if joint.find("parent") is not None else ""


def _child(joint: Any) -> str:
    return joint.find("child").get("link", "") if joint.find("child") is not None else ""


def _link(link: Any, folder: Path, root: Path) -> UrdfLink:
    shapes = [s for c in link.findall("collision") for s in _shapes(c, folder, root)]
    contact = link.find("contact")
    return UrdfLink(
        name=link.get("name", ""),
        mass=_mass(link.find("inertial")),
        shapes=tuple(shapes),
        friction=_value(contact, "lateral_friction"),
        restitution=_value(contact, "restitution"),
    )


def _mass(inertial: Any) -> MassProperties | None:
    if inertial is None or inertial.find("mass") is None or float(inertial.find("mass").get("value", 0.0)) <= 0.0:
        return None
    given, tensor = inertial.find("inertia"), np.zeros((3, 3))
    if given is not None:
        xx, yy, zz, xy, xz, yz = (float(given.get(f"i{n}", 0.0)) for n in ("xx", "yy", "zz", "xy", "xz", "yz"))
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return moved(MassProperties(float(inertial.find("mass").get("value")), np.zeros(3), tensor), _origin(inertial))


def _value(parent: Any, name: str) -> float | None:
    element = parent.find(name) if parent is not None else None
    return float(element.get("value")) if element is not None else None


def _shapes(collision: Any, folder: Path, root: Path) -> list[CollisionShape]:
    X, geometry = _origin(collision), collision.find("geometry")
    kind = geometry[0] if geometry is not None and len(geometry) else None
    if kind is None:
        return []
    if kind.tag == "box":
        return [CollisionShape("box", tuple(_numbers(kind, "size", 3)), X)]
    if kind.tag == "sphere":
        return [CollisionShape("sphere", (float(kind.get("radius")),), X)]
    if kind.tag in ("cylinder", "capsule"):
        return [CollisionShape(kind.tag, (float(kind.get("radius")), float(kind.get("length"))), X)]
    if kind.tag != "mesh":
        raise ValueError(f"<{kind.tag}> is no shape")
    name = kind.get("filename", "")
    file = (folder / name).resolve()
    if not file.is_relative_to(root) or file.suffix.lower() not in _MESHES:
        raise ValueError(f"mesh '{name}' is not an OBJ, STL or PLY file of the measurement's folder")
    scale = np.array(_numbers(kind, "scale", 3, 1.0))
    mesh = trimesh.load_mesh(file, process=False)
    points = np.asarray(mesh.vertices, dtype=float) * scale
    shape = hull_shape(points @ X[:3, :3].T + X[:3, 3])
    if shape is None:
        raise ValueError(f"mesh '{name}' has no volume")
    return [shape]


def _joint(joint: Any, parent: int, child: int, X_PJ: FloatArray) -> UrdfJoint:
    axis = joint.find("axis")
    axis_J = np.array(_numbers(axis, "xyz", 3) if axis is not None else [1.0, 0.0, 0.0])
    if not np.linalg.norm(axis_J) > 0.0:
        raise ValueError(f"joint '{joint.get('name')}' has no axis")
    dynamics, limit = joint.find("dynamics"), joint.find("limit")
    limits = None
    if joint.get("type") != "continuous" and limit is not None:
        limits = (float(limit.get("lower", 0.0)), float(limit.get("upper", 0.0)))
    return UrdfJoint(
        name=joint.get("name", ""),
        parent=parent,
        child=child,
        prismatic=joint.get("type") == "prismatic",
        axis_J=axis_J / np.linalg.norm(axis_J),
        X_PJ=X_PJ,
        damping=float(dynamics.get("damping", 0.0)) if dynamics is not None else 0.0,
        friction=float(dynamics.get("friction", 0.0)) if dynamics is not None else 0.0,
        limits=limits if limits and limits[0] < limits[1] else None,
    )


def _merged(body: UrdfLink, part: UrdfLink, X_BP: FloatArray) -> UrdfLink:
    """`body` with `part` fixed to it in pose X_BP."""
    masses = [m for m in (body.mass, part.mass and moved(part.mass, X_BP)) if m is not None]
    shapes = (*body.shapes, *(_moved(s, X_BP) for s in part.shapes))
    return replace(body, mass=combine(masses) if masses else None, shapes=shapes)


def _moved(shape: CollisionShape, X: FloatArray) -> CollisionShape:
    if shape.points is not None:
        return replace(shape, points=shape.points @ X[:3, :3].T + X[:3, 3])
    return replace(shape, X_AS=X @ shape.X_AS)


def _origin(element: Any) -> FloatArray:
    """(4, 4) of its `<origin>`; rpy are fixed axes x, y, z."""
    X, origin = np.eye(4), element.find("origin")
    if origin is not None:
        X[:3, 3] = _numbers(origin, "xyz", 3, 0.0)
        X[:3, :3] = Rotation.from_euler("xyz", _numbers(origin, "rpy", 3, 0.0)).as_matrix()
    return X


def _numbers(element: Any, name: str, count: int, default: float | None = None) -> Sequence[float]:
    text = element.get(name)
    if text is None and default is not None:
        return [default] * count
    numbers = [float(word) for word in (text or "").split()]
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise ValueError(f"<{element.tag} {name}=...> needs {count} numbers, found '{text}'")
    return numbers
