"""Proposes grasps of a body for a parallel-jaw gripper: antipodal pairs on its colliders within the gripper's reach."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.affordances.named_regions import DIGITS
from geom.convex.convex_union import ConvexUnion
from geom.grasp.antipodal import LEAST_M, AntipodalPairs, antipodal_pairs
from geom.grasp.contact_patches import contact_patches, holding_force
from geom.grasp.gripper import Gripper, boxes, lowest
from geom.mesh.farthest_points import farthest_points
from geom.pose import matrix_of, quat_of
from schemas.acceptance import StablePose
from schemas.affordances import Grasp
from schemas.anchors import Point3
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.asset import vec3
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import CollisionShape, Contact, RigidBody
from sim.port import pair_value

MOST = 16
PAIRS = 96  # that are tried with every approach
APPROACHES = 12
# Where the pads touch, as a share of half their height: the middle, or near the tip for what lies flat.
DEPTHS = (0.0, 0.7)
# Of the force over what just holds; lifting and shaking add 30 % to the weight.
SAFETY, LEAST_SAFETY = 3.0, 1.5
LEAST_FORCE_N = 0.5
GROUND_M = 0.001
LEAST_QUALITY = 0.1
APART = 0.12  # Two grasps differ by this share of the size, or by a turn of 30 degrees.
DIRECTION_WEIGHT = 0.25  # weight of directions beside places
PAD = Contact(static_friction=0.9, dynamic_friction=0.7, restitution=0.0)  # rubber of materials.csv


@dataclass(frozen=True)
class GraspProposals:
    """The grasps, best first, or the reason why there are none."""

    grasps: tuple[Grasp, ...]
    reason: str = ""


def pad_friction(contact: Contact) -> float:
    """Friction between a surface and a pad of rubber; the dynamic one, for a pad that slips must hold again."""
    return pair_value(contact.dynamic_friction, PAD.dynamic_friction, contact.combine)


def propose_grasps(
    body: RigidBody,
    poses: Sequence[StablePose],
    gripper: Gripper = Gripper(),
    obstacles: Sequence[CollisionShape] = (),
) -> GraspProposals:
    """Up to 16 grasps with places and approaches spread over the body.

    Each lies in the friction cones, keeps fingers and hand clear of the body, of `obstacles` in the same frame, and, in
    at least one of the stable `poses` (the reference pose when there are none), of the ground. Quality is the product
    of the share of the friction cone that is left, of how near the mass centre is, of the share of the pads that
    touches, and of the share of the force that is left, to the fourth root; it loses up to half for the chance of poses
    in which the grasp is not free.
    """
    if reason := _too_heavy(body, gripper):
        return GraspProposals((), reason)
    union = ConvexUnion(body.shapes)
    pairs = antipodal_pairs(union, math.atan(pad_friction(body.contact)), gripper.widest_m())
    if not len(pairs.angle_rad):
        return GraspProposals(
            (), f"nothing of it is at most {1000 * gripper.widest_m():.0f} mm wide between parallel sides"
        )
    return _grasps_of(pairs, union, body, poses, gripper, obstacles)


def grasps_along(
    lines_m: Sequence[tuple[Point3, Point3]],
    body: RigidBody,
    poses: Sequence[StablePose],
    gripper: Gripper = Gripper(),
) -> GraspProposals:
    """Up to 16 grasps whose pads close along the given lines (two ends each, asset frame), as `propose_grasps`.

    The pads touch where a line, extended to both sides, first enters the colliders; a line that misses them, or
    along which they are wider than the gripper, gives none.
    """
    if reason := _too_heavy(body, gripper):
        return GraspProposals((), reason)
    union = ConvexUnion(body.shapes)
    ends = np.asarray(lines_m, dtype=np.float64).reshape(-1, 2, 3)
    along = ends[:, 1] - ends[:, 0]
    lengths = np.linalg.norm(along, axis=1)
    middle, along = ends.mean(axis=1)[lengths > 0.0], along[lengths > 0.0] / lengths[lengths > 0.0, None]
    away = union.size + np.linalg.norm(middle - body.mass.centre_of_mass_m, axis=1, keepdims=True)
    first, last = middle - away * along, middle + away * along
    depth = np.stack([union.first_entry(first, along), union.first_entry(last, -along)], axis=1)
    met = np.isfinite(depth).all(axis=1)
    first, last, along, depth = first[met], last[met], along[met], depth[met]
    pairs = AntipodalPairs(first + depth[:, :1] * along, last - depth[:, 1:] * along, np.zeros(len(along)))
    pairs = pairs.take(np.flatnonzero((pairs.width_m >= LEAST_M) & (pairs.width_m <= gripper.widest_m())))
    if not len(pairs.angle_rad):
        return GraspProposals(
            (), f"no line crosses a part at most {1000 * gripper.widest_m():.0f} mm wide of the colliders"
        )
    return _grasps_of(pairs, union, body, poses, gripper, ())


def _too_heavy(body: RigidBody, gripper: Gripper) -> str:
    """Why the force of the gripper cannot hold the weight; "" where it can."""
    least_n = SAFETY * body.mass.mass_kg * GRAVITY_MPS2 / (2.0 * pad_friction(body.contact))
    if least_n <= gripper.force_n:
        return ""
    return f"it weighs {body.mass.mass_kg:.3g} kg: {least_n:.3g} N a finger, more than a gripper has"


def _grasps_of(
    pairs: AntipodalPairs,
    union: ConvexUnion,
    body: RigidBody,
    poses: Sequence[StablePose],
    gripper: Gripper,
    obstacles: Sequence[CollisionShape],
) -> GraspProposals:
    """The grasps that close on the pairs of places, of which there is one at least; see `propose_grasps`."""
    friction = pad_friction(body.contact)
    cone_rad, weight_n = math.atan(friction), body.mass.mass_kg * GRAVITY_MPS2
    near = 1.0 - np.linalg.norm(pairs.middle_m - body.mass.centre_of_mass_m, axis=1) / (0.5 * union.size)
    left = (1.0 - pairs.angle_rad / cone_rad) * np.clip(near, 0.05, 1.0)
    pairs, left = _spread_pairs(pairs, left, union.size)
    X_AG, of_pair = _approaches(pairs, gripper)
    X_GB, half = boxes(gripper, gripper.open_for(pairs.width_m[of_pair]))
    X_AB = X_AG[:, None] @ X_GB
    free = np.ones(len(X_AG), dtype=bool)
    for b in range(3):
        free[free] = union.box_clear(X_AB[free, b], half[free, b])
    if obstacles:
        around = ConvexUnion(obstacles)
        for b in range(3):
            free[free] = around.box_clear(X_AB[free, b], half[free, b])
    over = _over_ground(X_AB, half, poses)
    free &= over.any(axis=1)
    if not free.any():
        return GraspProposals((), "fingers or hand would touch it, or the ground, in every grasp tried")
    X_AG, of_pair, over = X_AG[free], of_pair[free], over[free]
    patches = contact_patches(union, X_AG, pairs.width_m[of_pair], gripper)
    lever_m = np.linalg.norm(np.cross(body.mass.centre_of_mass_m - patches.middle_m, X_AG[:, :3, 0]), axis=1)
    needed_n = holding_force(weight_n, lever_m, patches.arm_m, pairs.angle_rad[of_pair], friction)
    strong = LEAST_SAFETY * needed_n <= gripper.force_n
    if not strong.any():
        needs = f"{LEAST_SAFETY * needed_n.min():.3g} N a finger, more than a gripper has"
        return GraspProposals((), f"it would turn between the pads without {needs}")
    force_n = np.minimum(SAFETY * needed_n, gripper.force_n)
    chance = np.array([p.probability for p in poses]) if poses else np.ones(1)
    often = np.minimum((over * (chance / max(chance.sum(), 1e-9))).sum(axis=1), 1.0)
    shares = left[of_pair] * patches.share * np.clip(1.0 - force_n / gripper.force_n, 0.05, 1.0)
    worth = shares**0.25 * (1.0 + often) / 2.0
    best = np.flatnonzero(strong & (worth >= LEAST_QUALITY))
    if not len(best):
        return GraspProposals((), f"no grasp is better than {worth[strong].max():.2g} of {LEAST_QUALITY}")
    best = best[np.argsort(-np.round(worth[best], DIGITS), kind="stable")]
    chosen = best[_spread_grasps(X_AG[best], union.size)]
    chosen = chosen[np.argsort(-np.round(worth[chosen], DIGITS), kind="stable")]
    press_n = np.maximum(force_n, LEAST_FORCE_N)
    return GraspProposals(
        tuple(
            _grasp(
                f"grasp_{i + 1:02d}",
                X_AG[g],
                pairs,
                int(of_pair[g]),
                worth[g],
                over[g],
                cone_rad,
                float(press_n[g]),
                gripper,
            )
            for i, g in enumerate(chosen)
        )
    )


def _spread_pairs(pairs: AntipodalPairs, quality: FloatArray, size: float) -> tuple[AntipodalPairs, FloatArray]:
    """The pairs that are tried further, spread over the body from the best one on."""
    sign = np.sign(np.round(pairs.axis, DIGITS) @ np.array([1.0, 1e-3, 1e-6]))
    features = np.hstack(
        [pairs.middle_m / size, DIRECTION_WEIGHT * pairs.axis * np.where(sign == 0.0, 1.0, sign)[:, None]]
    )
    chosen = np.array(farthest_points(features, int(np.round(quality, DIGITS).argmax()), PAIRS, 1e-3))
    return pairs.take(chosen), quality[chosen]


def _spread_grasps(X_AG: FloatArray, size: float) -> list[int]:
    features = np.hstack(
        [X_AG[:, :3, 3] / size, DIRECTION_WEIGHT * X_AG[:, :3, 2], DIRECTION_WEIGHT * np.abs(X_AG[:, :3, 0])]
    )
    return farthest_points(features, 0, MOST, APART)


def _approaches(pairs: AntipodalPairs, gripper: Gripper) -> tuple[FloatArray, IntArray]:
    """Gripper poses X_AG (g, 4, 4) around the line of each pair, from above first, and the pair (g,) of each."""
    x = pairs.axis
    down = np.where(np.abs(x[:, 2:]) > 0.99, [[-1.0, 0.0, 0.0]], [[0.0, 0.0, -1.0]])
    z0 = down - (down * x).sum(axis=1, keepdims=True) * x
    z0 /= np.linalg.norm(z0, axis=1, keepdims=True)
    y0 = np.cross(z0, x)
    turns = 2.0 * math.pi * np.arange(APPROACHES) / APPROACHES
    z = np.cos(turns)[None, :, None] * z0[:, None] + np.sin(turns)[None, :, None] * y0[:, None]
    depth = 0.5 * gripper.pad_m[1] * np.array(DEPTHS)
    X_AG = np.zeros((len(x), APPROACHES, len(DEPTHS), 4, 4))
    X_AG[..., :3, 0] = x[:, None, None]
    X_AG[..., :3, 1] = np.cross(z, x[:, None])[:, :, None]
    X_AG[..., :3, 2] = z[:, :, None]
    X_AG[..., :3, 3] = pairs.middle_m[:, None, None] - depth[None, None, :, None] * z[:, :, None]
    X_AG[..., 3, 3] = 1.0
    return X_AG.reshape(-1, 4, 4), np.repeat(np.arange(len(x)), APPROACHES * len(DEPTHS))


def _over_ground(X_AB: FloatArray, half: FloatArray, poses: Sequence[StablePose]) -> BoolArray:
    """(g, p) whether all boxes stay above the ground in each pose."""
    if not poses:
        return (lowest(X_AB, half, np.array([0.0, 0.0, 1.0])) >= GROUND_M)[:, None]
    ups = [matrix_of(np.array(p.quat_wxyz))[2] for p in poses]
    offsets = [p.support_offset_m for p in poses]
    return np.stack(
        [lowest(X_AB, half, up) + offset >= GROUND_M for up, offset in zip(ups, offsets, strict=True)], axis=1
    )


def _grasp(
    affordance_id: str,
    X_AG: FloatArray,
    pairs: AntipodalPairs,
    pair: int,
    worth: float,
    over: BoolArray,
    cone_rad: float,
    force_n: float,
    gripper: Gripper,
) -> Grasp:
    w, x, y, z = (round(float(q), DIGITS + 3) + 0.0 for q in quat_of(X_AG[:3, :3]))
    width = float(pairs.width_m[pair])
    return Grasp(
        affordance_id=affordance_id,
        position_m=vec3(np.round(X_AG[:3, 3], DIGITS + 1) + 0.0),
        quat_wxyz=(w, x, y, z),
        contacts_m=(
            vec3(np.round(pairs.first_m[pair], DIGITS + 1) + 0.0),
            vec3(np.round(pairs.second_m[pair], DIGITS + 1) + 0.0),
        ),
        width_m=round(width, DIGITS + 1),
        opening_m=round(float(gripper.open_for(np.array(width))), DIGITS + 1),
        angle_rad=round(float(pairs.angle_rad[pair]), DIGITS),
        cone_rad=round(cone_rad, DIGITS),
        force_n=round(force_n, DIGITS),
        quality=round(float(worth), DIGITS),
        poses=tuple(int(i) for i in np.flatnonzero(over)),
        gripper=gripper.name,
    )
