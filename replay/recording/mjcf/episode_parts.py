"""Build the robots, objects and fixtures of an episode from a MuJoCo model and recorded states.

A tree under the world with a hinge or slide is a robot (a door or a drawer too), its base fixed or on a free joint; a
body with a free joint alone is an object; all else is a fixture. MuJoCo collides the convex hull of a mesh: one shape.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from geom.pose import pose
from replay.recording.episode import Fixture, FreeBody, Link, Robot
from replay.recording.mjcf.bodies import RecordedBodies, is_free
from replay.recording.recorded_numbers import RecordedStates, invalid_recording
from replay.recording.robot_files import as_recording_finding
from replay.recording.shapes import ellipsoid, hull, plane
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding
from schemas.physics import CollisionShape
from schemas.robot_description import DescribedLink, DescribedShape

# Vertices (n, 3) in the frame of a body of one of its geoms with its number in the model.
MeshPoints = Callable[[DescribedLink, DescribedShape, int], FloatArray]
Parts = tuple[tuple[Robot, ...], tuple[FreeBody, ...], tuple[Fixture, ...]]


def episode_parts(model: RecordedBodies, recorded: RecordedStates, mesh_points: MeshPoints) -> Parts:
    """Robots, objects and fixtures. Raises InvalidInput where a joint has no recorded state or a geom no shape."""
    robots, objects, fixtures = [], [], []
    for tree in trees(model):
        joints = [j for b in tree for j in model.joints[b]]
        if any(not is_free(j) for j in joints):
            robots.append(_robot(model, tree, recorded, mesh_points))
        elif joints:
            objects.append(_object(model, tree, recorded, mesh_points))
        else:
            fixtures += [f for b in tree if (f := _fixture(model, b, mesh_points)) is not None]
    return tuple(robots), tuple(objects), tuple(fixtures)


def trees(model: RecordedBodies) -> list[list[int]]:
    """Numbers of the bodies of each tree under the world, in the order of the model; the world is a tree of its own."""
    root = [0]
    for number, parent in enumerate(model.parent[1:], 1):
        root.append(number if parent == 0 else root[parent])
    return [[n for n, r in enumerate(root) if r == tree] for tree in dict.fromkeys(root)]


def _robot(model: RecordedBodies, tree: list[int], recorded: RecordedStates, mesh_points: MeshPoints) -> Robot:
    root = model.links[tree[0]]
    for number in tree[1:]:
        if any(is_free(j) for j in model.joints[number]):
            raise invalid_recording("replay/unsupported-model", f"free joint below '{root.name}'", model.file)
    links: list[Link] = []
    coordinates: list[str] = []
    last: dict[int, int] = {}  # The link whose frame is that of a body.
    moving: set[int] = set()
    for number in tree:
        body = model.links[number]
        X = np.eye(4) if number == tree[0] else model.X_PB[number]
        parent = -1 if number == tree[0] else last[model.parent[number]]
        if model.joints[number] or model.parent[number] in moving:
            moving.add(number)
        hinges = [j for j in model.joints[number] if not is_free(j)]
        for index, joint in enumerate(hinges):
            kind = "prismatic" if joint.kind == "prismatic" else "revolute"
            at_anchor = kind == "revolute" and bool(np.abs(joint.anchor_C).max() > 0.0)
            X = X @ pose(None, joint.anchor_C) if at_anchor else X
            is_body = index == len(hinges) - 1 and not at_anchor
            name = body.name if is_body else f"{body.name}/{joint.name}"
            coordinates.append(joint.name)
            links.append(Link(name, parent, kind, joint.axis_C, X, len(coordinates) - 1, 1.0, -joint.reference))
            parent, X = len(links) - 1, pose(None, -joint.anchor_C) if at_anchor else np.eye(4)
        shapes = tuple(s for _, s in body_shapes(model, number, mesh_points, moves=number in moving))
        if hinges and links[-1].name == body.name:
            links[-1] = _with_shapes(links[-1], shapes)
        else:
            links.append(Link(body.name, parent, "fixed", np.array([0.0, 0.0, 1.0]), X, shapes=shapes))
        last[number] = len(links) - 1
    n = len(recorded.t_s)
    base = np.tile(model.X_PB[tree[0]], (n, 1, 1))
    if any(is_free(j) for j in model.joints[tree[0]]):
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


def _object(model: RecordedBodies, tree: list[int], recorded: RecordedStates, mesh_points: MeshPoints) -> FreeBody:
    root = model.links[tree[0]]
    X_RB = {tree[0]: np.eye(4)}
    for number in tree[1:]:
        X_RB[number] = X_RB[model.parent[number]] @ model.X_PB[number]
    body_parts = [(number, s) for number in tree for _, s in body_shapes(model, number, mesh_points, moves=False)]
    if not body_parts:  # Only pictures: they are what there is.
        body_parts = [(number, s) for number in tree for _, s in body_shapes(model, number, mesh_points, moves=True)]
    return FreeBody(
        root.name,
        _pose_of(recorded, root.name, model.file),
        tuple(transformed(shape, X_RB[n]) for n, shape in body_parts),
    )


def _fixture(model: RecordedBodies, number: int, mesh_points: MeshPoints) -> Fixture | None:
    """A body that never moves; None without a shape that collides."""
    shapes = body_shapes(model, number, mesh_points, moves=False)
    X_WB, at = np.eye(4), number
    while at > 0:
        X_WB, at = model.X_PB[at] @ X_WB, model.parent[at]
    names = tuple(name for name, _ in shapes)
    return Fixture(model.links[number].name, X_WB, tuple(s for _, s in shapes), names) if shapes else None


def body_shapes(
    model: RecordedBodies, number: int, mesh_points: MeshPoints, *, moves: bool
) -> list[tuple[str, CollisionShape]]:
    """Shapes of what collides, with their names; of all geoms where nothing collides and the body `moves`."""
    body = model.links[number]
    pictures = moves and not any(g.collides for g in body.shapes)
    unnamed = sum(not g.name for g in body.shapes)
    named_shapes = []
    for index, geom in enumerate(body.shapes):
        unread = geom.problem is not None and geom.problem.code == "robot/unsupported-shape"
        if geom.collides or (pictures and not unread):
            name = geom.name or (body.name if unnamed == 1 else f"{body.name}_{index}")
            try:
                points = partial(mesh_points, body, geom, model.first_geom[number] + index)
                named_shapes.append((name, _shape(geom, geom.name or body.name, points, model.file)))
            except InvalidInput as refused:
                if geom.collides or refused.diagnostic.code != "replay/missing-mesh":
                    raise
    return named_shapes


def uncovered_links(model: RecordedBodies, robots: tuple[Robot, ...]) -> tuple[Diagnostic, ...]:
    """A warning for each body that moves and has geoms, but none with a shape at hand."""
    drawn = {link.name for link in model.links if link.shapes}
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


def _shape(geom: DescribedShape, name: str, mesh_points: Callable[[], FloatArray], file: str) -> CollisionShape:
    """One geom in the frame of its body. Raises InvalidInput for a geom that cannot be used."""
    if geom.problem is not None:
        raise InvalidInput(as_recording_finding(geom.problem))
    if geom.kind == "mesh":
        return hull(mesh_points(), name, file)
    if geom.kind == "plane":
        return plane(geom.size_m, geom.X_LS)
    if geom.kind == "ellipsoid":
        return ellipsoid(geom.size_m, geom.X_LS)
    return CollisionShape(geom.kind, geom.size_m, geom.X_LS)  # pyright: ignore[reportArgumentType]


def transformed(shape: CollisionShape, X: FloatArray) -> CollisionShape:
    """A shape given in one frame, in the frame where that frame is at X (4, 4)."""
    if shape.points is not None:
        points = shape.points @ X[:3, :3].T + X[:3, 3]
        return CollisionShape(shape.kind, shape.size_m, shape.X_AS, points, shape.triangles)
    return CollisionShape(shape.kind, shape.size_m, X @ shape.X_AS)
