"""Complete argument for few things: branch and bound over yaws, orientations, fixed poses and sides, with linear
bounds.

Where the linear conditions of a node (`node_conditions`) have no solution, the node is closed. Otherwise the solution
violates some disjunction, for instance that two things are apart: one child for each option of it. When none is
violated the widest interval of yaws is halved. All nodes closed means no scene. The number of linear programs is
bounded; a point that satisfies everything ends the search without a claim.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, product

import networkx as nx
import numpy as np
import shapely
from scipy.optimize import linprog

from scenec.ir.problem import Problem, Proof, Thing
from scenec.proofs.constraints import LinearConstraint, NodePose
from scenec.proofs.fits import fixed_pose_usable
from scenec.proofs.node_conditions import FAR_M, BranchNode, Disjunction, NodeConditions
from scenec.proofs.outlines import OUTLINE_SLACK_M, SMALLEST_CELL_RAD, YawCell, hull, period
from scenec.proofs.places import PlacementBounds, fits_height, free_region, max_base_height, placement_bounds
from scenec.relations.table import RELATIONS
from schemas.arrays import FloatArray
from schemas.scene.geometry import Stance

MOST_THINGS = 5
MOST_START_NODES = 64
COARSE_CELL_RAD = np.radians(15.001)  # slightly more than a whole fraction of a turn


def no_arrangement(problem: Problem, most_programs: int = 400) -> Proof | None:
    """A proof when the things on one owner, or a few of them linked by relations, have no arrangement."""
    for things in related_sets(problem):
        search = BranchAndBound(problem, things)
        if search.closed(most_programs):
            names = ", ".join(thing.name for thing in things)
            rules = tuple(relation.path for relation in search.conditions.relations)
            text = f"{names} have no arrangement: every combination of headings and sides was ruled out"
            paths = tuple(dict.fromkeys((*rules, *(thing.path for thing in things))))
            return Proof("infeasible", text, 0.0, 1.0, "arrangements", paths)
    return None


def related_sets(problem: Problem) -> list[tuple[Thing, ...]]:
    """Sets of 2 to MOST_THINGS things on one owner: all of them, or those that relations link."""
    sets: list[tuple[Thing, ...]] = []
    for parent in dict.fromkeys(thing.parent for thing in problem.things):
        things = [thing for thing in problem.things if thing.parent == parent]
        if len(things) <= MOST_THINGS:
            sets += [tuple(things)] if len(things) > 1 else []
            continue
        ties: nx.Graph[str] = nx.Graph()
        ties.add_nodes_from(thing.name for thing in things)
        for relation in problem.relations:
            if all(name in ties for name in relation.things):
                nx.add_path(ties, relation.things)
        for related in nx.connected_components(ties):
            if 2 <= len(related) <= MOST_THINGS:
                sets.append(tuple(thing for thing in things if thing.name in related))
    return sets


class BranchAndBound:
    """The search over one set of things on one owner."""

    def __init__(self, problem: Problem, things: tuple[Thing, ...]) -> None:
        self.problem, self.things = problem, things
        self.conditions = NodeConditions(problem, things)
        self.programs = 0

    def closed(self, most_programs: int) -> bool:
        """Whether every node is closed within so many linear programs."""
        nodes = self._start()
        if nodes is None:
            return False
        while nodes:
            node = nodes.pop()
            rows = (*self.conditions.rows(node), *node.sides)
            point = self._solve(rows)
            if point is None:
                continue
            if self.programs >= most_programs:
                return False
            broken = self._broken(node, point)
            coarse = self._widest(node, broken.things if broken else range(len(self.things)))
            width = node.poses[coarse].yaw[1] - node.poses[coarse].yaw[0]
            if broken is not None and (width <= COARSE_CELL_RAD or not broken.options):
                nodes += [
                    replace(node, sides=(*node.sides, *rows), chosen=node.chosen | {broken.key})
                    for rows in reversed(broken.options)
                ]
                continue
            low, high = node.poses[coarse].yaw
            if high - low < SMALLEST_CELL_RAD or (broken is None and self._has_arrangement(node)):
                return False
            middle = (low + high) / 2.0
            nodes += [self._with_yaw(node, coarse, cell) for cell in ((middle, high), (low, middle))]
        return True

    def _start(self) -> list[BranchNode] | None:
        """One node for each choice of orientations and fixed poses; None when they are too many."""
        choices = [self._poses(thing) for thing in self.things]
        if np.prod([float(len(poses)) for poses in choices]) > MOST_START_NODES:
            return None
        return [BranchNode(poses) for poses in product(*choices)]

    def _poses(self, thing: Thing) -> list[NodePose]:
        if thing.domain.fixed_poses:
            poses = []
            for fixed_pose in thing.domain.fixed_poses:
                stance = thing.body.resting_orientations[fixed_pose.stance]
                base = fixed_pose.z_m - stance.origin_height_m
                at = np.array([fixed_pose.x_m, fixed_pose.y_m])
                if fixed_pose_usable(self.problem, thing, fixed_pose):
                    yaw = (fixed_pose.yaw_rad, fixed_pose.yaw_rad)
                    poses.append(NodePose(stance, yaw, placement_bounds(self.problem, thing, stance), (base, base), at))
            return poses
        resting_orientations = [
            thing.body.resting_orientations[k]
            for k in thing.domain.orientation_indices
            if fits_height(thing, thing.body.resting_orientations[k])
        ]
        rooms = [(stance, placement_bounds(self.problem, thing, stance)) for stance in resting_orientations]
        return [
            NodePose(stance, cell, place, (0.0, max_base_height(thing, stance)))
            for stance, place in rooms
            for cell in self._usable(thing, stance, place)
        ]

    def _usable(self, thing: Thing, stance: Stance, place: PlacementBounds) -> list[YawCell]:
        """Yaw intervals at which the thing alone has a free region, adjacent ones joined; one period of a symmetric
        outline."""
        low, high = thing.domain.yaw_rad
        turns = any(RELATIONS[r.kind].heading_matters(r, thing.name) for r in self.conditions.relations)
        if not turns and len(stance.prisms) == 1:
            high = min(high, low + period(hull(stance.prisms)))
        if high - low < 1e-9:
            return [(low, high)]
        count = max(1, int(np.ceil((high - low) / COARSE_CELL_RAD - 1e-9)))
        ends = np.linspace(low, high, count + 1).tolist()
        joined: list[YawCell] = []
        for cell in pairwise(ends):
            if shapely.is_empty(free_region(place, cell)):
                continue
            if joined and joined[-1][1] == cell[0]:
                joined[-1] = (joined[-1][0], cell[1])
            else:
                joined.append(cell)
        return joined

    def _with_yaw(self, node: BranchNode, thing: int, yaw: YawCell) -> BranchNode:
        poses = (*node.poses[:thing], replace(node.poses[thing], yaw=yaw), *node.poses[thing + 1 :])
        return BranchNode(poses, node.sides, node.chosen)

    def _widest(self, node: BranchNode, things) -> int:
        return max(things, key=lambda k: (node.poses[k].yaw[1] - node.poses[k].yaw[0], -k))

    def _solve(self, rows: tuple[LinearConstraint, ...]) -> FloatArray | None:
        """Origins (n, 2) in P that satisfy the constraints, or None if infeasible (a failed program counts as
        feasible)."""
        count = len(self.things)
        matrix = np.zeros((len(rows), 2 * count))
        for k, row in enumerate(rows):
            if row.second >= 0:
                matrix[k, 2 * row.second : 2 * row.second + 2] += row.normal
            if row.first >= 0:
                matrix[k, 2 * row.first : 2 * row.first + 2] -= row.normal
        bounds = np.array([row.bound for row in rows])
        self.programs += 1
        answer = linprog(np.zeros(2 * count), A_ub=matrix, b_ub=bounds, bounds=(-FAR_M, FAR_M), method="highs-ds")
        if answer.status == 2:
            return None
        return np.zeros((count, 2)) if answer.x is None else answer.x.reshape(-1, 2)

    def _broken(self, node: BranchNode, point: FloatArray) -> Disjunction | None:
        """The disjunction most violated at the point, among those not yet chosen at the node."""
        worst, most_broken = OUTLINE_SLACK_M, None
        for disjunction in self.conditions.disjunctions(node):
            if disjunction.key in node.chosen:
                continue
            excess = [max(_excess(row, point) for row in rows) for rows in disjunction.options]
            amount = min(excess, default=np.inf)
            if amount > worst:
                worst, most_broken = amount, disjunction
        return most_broken

    def _has_arrangement(self, node: BranchNode) -> bool:
        """Whether the chosen sides leave an arrangement at the middle yaws, so that no claim can be made."""
        middles = tuple(replace(pose, yaw=(sum(pose.yaw) / 2.0,) * 2) for pose in node.poses)
        exact = BranchNode(middles, node.sides, node.chosen)
        point = self._solve((*self.conditions.rows(exact), *node.sides))
        return point is not None and self._broken(replace(exact, chosen=frozenset()), point) is None


def _excess(row: LinearConstraint, point: FloatArray) -> float:
    """Violation (m) of a constraint at origins (n, 2) in P."""
    first = point[row.first] if row.first >= 0 else np.zeros(2)
    second = point[row.second] if row.second >= 0 else np.zeros(2)
    return float((second - first) @ row.normal) - row.bound
