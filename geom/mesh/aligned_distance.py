"""How far two surfaces lie from each other after the best proper rotation and uniform scale, relative to their size.

Starts are the principal axes with their sign ambiguities, with turns where moments are too close to give axes; the best
are refined by ICP with damped point-to-plane steps (Chen and Medioni 1992).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from geom.mesh.surface_distance import P95, NearestOnSurface, sample_surface, triangle_areas
from schemas.arrays import FloatArray, IntArray

# Principal moments (of sum 1) closer than this give no axes: an error of 0.002 in them, that of a lightly decimated
# copy, then turns the axes by more than 4 degrees.
DEGENERATE_GAP = 0.03
TURN_STEPS = 24  # About an axis of revolution: 15 degrees, within the reach of ICP.
FREE_TURNS = 600  # Over all rotations: the next start is at most about 30 degrees away.
# A cube with one letter has 24 poses that fit nearly; so many starts, the best by distance, are refined coarsely that
# each pose has several, and the best of these finely.
COARSE_STARTS, FINE_STARTS = 150, 4
COARSE_SAMPLES, FINE_SAMPLES, FINAL_SAMPLES = 200, 1000, 4000
COARSE_STEPS, FINE_STEPS = 6, 25
_DAMPING = 1e-4  # Of the mean eigenvalue: motions along which the surface slides in itself get no step from rounding.
_STILL = 1e-7  # In units of the rms radius: a step below it changes nothing that is measured.


@dataclass(frozen=True)
class AlignedDistance:
    """Distances of samples both ways, as shares of the diagonal of the first surface's bounding box.

    scale_ratio  size of the second surface over that of the first (root mean square distances from the centroid).
    R_BA         (3, 3) rotation from the axes of the first surface to those of the second.
    """

    scale_ratio: float
    R_BA: FloatArray
    mean_share: float
    p95_share: float
    max_share: float


@dataclass(frozen=True)
class _UnitSurface:
    """A surface about its area centroid, with root mean square distance 1; `axes` has the principal ones as columns."""

    points: FloatArray
    triangles: IntArray
    scale: float
    moments: FloatArray
    axes: FloatArray


def aligned_distance(
    points_a: FloatArray, triangles_a: IntArray, points_b: FloatArray, triangles_b: IntArray, seed: int = 0
) -> AlignedDistance:
    """The distance of surfaces A and B (points (n, 3), triangles (m, 3)) as well aligned as was found.

    Mirror images are not aligned with each other. Deterministic. Raises ValueError when a surface has no area.
    """
    a, b = _unit_surface(points_a, triangles_a), _unit_surface(points_b, triangles_b)
    target = NearestOnSurface(b.points, b.triangles)
    coarse, _ = sample_surface(a.points, a.triangles, COARSE_SAMPLES, seed)
    starts = np.array([b.axes @ Q @ a.axes.T for Q in _turns(0.5 * (a.moments + b.moments))])
    normals = _normals(b)
    near = np.argsort(_mean_distances(_placed(coarse, starts, np.zeros((len(starts), 3))), target), kind="stable")
    fits = _icp(coarse, starts[near[:COARSE_STARTS]], target, normals, COARSE_STEPS)
    fine, _ = sample_surface(a.points, a.triangles, FINE_SAMPLES, seed)
    best = np.argsort(fits[2], kind="stable")[:FINE_STARTS]
    turns, shifts, means = _icp(fine, fits[0][best], target, normals, FINE_STEPS, fits[1][best])
    R, t = turns[means.argmin()], shifts[means.argmin()]
    there, _ = sample_surface(a.points, a.triangles, FINAL_SAMPLES, seed)
    back, _ = sample_surface(b.points, b.triangles, FINAL_SAMPLES, seed)
    there, back = there @ R.T + t, (back - t) @ R
    ways = [
        np.linalg.norm(target(there)[0] - there, axis=1),
        np.linalg.norm(NearestOnSurface(a.points, a.triangles)(back)[0] - back, axis=1),
    ]
    diagonal = float(np.linalg.norm(np.ptp(a.points[np.unique(a.triangles)], axis=0)))
    mean = max(float(way.mean()) for way in ways)
    p95 = max(float(np.percentile(way, P95)) for way in ways)
    largest = max(float(way.max()) for way in ways)
    return AlignedDistance(b.scale / a.scale, R, mean / diagonal, p95 / diagonal, largest / diagonal)


def _unit_surface(points: FloatArray, triangles: IntArray) -> _UnitSurface:
    """Second moments of triangles: A/12 (a aT + b bT + c cT + s sT), s = a + b + c (Blow and Binstock 2004)."""
    areas = triangle_areas(points[triangles])
    weights = areas / areas.sum() if areas.sum() > 0.0 else areas
    centre = weights @ points[triangles].mean(axis=1)
    corners = points[triangles] - centre
    vectors = (*np.moveaxis(corners, 1, 0), corners.sum(axis=1))
    second: FloatArray = np.einsum("i,vij,vik->jk", weights, np.stack(vectors), np.stack(vectors)) / 12.0
    scale = float(np.linalg.norm(np.sqrt(np.diag(second))))
    if not scale > 0.0:
        raise ValueError("the surface has no area to align")
    moments, axes = np.linalg.eigh(second / scale**2)
    moments, axes = moments[::-1], axes[:, ::-1].copy()  # Largest first.
    if np.linalg.det(axes) < 0.0:
        axes[:, 2] *= -1.0
    return _UnitSurface((points - centre) / scale, triangles, scale, moments, axes)


def _turns(moments: FloatArray) -> FloatArray:
    """(k, 3, 3) rotations of the principal frame that may map one surface on the other; `moments` (3,) descending."""
    near = np.diff(-moments) < DEGENERATE_GAP
    if near.all():
        return _even_rotations(FREE_TURNS)
    flips = [np.diag(d) for d in ((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0))]
    if not near.any():
        return np.array(flips)
    axis = np.eye(3)[0 if near[1] else 2]
    angles = np.arange(TURN_STEPS) * 2.0 * np.pi / TURN_STEPS
    about = Rotation.from_rotvec(angles[:, None] * axis).as_matrix()
    over = flips[3] if near[1] else flips[1]  # The half turn that reverses the axis.
    return np.concatenate([about, about @ over])


def _even_rotations(count: int) -> FloatArray:
    """(count, 3, 3) rotations spread evenly (Alexa 2022, "Super-Fibonacci spirals")."""
    phi, psi = np.sqrt(2.0), 1.533751168755204288118041
    s = np.arange(count) + 0.5
    r, R = np.sqrt(s / count), np.sqrt(1.0 - s / count)
    alpha, beta = 2.0 * np.pi * s / phi, 2.0 * np.pi * s / psi
    quat_xyzw = np.stack([r * np.sin(alpha), r * np.cos(alpha), R * np.sin(beta), R * np.cos(beta)], axis=1)
    return Rotation.from_quat(quat_xyzw).as_matrix()


def _normals(surface: _UnitSurface) -> FloatArray:
    """(m, 3) unit normals of the triangles; zero where a triangle has no area."""
    a, b, c = np.moveaxis(surface.points[surface.triangles], 1, 0)
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)


def _placed(samples: FloatArray, turns: FloatArray, shifts: FloatArray) -> FloatArray:
    """(k, s, 3) the samples (s, 3) at each of the poses (k, 3, 3), (k, 3)."""
    return np.einsum("kij,sj->ksi", turns, samples) + shifts[:, None]


def _mean_distances(placed: FloatArray, target: NearestOnSurface) -> FloatArray:
    """(k,) mean distances of placed samples (k, s, 3)."""
    nearest = target(placed.reshape(-1, 3))[0].reshape(placed.shape)
    return np.linalg.norm(placed - nearest, axis=2).mean(axis=1)


def _icp(
    samples: FloatArray,
    turns: FloatArray,
    target: NearestOnSurface,
    normals: FloatArray,
    steps: int,
    start_shifts: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rotations (k, 3, 3), translations (k, 3) and mean distances (k,) of the samples (s, 3) after some steps from each
    of the poses; never worse than those.
    """
    shifts: FloatArray = np.zeros((len(turns), 3)) if start_shifts is None else start_shifts
    best_turns, best_shifts, best = turns.copy(), shifts.copy(), np.full(len(turns), np.inf)
    for _ in range(steps):
        placed = _placed(samples, turns, shifts)
        nearest, index = target(placed.reshape(-1, 3))
        off = placed - nearest.reshape(placed.shape)
        means = np.linalg.norm(off, axis=2).mean(axis=1)
        better = means < best
        best[better], best_turns[better], best_shifts[better] = means[better], turns[better], shifts[better]
        step = _damped_step(placed, off, normals[index].reshape(placed.shape))
        if np.abs(step).max() < _STILL:
            break
        turn: FloatArray = Rotation.from_rotvec(step[:, :3]).as_matrix()
        shifts = np.einsum("kij,kj->ki", turn, shifts) + step[:, 3:]
        turns = turn @ turns
    return best_turns, best_shifts, best


def _damped_step(placed: FloatArray, off: FloatArray, n: FloatArray) -> FloatArray:
    """(k, 6) rotation vectors and translations that bring placed samples (k, s, 3) nearest to the planes with normals
    `n` through the points `placed - off`: Gauss-Newton with Levenberg's damping.
    """
    jacobian = np.concatenate([np.cross(placed, n), n], axis=2)
    gradient = np.einsum("ksj,ksi,ksi->kj", jacobian, off, n)
    hessian = np.einsum("ksi,ksj->kij", jacobian, jacobian)
    damping = _DAMPING / 6.0 * np.einsum("kii->k", hessian)
    damped: FloatArray = hessian + damping[:, None, None] * np.eye(6)
    inverse: FloatArray = np.asarray(np.linalg.inv(damped), dtype=np.float64)
    return -np.einsum("kij,kj->ki", inverse, gradient)
