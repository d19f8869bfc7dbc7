"""Ways in which a gripper moves a joint at its recorded contact: pads that close on it, or closed fingers that push.

Everything is in the asset frame A (metres), with the joint at the position from which it is moved and the others at
rest. Each way keeps fingers and hand clear of all links while the hand comes in, and over as much of the path of the
joint as is said.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from assetkit.affordances.grasps import pad_friction, propose_grasps
from geom.convex.clip import clipped_shape
from geom.convex.convex_union import ConvexUnion
from geom.convex.placement import moved_shape
from geom.grasp.gripper import Gripper, boxes, lowest
from geom.mechanism_pose import link_motions
from geom.mesh.farthest_points import farthest_points
from geom.pose import inverse, pose, pose_from_quat, shortest_rotation
from schemas.arrays import BoolArray, FloatArray
from schemas.articulation import JointContact
from schemas.mechanism import MechanismJoint
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import CollisionShape, MassProperties
from sim.joint_exercise import Articulation, followers, moved_links
from sim.joint_handling import APPROACH_M, MOST_MOVE_S, carry

LEAST_MARGIN_M, MARGIN = 0.005, 0.1  # around the recorded region, in which a grip counts as at it; share of its size
PATH_STEPS = 12  # along the path at which fingers and hand are tried, beside its start
APPROACH_STEPS = 4
CLEAR_M = 0.001  # between fingers that are to push and what they push
AGAINST = 0.7  # least cosine between the push and the inward normal: within the friction of rubber
PUSH_PLACES = 12  # that are tried on the region
SIDES = 8  # directions around the normal in which fingers may lie against it
FOREARM_M = (0.06, 0.06, 0.4)  # box behind the hand: a slim wrist and forearm
PAD_SAFETY, LEAST_PAD_N, LEAST_PAD_ARM_M = 3.0, 10.0, 0.005
_UP = np.array([0.0, 0.0, 1.0])
_TOKEN_KG = 1e-3  # mass of the handle alone: a hand that turns a door does not carry it


@dataclass(frozen=True)
class Hold:
    """One way: the gripper at X_AG (4, 4) with its opening; `takes`: pads close on the link, else closed fingers push.

    free    share of the path over which fingers and hand are clear of all links and of the ground.
    gap_m   way of the joint's contact along the path before fingers touch; 0 of pads.
    """

    gripper: Gripper
    X_AG: FloatArray
    opening_m: float
    takes: bool
    free: float
    quality: float
    gap_m: float = 0.0


@dataclass(frozen=True)
class HandledJoint:
    """A joint to be moved from `start` to `end` at the contact that was recorded at rest."""

    articulation: Articulation
    joint: MechanismJoint
    contact: JointContact
    start: float
    end: float
    _shapes: Mapping[str, tuple[CollisionShape, ...]] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Place the shapes of all links at the start."""
        mechanism = self.articulation.mechanism
        motions = link_motions(mechanism, {self.joint.name: self.start})
        origins = {link.name: pose(None, link.origin) for link in mechanism.links}
        shapes = {
            body.name: tuple(moved_shape(shape, motions[body.name] @ origins[body.name]) for shape in body.shapes)
            for body in self.articulation.links
        }
        object.__setattr__(self, "_shapes", shapes)

    @property
    def shapes(self) -> tuple[CollisionShape, ...]:
        """Of all links, at the start."""
        return tuple(shape for of_link in self._shapes.values() for shape in of_link)

    def of_link(self, link: str) -> tuple[CollisionShape, ...]:
        """Of one link, at the start."""
        return self._shapes[link]

    def region(self) -> tuple[CollisionShape, ...]:
        """What of the link of the contact lies in the recorded region and a margin around it, at the start."""
        low, high = np.array(self.contact.low_m), np.array(self.contact.high_m)
        margin = np.maximum(LEAST_MARGIN_M, MARGIN * (high - low))
        back = inverse(self._from_rest())
        parts = [
            clipped_shape(moved_shape(shape, back), low - margin, high + margin)
            for shape in self.of_link(self.contact.link)
        ]
        return tuple(moved_shape(part, self._from_rest()) for part in parts if part is not None)

    def place(self) -> FloatArray:
        """(3,) the contact at the start."""
        X = self._from_rest()
        return X[:3, :3] @ np.array(self.contact.position_m) + X[:3, 3]

    def direction(self, points: FloatArray) -> FloatArray:
        """(n, 3) unit directions in which points (n, 3) of the link move first; zero on the axis."""
        axis = math.copysign(1.0, self.end - self.start) * np.asarray(self.joint.axis)
        if not self.joint.is_angular:
            return np.broadcast_to(axis, points.shape)
        moving = np.cross(axis, points - self.joint.anchor)
        length = np.linalg.norm(moving, axis=1, keepdims=True)
        return np.where(length > 1e-9, moving / np.maximum(length, 1e-9), 0.0)

    def free_share(self, X_AG: FloatArray, opening_m: FloatArray, gripper: Gripper) -> FloatArray:
        """(g,) share of the path over which grippers X_AG (g, 4, 4) and an arm are clear; -1: not on the way in."""
        X_GB, half = _with_arm(*boxes(gripper, opening_m))
        X_AB = X_AG[:, None] @ X_GB
        mechanism, joint = self.articulation.mechanism, self.joint
        unions = {name: ConvexUnion(shapes) for name, shapes in self._shapes.items() if shapes}
        open_ways = np.ones(len(X_AG), dtype=bool)
        for step in range(APPROACH_STEPS + 1):
            away = -APPROACH_M * step / APPROACH_STEPS * X_AG[:, :3, 2]
            here = X_AB.copy()
            here[..., :3, 3] += away[:, None]
            for union in unions.values():
                open_ways[open_ways] = _clear(union, here[open_ways], half[open_ways])
        share = np.where(open_ways, 0.0, -1.0)
        begin = link_motions(mechanism, {joint.name: self.start})
        for step in range(1, PATH_STEPS + 1):
            index = np.flatnonzero(share >= (step - 1) / PATH_STEPS - 1e-9)
            if not len(index):
                break
            at = self.start + step / PATH_STEPS * (self.end - self.start)
            motions, carried = link_motions(mechanism, {joint.name: at}), carry(joint, self.start, at)
            clear = lowest(carried @ X_AB[index], half[index], _UP) >= 0.0
            for name, union in unions.items():
                back = begin[name] @ inverse(motions[name]) @ carried
                if np.allclose(back, np.eye(4), atol=1e-9):
                    continue  # It moves along.
                clear[clear] = _clear(union, back @ X_AB[index[clear]], half[index[clear]])
            share[index[clear]] = step / PATH_STEPS
        return share

    def _from_rest(self) -> FloatArray:
        return carry(self.joint, self.joint.rest, self.start)


def pad_holds(handled: HandledJoint, gripper: Gripper) -> tuple[list[Hold], str]:
    """Pads that close on the region, those with the longest free path first; or none, and the reason."""
    region = handled.region()
    if not region:
        return [], "no collider is at the contact"
    body = next(body for body in handled.articulation.links if body.name == handled.contact.link)
    token = MassProperties(_TOKEN_KG, handled.place(), _TOKEN_KG * 1e-6 * np.eye(3))
    proposed = propose_grasps(replace(body, shapes=region, mass=token), (), gripper, handled.shapes)
    if not proposed.grasps:
        return [], proposed.reason
    grasps = proposed.grasps
    X_AG = np.array([pose_from_quat(np.array(g.quat_wxyz), g.position_m) for g in grasps])
    opening = np.array([g.opening_m for g in grasps])
    free = handled.free_share(X_AG, opening, gripper)
    holds = [
        Hold(gripper, X_AG[k], float(opening[k]), takes=True, free=float(free[k]), quality=grasps[k].quality)
        for k in range(len(grasps))
    ]
    return _best(holds), "fingers or hand would touch the object on the way in or along the path"


def push_holds(handled: HandledJoint, gripper: Gripper) -> tuple[list[Hold], str]:
    """Closed fingers that push where the region faces against the motion, with their tips or with a side."""
    region = handled.region()
    if not region:
        return [], "no collider is at the contact"
    points, normals = ConvexUnion(region).outer_samples(2000)
    body = ConvexUnion(handled.of_link(handled.contact.link))
    against = -(normals * handled.direction(points)).sum(axis=1)
    usable = (against >= AGAINST) & ~body.inside(points + 0.5 * CLEAR_M * normals)
    if not usable.any():
        return [], "nothing at the contact faces against the motion"
    points, normals, against = points[usable], normals[usable], against[usable]
    middle = int(np.argmin(np.linalg.norm(points - points.mean(axis=0), axis=1)))
    chosen = np.array(farthest_points(points, middle, PUSH_PLACES, 1e-3))
    X_AG = np.concatenate([_against(points[k], normals[k], gripper) for k in chosen])
    of_place = np.repeat(chosen, len(X_AG) // len(chosen))
    free = handled.free_share(X_AG, np.zeros(len(X_AG)), gripper)
    size = max(float(np.ptp(points, axis=0).max()), CLEAR_M)
    holds = [
        Hold(
            gripper,
            X_AG[k],
            0.0,
            takes=False,
            free=float(free[k]),
            quality=float(against[n]) - 0.5 * float(np.linalg.norm(points[n] - points[middle])) / size,
            gap_m=CLEAR_M / float(against[n]),
        )
        for k, n in enumerate(of_place)
    ]
    return _best(holds), "closed fingers or the hand would touch the object on the way in or along the path"


def friction_of(handled: HandledJoint) -> float:
    """Between rubber pads and the link of the contact."""
    return pad_friction(next(b.contact for b in handled.articulation.links if b.name == handled.contact.link))


def pad_force(handled: HandledJoint, hold: Hold) -> float:
    """Force of each pad (N): `PAD_SAFETY` times what friction needs at the grip to move the joint against its friction,
    damping and spring and against weight and inertia of its link, from `LEAST_PAD_N` to what the gripper has.
    """
    joint, articulation = handled.joint, handled.articulation
    moved = moved_links(articulation.mechanism, (joint, *followers(articulation.mechanism, joint)))
    origins = {link.name: link.origin for link in articulation.mechanism.links}
    bodies = [body for body in articulation.links if body.name in moved]
    way = abs(handled.end - handled.start)
    arm_m = reach_m = 1.0
    if joint.is_angular:
        centres = np.array([origins[body.name] + body.mass.centre_of_mass_m for body in bodies])
        reach_m = float(np.linalg.norm(np.cross(centres - joint.anchor, joint.axis), axis=1).max())
        grip = float(np.linalg.norm(np.cross(hold.X_AG[:3, 3] - joint.anchor, joint.axis)))
        arm_m = max(grip, 0.5 * hold.opening_m, LEAST_PAD_ARM_M)
    mass_kg = sum(body.mass.mass_kg for body in bodies)
    rate = way / MOST_MOVE_S
    effort = joint.friction + 1.5 * joint.damping * rate + joint.stiffness * way
    effort += mass_kg * reach_m * (GRAVITY_MPS2 + 6.0 * rate / MOST_MOVE_S * reach_m)
    needed_n = PAD_SAFETY * effort / arm_m / (2.0 * max(friction_of(handled), 0.01))
    return min(max(needed_n, LEAST_PAD_N), hold.gripper.force_n)


def _best(holds: list[Hold]) -> list[Hold]:
    """Those that can come in, by the length of their free path and then by quality."""
    return sorted((h for h in holds if h.free >= 0.0), key=lambda h: (-round(h.free, 6), -h.quality))


def _with_arm(X_GB: FloatArray, half_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Boxes (k, 4, 4, 4) of fingers, hand and the arm behind it, which no closed door can have inside."""
    X_arm = X_GB[:, 2:3].copy()
    X_arm[..., 2, 3] -= half_m[:, 2:3, 2] + 0.5 * FOREARM_M[2]
    arm = np.broadcast_to(0.5 * np.array(FOREARM_M), (len(half_m), 1, 3))
    return np.concatenate([X_GB, X_arm], axis=1), np.concatenate([half_m, arm], axis=1)


def _clear(union: ConvexUnion, X_AB: FloatArray, half_m: FloatArray) -> BoolArray:
    """(g,) whether all boxes X_AB (g, b, 4, 4) with half edges (g, b, 3) are clear of the union."""
    clear = np.ones(len(X_AB), dtype=bool)
    for b in range(X_AB.shape[1]):
        clear[clear] = union.box_clear(X_AB[clear, b], half_m[clear, b]).astype(bool)
    return clear


def _against(point: FloatArray, normal: FloatArray, gripper: Gripper) -> FloatArray:
    """(k, 4, 4) closed fingers before a point of a surface: tips first, turned four ways, or with a side of theirs."""
    R_AN = shortest_rotation(_UP, normal)
    poses: list[FloatArray] = []
    for turn in np.pi / 4.0 * np.arange(4):
        x = R_AN @ np.array([math.cos(turn), math.sin(turn), 0.0])
        away = 0.5 * gripper.pad_m[1] + CLEAR_M
        poses.append(pose(np.column_stack([x, np.cross(-normal, x), -normal]), point + away * normal))
    for turn in 2.0 * np.pi / SIDES * np.arange(SIDES):
        z = R_AN @ np.array([math.cos(turn), math.sin(turn), 0.0])
        away = 0.5 * gripper.pad_m[0] + CLEAR_M
        poses.append(pose(np.column_stack([np.cross(normal, z), normal, z]), point + away * normal))
    return np.array(poses)
