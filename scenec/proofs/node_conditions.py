"""Necessary conditions at a node of the branch and bound: known poses, linear constraints, and disjunctions of these.

A node gives every thing a resting orientation and an interval of yaws. Conditions that hold for all yaws of the
intervals are linear in the origins (walls, ranges, `before`, `aligned`, `near` from outside ...). Two outlines that
must be apart, reduced to their `kernel` (the part covered at all yaws), give a disjunction: the difference of the
origins lies outside their grown Minkowski difference, a convex outline, hence beyond one of its edges. Each edge is one
option (beyond it, and not beyond the edges before it).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np
import shapely
from shapely import Polygon

from geom.planar import turned
from scenec.ir.problem import Problem, Thing
from scenec.proofs.constraints import LinearConstraint, NodePose
from scenec.proofs.outlines import OUTLINE_SLACK_M, TURN, half_planes, kernel
from scenec.proofs.places import forbidden, linear_bounds, minkowski, ring_of
from scenec.relations.table import RELATIONS
from schemas.arrays import FloatArray
from schemas.scene.geometry import SceneRelation, Stance

DISC_SIDES = 8
FAR_M = 1e3
KEPT_SHAPE = 0.005


@dataclass(frozen=True)
class BranchNode:
    """Poses of all things, and the options (`sides`) of disjunctions chosen so far."""

    poses: tuple[NodePose, ...]
    sides: tuple[LinearConstraint, ...] = ()
    chosen: frozenset[tuple] = frozenset()


@dataclass(frozen=True)
class Disjunction:
    """At least one of these sets of linear constraints must hold."""

    key: tuple
    things: tuple[int, ...]
    options: tuple[tuple[LinearConstraint, ...], ...]


class NodeConditions:
    """The conditions on one set of things on one owner, in the owner's frame P."""

    def __init__(self, problem: Problem, things: tuple[Thing, ...]) -> None:
        self.problem, self.things = problem, things
        self.index = {thing.name: k for k, thing in enumerate(things)}
        self.relations = [r for r in problem.relations if all(name in self.index for name in r.things)]
        self.corner = [thing.place.origin_P_m[:2] for thing in things]
        # Cached constraints and regions of a thing or pair, by orientations and yaws.
        self.walls: dict[tuple, list[LinearConstraint]] = {}
        self.blocked: dict[tuple, list[Disjunction]] = {}
        self.known: dict[tuple, Disjunction | None] = {}
        self.reached: dict[tuple, FloatArray] = {}

    def rows(self, node: BranchNode) -> list[LinearConstraint]:
        """Linear constraints that must hold at a node."""
        rows: list[LinearConstraint] = []
        for k, pose in enumerate(node.poses):
            if pose.at is not None:
                at = pose.at + self.corner[k]
                for sign, axis in product((1.0, -1.0), (0, 1)):
                    normal = (sign, 0.0) if axis == 0 else (0.0, sign)
                    rows.append(LinearConstraint(-1, k, normal, sign * float(at[axis]) + OUTLINE_SLACK_M))
                continue
            key = (k, pose.key)
            if key not in self.walls:
                normals, bounds = linear_bounds(pose.bounds, pose.yaw)
                limits = bounds + normals @ self.corner[k]
                self.walls[key] = [
                    LinearConstraint(-1, k, (float(n[0]), float(n[1])), float(b))
                    for n, b in zip(normals, limits, strict=True)
                ]
            rows += self.walls[key]
        for relation in self.relations:
            rows += self._relation_rows(node, relation)
        return rows

    def _relation_rows(self, node: BranchNode, relation: SceneRelation) -> list[LinearConstraint]:
        at = [self.index[name] for name in relation.things]
        turn = self._frame(node, relation.frame)
        along = None if turn is None else turned(np.array([relation.direction]), turn)[0]
        poses = [node.poses[k] for k in at]
        return list(RELATIONS[relation.kind].linear_rows(relation, at, poses, along))

    def _frame(self, node: BranchNode, frame: str) -> float | None:
        """Yaw in P of the frame of a relation, None where it is not fixed."""
        if frame == self.things[0].parent:
            return 0.0
        if frame in self.index:
            low, high = node.poses[self.index[frame]].yaw
            return low if high - low < 1e-9 else None
        return None

    def disjunctions(self, node: BranchNode) -> list[Disjunction]:
        """Disjunctions that must hold at a node."""
        disjunctions: list[Disjunction] = []
        for k, pose in enumerate(node.poses):
            if pose.at is None:
                key = ("blocked", k, pose.key)
                if key not in self.blocked:
                    rings = forbidden(pose.bounds, pose.yaw)
                    self.blocked[key] = [
                        self._beyond((*key, n), np.zeros((1, 2)), -1, self._alone(k, pose), k, ring + self.corner[k])
                        for n, ring in enumerate(rings)
                    ]
                disjunctions += self.blocked[key]
        for one, two in combinations(range(len(self.things)), 2):
            disjunctions += self._apart(node, one, two, self.problem.clearance_m, "apart")
        for n, relation in enumerate(self.relations):
            at = [self.index[name] for name in relation.things]
            meaning = RELATIONS[relation.kind]
            if (least_m := meaning.least_distance_m(relation)) is not None:
                disjunctions += self._apart(node, at[0], at[1], least_m, f"far {n}")
            disjunctions += [
                Disjunction((relation.kind, n, k), tuple(at), options)
                for k, options in enumerate(meaning.disjunctions(relation, at))
            ]
        return disjunctions

    def _apart(self, node: BranchNode, one: int, two: int, gap_m: float, word: str) -> list[Disjunction]:
        """Disjunctions of pairs of pieces of two things that must keep a gap; none where they may not overlap in
        height."""
        first, second = node.poses[one], node.poses[two]
        if word == "apart" and not self._surely_meet(one, two, first, second):
            return []
        disjunctions = []
        for (m, piece), (n, other) in product(_pieces(first.stance), _pieces(second.stance)):
            key = (word, one, two, m, n, first.key, second.key)
            if key not in self.known:
                inner, outer = kernel(piece, first.yaw), kernel(other, second.yaw)
                thick = len(inner) >= 3 and len(outer) >= 3
                ring = _fewer_corners(_grown(minkowski(inner, -outer), gap_m)) if thick else None
                alone = self._alone(one, first), self._alone(two, second)
                self.known[key] = None if ring is None else self._beyond(key, alone[0], one, alone[1], two, ring)
            if (disjunction := self.known[key]) is not None:
                disjunctions.append(disjunction)
        return disjunctions

    def _surely_meet(self, one: int, two: int, first: NodePose, second: NodePose) -> bool:
        """Whether two things of one place overlap in height at all their poses. False where in doubt."""
        if self.things[one].place.name != self.things[two].place.name:
            return False
        top, other_top = first.base_m[0] + first.stance.height_m, second.base_m[0] + second.stance.height_m
        return first.base_m[1] < other_top - OUTLINE_SLACK_M and second.base_m[1] < top - OUTLINE_SLACK_M

    def _beyond(
        self, key: tuple, first: FloatArray, one: int, second: FloatArray, two: int, ring: FloatArray
    ) -> Disjunction:
        """p_two - p_one lies outside a convex outline: beyond one edge, and not beyond those before it.

        `first` and `second` are the corners of the regions of both origins by walls alone; unreachable edges are no
        option.
        """
        edges = np.roll(ring, -1, axis=0) - ring
        lengths = np.hypot(edges[:, 0], edges[:, 1])
        normals = (np.stack([edges[:, 1], -edges[:, 0]], axis=1)[lengths > 0.0]) / lengths[lengths > 0.0, None]
        offsets = np.einsum("ij,ij->i", normals, ring[lengths > 0.0])
        farthest = (second @ normals.T).max(axis=0) - (first @ normals.T).min(axis=0)
        options: list[tuple[LinearConstraint, ...]] = []
        within: list[LinearConstraint] = []
        for k in np.argsort(-lengths[lengths > 0.0], kind="stable"):
            x, y, offset = float(normals[k, 0]), float(normals[k, 1]), float(offsets[k])
            if farthest[k] >= offset - OUTLINE_SLACK_M:
                options.append((LinearConstraint(one, two, (-x, -y), OUTLINE_SLACK_M - offset), *within))
                within.append(LinearConstraint(one, two, (x, y), offset + OUTLINE_SLACK_M))
        return Disjunction(key, (two,) if one < 0 else (one, two), tuple(options))

    def _alone(self, k: int, pose: NodePose) -> FloatArray:
        """Corners (m, 2) of the region in P of the origin of a thing by its walls alone."""
        key = (k, pose.key)
        if pose.at is not None:
            return (pose.at + self.corner[k])[None]
        if key not in self.reached:
            normals, bounds = linear_bounds(pose.bounds, pose.yaw)
            region = half_planes(normals, bounds, FAR_M * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float))
            self.reached[key] = (region if len(region) else np.zeros((1, 2))) + self.corner[k]
        return self.reached[key]


def _pieces(stance: Stance) -> list[tuple[int, FloatArray]]:
    """The two largest outlines of an orientation: any subset gives valid conditions."""
    order = sorted(range(len(stance.prisms)), key=lambda k: -Polygon(stance.prisms[k].outline_m).area)
    return [(k, stance.prisms[k].outline_m) for k in order[:2]]


def _fewer_corners(ring: FloatArray) -> FloatArray:
    """A convex outline inside the given one with fewer sides, at most KEPT_SHAPE of its size away."""
    tolerance = KEPT_SHAPE * float(np.ptp(ring, axis=0).max())
    simplified = ring_of(shapely.simplify(Polygon(ring), tolerance, preserve_topology=True))
    return simplified if len(simplified) >= 3 else ring


def _grown(ring: FloatArray, gap_m: float) -> FloatArray:
    """The outline grown by a polygon inside the disc of that radius."""
    if gap_m <= 0.0:
        return ring
    angles = np.arange(DISC_SIDES) * (TURN / DISC_SIDES)
    return minkowski(ring, gap_m * np.stack([np.cos(angles), np.sin(angles)], axis=1))
