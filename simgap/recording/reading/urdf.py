"""The bodies and joints of a subject's URDF for simulation, SI: fixed joints merged, meshes as convex hulls.

Nothing outside the folder of the measurement is opened.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import trimesh

from formats import link_mass, read_urdf
from formats.mesh_points import in_shape_frame
from formats.tree import joints_below
from geom.convex.hull import hull_shape
from geom.mass.inertia import combine, moved
from schemas.arrays import FloatArray
from schemas.diagnostics import InvalidInput
from schemas.physics import CollisionShape, MassProperties
from schemas.robot_description import DescribedJoint, DescribedLink, DescribedShape, RobotDescription

MOVABLE = ("revolute", "continuous", "prismatic")
_MESHES = (".obj", ".stl", ".ply")


@dataclass(frozen=True)
class SubjectLink:
    """A rigid body in its own frame: mass (None: a frame without matter) and convex shapes.

    friction, restitution   from the file (`<contact>` of PyBullet), of the body alone.
    """

    name: str
    mass: MassProperties | None
    shapes: tuple[CollisionShape, ...]
    friction: float | None = None
    restitution: float | None = None


@dataclass(frozen=True)
class SubjectJoint:
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
class SubjectModel:
    """Links with the root first, and joints so that a parent always comes before what hangs on it."""

    links: tuple[SubjectLink, ...]
    joints: tuple[SubjectJoint, ...]


def read_description(path: Path, root: Path) -> RobotDescription:
    """The URDF at `path`; `root` is the folder that meshes must not leave. Raises ValueError with the reason."""
    try:
        return read_urdf(path, root)
    except InvalidInput as refused:
        found = refused.diagnostic
        raise ValueError(f"{found.headline} ({found.code}, {found.where})") from refused


def movable_joints(description: RobotDescription) -> list[DescribedJoint]:
    """The joints that move by themselves, parents first, else in the order of the file."""
    depth = _depths(description)
    joints = [j for j in description.joints if j.kind in MOVABLE and j.mimic is None]
    return sorted(joints, key=lambda joint: depth[joint.child])


def subject_model(description: RobotDescription, root: Path) -> SubjectModel:
    """The bodies that move as one, and the joints between them; mesh files are below `root`.

    Raises ValueError for joints of other kinds and shapes without volume.
    """
    for joint in description.joints:
        if joint.mimic is not None or joint.kind not in (*MOVABLE, "fixed"):
            raise ValueError(f"joint '{joint.name}' is {joint.kind} or mimics another: not supported")
    links = {link.name: _link(link, root) for link in description.links}
    holder = {description.root: (description.root, np.eye(4))}  # link -> the body that carries it, and its pose there
    order, joints = [description.root], []
    number = {description.root: 0}
    for joint in _merging_order(description):
        at, X = holder[joint.parent]
        X = X @ joint.X_PC
        if joint.kind == "fixed":
            holder[joint.child] = (at, X)
            links[at] = _merged(links[at], links[joint.child], X)
        else:
            holder[joint.child] = (joint.child, np.eye(4))
            number[joint.child] = len(order)
            order.append(joint.child)
            joints.append(_joint(joint, number[at], number[joint.child], X))
    return SubjectModel(tuple(links[name] for name in order), tuple(joints))


def _depths(description: RobotDescription) -> dict[str, int]:
    """Number of joints between each link and the root."""
    below, depth, waiting = joints_below(description.joints), {description.root: 0}, [description.root]
    for name in waiting:  # Grows while it is walked.
        for joint in below.get(name, []):
            depth[joint.child] = depth[name] + 1
            waiting.append(joint.child)
    return depth


def _merging_order(description: RobotDescription) -> list[DescribedJoint]:
    """Every joint after those above it: fixed ones as early as they can be, in the order of the file."""
    depth, below = _depths(description), joints_below(description.joints)
    rank = {joint.name: k for k, joint in enumerate(description.joints)}
    by_name = {joint.name: joint for joint in description.joints}
    ready: list[tuple[bool, int, int, str]] = []
    order: list[DescribedJoint] = []

    def reach(link: str) -> None:
        for joint in below.get(link, []):
            moves = joint.kind != "fixed"
            heapq.heappush(ready, (moves, depth[joint.child] if moves else 0, rank[joint.name], joint.name))

    reach(description.root)
    while ready:
        joint = by_name[heapq.heappop(ready)[-1]]
        order.append(joint)
        reach(joint.child)
    return order


def _link(link: DescribedLink, root: Path) -> SubjectLink:
    return SubjectLink(
        name=link.name,
        mass=link_mass(link),
        shapes=tuple(_shape(shape, root) for shape in link.shapes if shape.collides),
        friction=link.contact.get("lateral_friction"),
        restitution=link.contact.get("restitution"),
    )


def _shape(shape: DescribedShape, root: Path) -> CollisionShape:
    """The shape in the frame of its link, a mesh as its convex hull. Raises ValueError where it cannot be used."""
    if shape.problem is not None:
        raise ValueError(f"{shape.problem.headline} ({shape.problem.code}, {shape.problem.where})")
    if shape.mesh is None:
        return CollisionShape(shape.kind, shape.size_m, shape.X_LS)  # pyright: ignore[reportArgumentType]
    file = root / shape.mesh.path
    if not shape.mesh.path or file.suffix.lower() not in _MESHES:
        raise ValueError(f"mesh '{shape.mesh.uri}' is not an OBJ, STL or PLY file of the measurement's folder")
    mesh = trimesh.load_mesh(file, process=False)
    points = in_shape_frame(shape.mesh, np.asarray(mesh.vertices, dtype=float))
    hull = hull_shape(points @ shape.X_LS[:3, :3].T + shape.X_LS[:3, 3])
    if hull is None:
        raise ValueError(f"mesh '{shape.mesh.uri}' has no volume")
    return hull


def _joint(joint: DescribedJoint, parent: int, child: int, X_PJ: FloatArray) -> SubjectJoint:
    limits = joint.limits
    return SubjectJoint(
        name=joint.name,
        parent=parent,
        child=child,
        prismatic=joint.kind == "prismatic",
        axis_J=joint.axis_C,
        X_PJ=X_PJ,
        damping=joint.damping,
        friction=joint.friction,
        limits=(limits.lower, limits.upper) if limits is not None and limits.lower < limits.upper else None,
    )


def _merged(body: SubjectLink, part: SubjectLink, X_BP: FloatArray) -> SubjectLink:
    """`body` with `part` fixed to it in pose X_BP."""
    masses = [m for m in (body.mass, part.mass and moved(part.mass, X_BP)) if m is not None]
    shapes = (*body.shapes, *(_moved(s, X_BP) for s in part.shapes))
    return replace(body, mass=combine(masses) if masses else None, shapes=shapes)


def _moved(shape: CollisionShape, X: FloatArray) -> CollisionShape:
    if shape.points is not None:
        return replace(shape, points=shape.points @ X[:3, :3].T + X[:3, 3])
    return replace(shape, X_AS=X @ shape.X_AS)
