"""Stable poses of a body with probabilities, by drop-settle trials in a simulator (Goldberg et al. 1999, "Part pose
statistics": probabilities need dynamics).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geom.convex.support_function import centre_heights, diagonal, facet_directions, stability_margin, support
from geom.mass.principal_axes import principal_axes
from geom.pose import DOWN, matrix_of, pose, quat_of, shortest_rotation
from schemas.acceptance import StablePose
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.physics import RigidBody
from sim.port import DropResult, DropSettings, Simulator, natural_time_s, stillness_for, world_for

TRIALS = 32
LEAN_RAD = math.radians(2.0)
_SAME_POSE_RAD = math.radians(5.0)
_SAME_POSE_BARRIER = 0.06  # of the height of the mass centre: a prism of ten sides or more rolls, a cube does not
_SNAP_RAD = math.radians(2.0)
_STEPS = np.linspace(0.0, 1.0, 17)


@dataclass(frozen=True)
class StablePoses:
    """The stable poses, most probable first, and counts of the trials.

    at_rest   trials that came to rest; the others rolled, rocked or diverged until the end.
    refuted   poses that trials ended in but that do not hold or not recover from leaning; they are left out.
    """

    poses: tuple[StablePose, ...]
    trials: int
    at_rest: int
    refuted: int


def find_stable_poses(body: RigidBody, simulator: Simulator, *, trials: int = TRIALS) -> StablePoses:
    """Drop `body` in `trials` orientations and collect the poses in which it comes to rest.

    The first one is the reference pose, which matters to scenes however unlikely it is; the others are evenly spread.
    Orientations are compared modulo yaw, by the direction that faces down in the asset frame. Two are one pose when
    they lie within 5 degrees, or when the mass centre stays level within 6 % of its height on the way from one to the
    other: so a can on its side is one pose, however it rolled. A pose's probability is its share of all trials; its
    orientation carries no yaw (the least rotation that brings its down direction down), its support offset follows
    from the exact collision shapes. Each pose is tried once more: the body must stay in it and come back to it when
    set down leaning, see `holds` and `recovers`.
    """
    size = diagonal(body.shapes)
    world, still = world_for(size), stillness_for(size)
    settings = DropSettings(48.0 * natural_time_s(size), world, still)
    results = simulator.drop_many(body, trial_starts(body, trials), settings)
    settled = [r for r in results if r.still_since_s(still) is not None and r.heights_m[-1] < 0.01 * size]
    if not settled:
        return StablePoses((), trials, 0, 0)
    downs = _snapped(body, np.stack([-matrix_of(r.quats_wxyz[-1])[2] for r in settled]))
    levels = centre_heights(body.shapes, np.asarray(body.mass.centre_of_mass_m), downs)
    families = pose_families(body, downs)
    poses, refuted = [], 0
    for family in range(int(families.max()) + 1):
        members = np.flatnonzero(families == family)
        best = members[np.argmin(np.round(levels[members] / size, 6))]  # the lowest; of equals, the earliest trial
        if not (holds(body, simulator, downs[best]) and recovers(body, simulator, downs[best])):
            refuted += 1
            continue
        X_WA = resting_pose(body, downs[best], gap_m=0.0)
        w, x, y, z = (float(q) + 0.0 for q in quat_of(X_WA[:3, :3]))  # no negative zeros
        share = len(members) / trials
        poses.append(StablePose(quat_wxyz=(w, x, y, z), support_offset_m=float(X_WA[2, 3]) + 0.0, probability=share))
    poses.sort(key=lambda p: (-p.probability, p.support_offset_m, p.quat_wxyz))
    return StablePoses(tuple(poses), trials, len(downs), refuted)


def trial_starts(body: RigidBody, trials: int = TRIALS) -> list[FloatArray]:
    """X_WA (4, 4) of each trial: 1 % of the size above the ground, the reference orientation first."""
    directions = np.concatenate([DOWN[None], spread_directions(trials - 1)])
    return [resting_pose(body, down_A, gap_m=0.01 * diagonal(body.shapes)) for down_A in directions]


def resting_pose(body: RigidBody, down_A: FloatArray, *, gap_m: float) -> FloatArray:
    """X_WA (4, 4) without yaw: the unit direction `down_A` (3,) faces down, the lowest point is at z = `gap_m`."""
    offset = float(support(body.shapes, down_A[None])[0])
    return pose(shortest_rotation(down_A, DOWN), (0.0, 0.0, offset + gap_m))


def holds(body: RigidBody, simulator: Simulator, down_A: FloatArray) -> bool:
    """Whether the body, placed at rest with `down_A` facing down, stays for a second (three natural times if longer).

    Staying means: it moves by less than 2 mm, or half a percent of its size if that is more (5 % of the size at most),
    and its down direction by less than 2 degrees.
    """
    size = diagonal(body.shapes)
    settings = DropSettings(max(1.0, 3.0 * natural_time_s(size)), world_for(size))
    result = simulator.drop(body, resting_pose(body, down_A, gap_m=0.0), settings)
    moved, tilted = displacement(result)
    allowed_m = min(max(0.002, 0.005 * size), 0.05 * size)
    return result.finite and moved < allowed_m and tilted < math.radians(2.0)


def recovers(body: RigidBody, simulator: Simulator, down_A: FloatArray) -> bool:
    """Whether the body, set down leaning by 2 degrees to its weakest side or away from it, ends within 5 degrees.

    A body that balances on a point or an edge, held by rolling resistance alone, falls to both sides; so does one on
    too narrow a foot. One side is enough: the mass centre of a figure may be close to the edge of its foot.
    """
    size = diagonal(body.shapes)
    settings = DropSettings(max(1.0, 8.0 * natural_time_s(size)), world_for(size), stillness_for(size))
    _, tipped = stability_margin(body.shapes, np.asarray(body.mass.centre_of_mass_m), down_A)
    side = tipped - (tipped @ down_A) * down_A
    for lean_rad in (LEAN_RAD, -LEAN_RAD):
        start = math.cos(lean_rad) * down_A + math.sin(lean_rad) * side / np.linalg.norm(side)
        result = simulator.drop(body, resting_pose(body, start, gap_m=0.0), settings)
        end_A = -matrix_of(result.quats_wxyz[-1])[2]
        if result.finite and end_A @ down_A > math.cos(_SAME_POSE_RAD):
            return True
    return False


def leaning(down_A: FloatArray, lean_rad: float) -> FloatArray:
    """The direction (3,) that faces down when a body with `down_A` facing down leans, oblique to its axes."""
    tipped = np.array([0.8 * math.sin(lean_rad), 0.6 * math.sin(lean_rad), -math.cos(lean_rad)])
    return shortest_rotation(DOWN, down_A) @ tipped


def displacement(result: DropResult) -> tuple[float, float]:
    """How far (m) the origin is from its start at the end, and by how much (rad) the down direction has turned."""
    first, last = (matrix_of(result.quats_wxyz[i])[2] for i in (0, -1))
    moved = float(np.linalg.norm(result.positions_m[-1] - result.positions_m[0]))
    return moved, float(np.arccos(np.clip(first @ last, -1.0, 1.0)))


def spread_directions(count: int) -> FloatArray:
    """`count` unit vectors (count, 3) spread evenly over the sphere, a Fibonacci lattice (Swinbank and Purser 2006)."""
    index = np.arange(count) + 0.5
    z = 1.0 - 2.0 * index / count
    azimuth = index * np.pi * (3.0 - np.sqrt(5.0))
    radius = np.sqrt(1.0 - z**2)
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z], axis=1)


def pose_families(body: RigidBody, downs: FloatArray) -> IntArray:
    """Labels (k,) of the poses that down directions (k, 3) belong to, see `find_stable_poses`: single linkage."""
    count = len(downs)
    first, second = np.triu_indices(count, 1)
    linked = _same_pose(body, downs[first], downs[second])
    graph = coo_array((np.ones(int(linked.sum())), (first[linked], second[linked])), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def _snapped(body: RigidBody, downs: FloatArray) -> FloatArray:
    """The directions (k, 3), each moved to a facet of the convex hull within 2 degrees if the mass centre gets lower.

    It removes the residual tilt due to the contact tolerance of the engine.
    """
    facets = facet_directions(body.shapes)
    if not len(facets):
        return downs
    centre, slack = np.asarray(body.mass.centre_of_mass_m), 1e-6 * diagonal(body.shapes)
    nearest = facets[np.argmax(downs @ facets.T, axis=1)]
    close = np.einsum("ki,ki->k", nearest, downs) > math.cos(_SNAP_RAD)
    lower = centre_heights(body.shapes, centre, nearest) <= centre_heights(body.shapes, centre, downs) + slack
    return np.where((close & lower)[:, None], nearest, downs)


def _same_pose(body: RigidBody, first: FloatArray, second: FloatArray) -> BoolArray:
    """Whether (k,) the down directions `first` and `second` (k, 3) are one pose.

    Tried are the great circle between them and, for bodies that roll like a cone, the turns about each principal axis
    of inertia to which both are inclined alike, either way round.
    """
    angles = np.arccos(np.clip(np.einsum("ki,ki->k", first, second), -1.0, 1.0))
    same = (angles < _SAME_POSE_RAD) | _stays_level(body, _great_circles(first, second))
    for axis in matrix_of(principal_axes(body.mass.inertia_kgm2)[1]).T:
        polar, other = (np.arccos(np.clip(downs @ axis, -1.0, 1.0)) for downs in (first, second))
        alike = ~same & (np.abs(polar - other) < _SAME_POSE_RAD)
        for path in _turns_about(axis, first[alike], second[alike]):
            same[alike] |= _stays_level(body, path)
    return same


def _stays_level(body: RigidBody, paths: FloatArray) -> FloatArray:
    """Whether (k,) along a path of down directions (k, n, 3) the height of the mass centre stays within 6 % of that at
    the lower end. A path that dips leads through another pose.
    """
    flat = centre_heights(body.shapes, np.asarray(body.mass.centre_of_mass_m), paths.reshape(-1, 3))
    levels = flat.reshape(paths.shape[:2])
    lower = np.minimum(levels[:, 0], levels[:, -1])
    return np.abs(levels - lower[:, None]).max(axis=1) < _SAME_POSE_BARRIER * lower


def _great_circles(first: FloatArray, second: FloatArray) -> FloatArray:
    """Unit vectors (k, 17, 3) in even steps from `first` to `second` (k, 3); opposite ones are joined in any plane."""
    cosines = np.clip(np.einsum("ki,ki->k", first, second), -1.0, 1.0)[:, None]
    side = second - cosines * first
    arbitrary = np.cross(first, np.eye(3)[np.abs(first).argmin(axis=1)])
    side = np.where(np.linalg.norm(side, axis=1)[:, None] < 1e-6, arbitrary, side)
    side /= np.linalg.norm(side, axis=1)[:, None]
    turns = (np.arccos(cosines) * _STEPS)[:, :, None]
    return np.cos(turns) * first[:, None] + np.sin(turns) * side[:, None]


def _turns_about(axis: FloatArray, first: FloatArray, second: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit vectors (k, 17, 3) from `first` to `second` (k, 3), turning about the unit vector `axis` (3,) either way."""
    across = shortest_rotation(np.array([0.0, 0.0, 1.0]), axis)[:, :2]
    start, end = first @ across, second @ across
    azimuths = np.arctan2(start[:, 1], start[:, 0])[:, None]
    turn = np.arctan2(end[:, 1], end[:, 0])[:, None] - azimuths
    heights = first @ axis
    heights = heights[:, None] + (second @ axis - heights)[:, None] * _STEPS
    radii = np.sqrt(np.maximum(1.0 - heights**2, 0.0))

    def path(turn: FloatArray) -> FloatArray:
        angles = azimuths + turn * _STEPS
        plane = np.stack([np.cos(angles), np.sin(angles)], axis=2) @ across.T
        return heights[:, :, None] * axis + radii[:, :, None] * plane

    return path(turn), path(turn - 2.0 * np.pi * np.where(turn > 0.0, 1.0, -1.0))
