"""A recorded episode as a state log and the facts of its scene, for judges of tasks.

Recordings hold no contacts: two bodies touch where their convex shapes come within `CONTACT_GAP_M`. Fingers are links
that the palm of a robot carries on joints of their own.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import shapely
from scipy.spatial.transform import Rotation

from geom.convex.shape_corners import shape_corners
from replay.recording.episode import Episode, Robot, link_names
from replay.recording.kinematics import link_poses
from replay.verification.separation import DistanceShape, centre_and_radius, distance_shape, separation_m
from schemas.anchors import AnchorPolygon, SupportSurface
from schemas.arrays import BoolArray, FloatArray
from schemas.physics import CollisionShape
from schemas.task.scene_facts import ObjectFacts, SceneFacts
from schemas.task.state_log import GripperParts, StateLog

CONTACT_GAP_M = 0.001  # shapes of recordings are hulls, and simulators keep contacts within this
TOP_SPREAD_M = 0.002  # corners within so much of the highest one bound the top of a shape
LEAST_TOP_M2 = 1e-5  # a top smaller than 3 mm by 3 mm carries nothing


@dataclass(frozen=True)
class _Body:
    """A body with its poses X_WB (n, 4, 4) and the shapes that move with it, each with poses of its own link."""

    name: str
    X_WB: FloatArray
    shapes: tuple[tuple[CollisionShape, FloatArray], ...]


def state_log(episode: Episode) -> tuple[StateLog, SceneFacts]:
    """The log of an episode (one row per stamp that is later than the one before), and the facts of its scene."""
    rows = np.concatenate([[True], np.diff(episode.t_s) > 0.0])
    n = len(episode.t_s)
    objects = [_Body(o.name, o.X_WB, tuple((s, o.X_WB) for s in o.shapes)) for o in episode.objects]
    fixtures = [_fixture(f.name, f.X_WB, f.shapes, n) for f in episode.fixtures]
    links: list[_Body] = []
    grippers: list[GripperParts] = []
    joints: dict[str, FloatArray] = {}
    fingers: list[_Body] = []
    for robot in episode.robots:
        poses, names = link_poses(robot, robot.q, robot.X_WR), link_names(episode, robot)
        links += [_Body(name, poses[:, k], ()) for k, name in enumerate(names)]
        joints |= {f"{robot.name}/{name}": robot.q[:, k] for k, name in enumerate(robot.coordinates)}
        for palm, branches in gripper_branches(robot):
            parts = [_group(robot, poses, names, branch) for branch in branches]
            fingers += parts
            grippers.append(GripperParts(names[palm], names[palm], tuple(part.name for part in parts)))
    bodies = [*objects, *fixtures, *links]
    pairs, touching = _contacts(objects, [*fingers, *fixtures], rows)
    log = StateLog(
        t_s=episode.t_s[rows],
        bodies=tuple(body.name for body in bodies),
        position_m=np.stack([body.X_WB[rows, :3, 3] for body in bodies], axis=1),
        quat_wxyz=np.stack([quats_wxyz(body.X_WB[rows, :3, :3]) for body in bodies], axis=1),
        joints=tuple(joints),
        joint_position=np.stack([q[rows] for q in joints.values()], axis=1) if joints else None,
        contact_pairs=pairs,
        touching=touching,
        grippers=tuple(grippers),
    )
    facts = [*(_facts(o.name, o.shapes) for o in episode.objects)]
    facts += [_facts(f.name, f.shapes, f.shape_names) for f in episode.fixtures]
    return log, SceneFacts({each.name: each for each in facts})


def gripper_branches(robot: Robot) -> list[tuple[int, list[list[int]]]]:
    """Palms of a robot and the links of each finger: at least two branches, each on a moving joint of its own, that
    end without a further palm.
    """
    children: dict[int, list[int]] = {}
    for number, link in enumerate(robot.links):
        children.setdefault(link.parent, []).append(number)

    def below(number: int) -> list[int]:
        return [number, *(deep for child in children.get(number, []) for deep in below(child))]

    palms: list[tuple[int, list[list[int]]]] = []
    for number in range(len(robot.links)):
        branches = [below(child) for child in children.get(number, []) if robot.links[child].coordinate >= 0]
        branches = [branch for branch in branches if any(robot.links[k].shapes for k in branch)]
        if len(branches) >= 2:
            palms.append((number, branches))
    return palms


def quats_wxyz(R: FloatArray) -> FloatArray:
    """(n, 4) from rotations (n, 3, 3)."""
    return Rotation.from_matrix(R).as_quat(scalar_first=True)


def _group(robot: Robot, poses: FloatArray, names: Sequence[str], branch: Sequence[int]) -> _Body:
    shapes = tuple((shape, poses[:, k]) for k in branch for shape in robot.links[k].shapes)
    return _Body(names[branch[0]], poses[:, branch[0]], shapes)


def _fixture(name: str, X_WB: FloatArray, shapes: Iterable[CollisionShape], n: int) -> _Body:
    X = np.broadcast_to(X_WB, (n, 4, 4))
    return _Body(name, X, tuple((shape, X) for shape in shapes))


def _contacts(
    objects: Sequence[_Body], others: Sequence[_Body], rows: BoolArray
) -> tuple[tuple[tuple[str, str], ...], BoolArray]:
    """Pairs of objects with each other and with `others`, and (n, p) whether they touch in the rows."""
    pairs = [(a, b) for k, a in enumerate(objects) for b in (*objects[k + 1 :], *others)]
    columns = [_touching(a, b, np.flatnonzero(rows)) for a, b in pairs]
    touching = np.stack(columns, axis=1) if columns else np.zeros((int(rows.sum()), 0), dtype=bool)
    return tuple((a.name, b.name) for a, b in pairs), touching


def _touching(a: _Body, b: _Body, rows: np.ndarray) -> BoolArray:
    result = np.zeros(len(rows), dtype=bool)
    for (one, X_WA), (other, X_WB) in product(a.shapes, b.shapes):
        first, second = distance_shape(one), distance_shape(other)
        near = _may_touch(first, X_WA[rows], second, X_WB[rows]) & ~result
        for k in np.flatnonzero(near).tolist():
            result[k] = separation_m(first, X_WA[rows[k]], second, X_WB[rows[k]]) <= CONTACT_GAP_M
    return result


def _may_touch(a: DistanceShape, X_WA: FloatArray, b: DistanceShape, X_WB: FloatArray) -> BoolArray:
    """Whether the balls around two shapes come within the distance of a contact."""
    (centre_A, radius_A), (centre_B, radius_B) = centre_and_radius(a), centre_and_radius(b)
    across = (X_WA[:, :3, :3] @ centre_A + X_WA[:, :3, 3]) - (X_WB[:, :3, :3] @ centre_B + X_WB[:, :3, 3])
    return np.linalg.norm(across, axis=1) <= radius_A + radius_B + CONTACT_GAP_M


def _facts(name: str, shapes: Sequence[CollisionShape], shape_names: Sequence[str] = ()) -> ObjectFacts:
    """Corners of all shapes, and the top of each as a surface by the shape's name, the largest first."""
    corners = [shape_corners(shape) for shape in shapes] or [np.zeros((1, 3))]
    names = shape_names or [f"top_{k}" for k in range(len(shapes))]
    tops = [top for label, points in zip(names, corners, strict=False) if (top := _top(label, points)) is not None]
    return ObjectFacts(
        name=name,
        points_m=np.concatenate(corners),
        body=name,
        surfaces=tuple(sorted(tops, key=lambda top: -top.area_m2)),
    )


def _top(name: str, corners: FloatArray) -> SupportSurface | None:
    height = float(corners[:, 2].max())
    outline = shapely.convex_hull(shapely.MultiPoint(corners[corners[:, 2] >= height - TOP_SPREAD_M, :2]))
    if outline.area < LEAST_TOP_M2 or not isinstance(outline, shapely.Polygon):
        return None
    low, high = np.array(outline.bounds[:2]), np.array(outline.bounds[2:])
    centre = (low + high) / 2.0
    ring = np.asarray(shapely.geometry.polygon.orient(outline).exterior.coords)[:-1] - centre
    return SupportSurface(
        anchor_id=name,
        position_m=(float(centre[0]), float(centre[1]), height),
        polygon=AnchorPolygon(outline_m=tuple((float(x), float(y)) for x, y in ring)),
        normal=(0.0, 0.0, 1.0),
        area_m2=float(outline.area),
        clearance_m=None,
        load_directions=((0.0, 0.0, 1.0),),
    )
