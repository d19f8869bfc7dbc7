"""Build the robots, objects and fixtures of an episode from a MuJoCo model and recorded states.

A tree under the world with a hinge or slide is a robot (a door or a drawer too), its base fixed or on a free joint; a
body with a free joint alone is an object; all else is a fixture. MuJoCo collides the convex hull of a mesh: one shape.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geom.pose import pose
from replay.recording.episode import Fixture, FreeBody, Link, Robot
from replay.recording.mjcf.read import MjBody, MjGeom, MjModel
from replay.recording.recorded_numbers import RecordedStates, invalid_recording
from replay.recording.shapes import ellipsoid, hull, plane
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding
from schemas.physics import CollisionShape

MeshPoints = Callable[[MjBody, MjGeom], FloatArray]  # Vertices (n, 3) in the frame of the body.
Parts = tuple[tuple[Robot, ...], tuple[FreeBody, ...], tuple[Fixture, ...]]


def episode_parts(model: MjModel, recorded: RecordedStates, mesh_points: MeshPoints) -> Parts:
    """Robots, objects and fixtures. Raises InvalidInput where a joint has no recorded state or a geom no shape."""
    robots, objects, fixtures = [], [], []
    for tree in trees(model):
        joints = [j for b in tree for j in model.bodies[b].joints]
        if any(j.kind != "free" for j in joints):
            robots.append(_robot(model, tree, recorded, mesh_points))
        elif joints:
            objects.append(_object(model, tree, recorded, mesh_points))
        else:
            fixtures += [f for b in tree if (f := _fixture(model, b, mesh_points)) is not None]
    return tuple(robots), tuple(objects), tuple(fixtures)


def trees(model: MjModel) -> list[list[int]]:
    """Numbers of the bodies of each tree under the world, in the order of the model; the world is a tree of its own."""
    root = [0]
    for number, body in enumerate(model.bodies[1:], 1):
        root.append(number if body.parent == 0 else root[body.parent])
    return [[n for n, r in enumerate(root) if r == tree] for tree in dict.fromkeys(root)]


def _robot(model: MjModel, tree: list[int], recorded: RecordedStates, mesh_points: MeshPoints) -> Robot:
    root = model.bodies[tree[0]]
    for number in tree[1:]:
        if any(j.kind == "free" for j in model.bodies[number].joints):
            raise invalid_recording("replay/unsupported-model", f"free joint below '{root.name}'", model.file)
    links: list[Link] = []
    coordinates: list[str] = []
    last: dict[int, int] = {}  # The link whose frame is that of a body.
    moving: set[int] = set()
    for number in tree:
        body = model.bodies[number]
        X = np.eye(4) if number == tree[0] else body.X_PB
        parent = -1 if number == tree[0] else last[body.parent]
        if body.joints or body.parent in moving:
            moving.add(number)
        hinges = [j for j in body.joints if j.kind != "free"]
        for index, joint in enumerate(hinges):
            kind = "revolute" if joint.kind == "hinge" else "prismatic"
            at_anchor = joint.kind == "hinge" and bool(np.abs(joint.anchor_B).max() > 0.0)
            X = X @ pose(None, joint.anchor_B) if at_anchor else X
            is_body = index == len(hinges) - 1 and not at_anchor
            name = body.name if is_body else f"{body.name}/{joint.name}"
            coordinates.append(joint.name)
            links.append(Link(name, parent, kind, joint.axis_B, X, len(coordinates) - 1, 1.0, -joint.reference))
            parent, X = len(links) - 1, pose(None, -joint.anchor_B) if at_anchor else np.eye(4)
        shapes = tuple(s for _, s in body_shapes(model, number, mesh_points, moves=number in moving))
        if hinges and links[-1].name == body.name:
            links[-1] = _with_shapes(links[-1], shapes)
        else:
            links.append(Link(body.name, parent, "fixed", np.array([0.0, 0.0, 1.0]), X, shapes=shapes))
        last[number] = len(links) - 1
    n = len(recorded.t_s)
    base = np.tile(root.X_PB, (n, 1, 1))
    if any(j.kind == "free" for j in root.joints):
        base = _pose_of(recorded, root.name, model.file)
    q = _columns(recorded, coordinates, model.file)
    rates = all(name in recorded.qd for name in coordinates)
    qd = np.stack([recorded.qd[name] for name in coordinates], axis=1) if rates else None
    return Robot(root.name, tuple(links), tuple(coordinates), base, q, qd)


def _with_shapes(link: Link, shapes: tuple[CollisionShape, ...]) -> Link:
    return Link(link.name, link.parent, link.kind, link.axis_L, link.X_PL, link.coordinate, 1.0, link.offset, shapes)


def _columns(recorded: RecordedStates, coordinates: list[str], file: str) -> FloatArray:
    for name in coordinates:
        if name not in recorded.q:
            raise invalid_recording("replay/missing-column", f"joint '{name}' of the model was not recorded", file)
    return np.stack([recorded.q[name] for name in coordinates], axis=1)


def _pose_of(recorded: RecordedStates, name: str, file: str) -> FloatArray:
    if name not in recorded.X_WB:
        raise invalid_recording("replay/missing-column", f"free body '{name}' of the model was not recorded", file)
    return recorded.X_WB[name]


def _object(model: MjModel, tree: list[int], recorded: RecordedStates, mesh_points: MeshPoints) -> FreeBody:
    root = model.bodies[tree[0]]
    X_RB = {tree[0]: np.eye(4)}
    for number in tree[1:]:
        X_RB[number] = X_RB[model.bodies[number].parent] @ model.bodies[number].X_PB
    body_parts = [(number, s) for number in tree for _, s in body_shapes(model, number, mesh_points, moves=False)]
    if not body_parts:  # Only pictures: they are what there is.
        body_parts = [(number, s) for number in tree for _, s in body_shapes(model, number, mesh_points, moves=True)]
    return FreeBody(
        root.name,
        _pose_of(recorded, root.name, model.file),
        tuple(transformed(shape, X_RB[n]) for n, shape in body_parts),
    )


def _fixture(model: MjModel, number: int, mesh_points: MeshPoints) -> Fixture | None:
    """A body that never moves; None without a shape that collides."""
    shapes = body_shapes(model, number, mesh_points, moves=False)
    X_WB, at = np.eye(4), number
    while at > 0:
        X_WB, at = model.bodies[at].X_PB @ X_WB, model.bodies[at].parent
    names = tuple(name for name, _ in shapes)
    return Fixture(model.bodies[number].name, X_WB, tuple(s for _, s in shapes), names) if shapes else None


def body_shapes(
    model: MjModel, number: int, mesh_points: MeshPoints, *, moves: bool
) -> list[tuple[str, CollisionShape]]:
    """Shapes of what collides, with their names; of all geoms where nothing collides and the body `moves`."""
    body = model.bodies[number]
    pictures = moves and not any(g.collides for g in body.geoms)
    unnamed = sum(not g.name for g in body.geoms)
    named_shapes = []
    for index, geom in enumerate(body.geoms):
        if (geom.collides or pictures) and geom.kind != "none":
            name = geom.name or (body.name if unnamed == 1 else f"{body.name}_{index}")
            try:
                named_shapes.append((name, _shape(model, body, geom, mesh_points)))
            except InvalidInput as refused:
                if geom.collides or refused.diagnostic.code != "replay/missing-mesh":
                    raise
    return named_shapes


def uncovered_links(model: MjModel, robots: tuple[Robot, ...]) -> tuple[Diagnostic, ...]:
    """A warning for each body that moves and has geoms, but none with a shape at hand."""
    drawn = {body.name for body in model.bodies if body.geoms}
    bare = [link.name for robot in robots for link in robot.links if link.name in drawn and not link.shapes]
    moving = {link.name for robot in robots for link in robot.links if _moves(robot, link)}
    return tuple(
        finding(
            "replay/uncovered-link", f"link '{name}' moves and has no shape at hand", where=Location(file=model.file)
        )
        for name in bare
        if name in moving
    )


def _moves(robot: Robot, link: Link) -> bool:
    while link.kind == "fixed" and link.parent >= 0:
        link = robot.links[link.parent]
    return link.kind != "fixed"


def _shape(model: MjModel, body: MjBody, geom: MjGeom, mesh_points: MeshPoints) -> CollisionShape:
    """One geom in the frame of its body; MuJoCo's half lengths doubled."""
    needed = {"plane": 2, "sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}.get(geom.kind, 0)
    size = geom.size_m
    if len(size) < needed or (geom.kind != "plane" and min(size[:needed], default=1.0) <= 0.0):
        raise invalid_recording(
            "replay/invalid-value", f"geom '{geom.name}' of body '{body.name}' has size {size}", model.file
        )
    if geom.kind == "mesh":
        return hull(mesh_points(body, geom), geom.name or body.name, model.file)
    if geom.kind == "plane":
        return plane(size, geom.X_BG)
    if geom.kind == "ellipsoid":
        return ellipsoid(size, geom.X_BG)
    if geom.kind == "sphere":
        return CollisionShape("sphere", (size[0],), geom.X_BG)
    if geom.kind == "box":
        return CollisionShape("box", tuple(2.0 * s for s in size[:3]), geom.X_BG)
    return CollisionShape(geom.kind, (size[0], 2.0 * size[1]), geom.X_BG)  # pyright: ignore[reportArgumentType]


def transformed(shape: CollisionShape, X: FloatArray) -> CollisionShape:
    """A shape given in one frame, in the frame where that frame is at X (4, 4)."""
    if shape.points is not None:
        points = shape.points @ X[:3, :3].T + X[:3, 3]
        return CollisionShape(shape.kind, shape.size_m, shape.X_AS, points, shape.triangles)
    return CollisionShape(shape.kind, shape.size_m, X @ shape.X_AS)
