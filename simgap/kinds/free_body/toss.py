"""A recorded toss with contact geometry: flights, impacts, slides and rest as row ranges, from poses alone.

Velocities are slopes of fits to poses, never the reported rates: what a rate sensor does wrong cannot leak into them.
Stretches of rows that are fitted last shares of the time in which the body falls its own length, whatever the rate of
rows: noise of slopes falls with more rows in equal times. Below, they have the rows that a fit needs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from geom.convex.support_function import facet_directions, surface
from schemas.arrays import BoolArray, FloatArray
from schemas.physics import CollisionShape
from sim.dynamics.hooks import Series
from simgap.kinds.free_body.apply_model import AppliedBody

_TOUCH_SHARE = 0.02  # share of the body's length: a point closer than this to the support may touch it
_PATCH = 0.15  # share of the body's length: a contact within this is one corner
_INSTANTS = 60
_STEADY_COSINE = 0.8  # cosine between the slip at the ends and in the middle of a slide
_LEVEL_RAD = 0.4  # between a facet and the support; more is another facet
_STILL = 0.05  # share of sqrt(g * length): slower is rest
# Shares of the fall time sqrt(length / g), and the fewest rows that they may be: of a flight that is fitted, of any
# flight, of one side of an impact, of a slide. At 150 Hz and 10 cm the shares are as many rows.
_FLIGHT, _SHORTEST_FLIGHT, _IMPACT_SIDE, _SLIDE = (0.4, 7), (0.2, 4), (0.27, 5), (0.4, 7)
_LONGEST_IMPACT, _SHORTEST_REST = 0.3, 0.5  # of the fall time: from touching down to moving up; at the end


@dataclass(frozen=True)
class Motion:
    """Mass centre (3,), its velocity and acceleration, orientation (3, 3), turning rate (3,); axes of the support."""

    p: FloatArray
    v: FloatArray
    acceleration: FloatArray
    R: FloatArray
    w: FloatArray


@dataclass(frozen=True)
class Impact:
    """A corner's or an edge's meeting with the support, axes of the support.

    lever   (3,) from the mass centre to the corner, or to the middle of the edge.
    edge    (3,) unit vector along an edge; None for a corner.
    clear   no other corner came near until the motion after it was read.
    """

    before: Motion
    after: Motion
    lever: FloatArray
    edge: FloatArray | None
    clear: bool


@dataclass(frozen=True)
class Slide:
    """A moment of sliding: friction over normal force, the direction (3,) of the slip in the body, its speed."""

    ratio: float
    direction_B: FloatArray
    speed: float


class Toss:
    """One trial in the axes of the support: z along its normal, 0 at its surface; `com` (n, 3) is the mass centre."""

    def __init__(self, applied: AppliedBody, series: Series) -> None:
        body = applied.body
        self.applied, self.body, self.series, self.t_s = applied, body, series, series.t_s
        self.support_rotation = Rotation.align_vectors([[0.0, 0.0, 1.0]], [body.plane_normal_W])[0]
        R = self.support_rotation * Rotation.from_quat(np.roll(series.columns["quat_wxyz"], -1, axis=1))
        self.R, self.matrices = R, R.as_matrix()
        self.origin = self.support_rotation.apply(series.columns["p"]) - np.array([0.0, 0.0, body.plane_height_m])
        self.com = self.origin + R.apply(body.com_B)
        self.gravity = self.support_rotation.apply(body.gravity_W)
        self.corners = corners(body.shapes) - body.com_B
        self.size = float(np.ptp(self.corners, axis=0).max())

    @cached_property
    def fall_s(self) -> float:
        """See `fall_time_s`."""
        return fall_time_s(self.size, self.gravity, self.t_s, self.com)

    @property
    def flight_rows(self) -> int:
        """Rows of the shortest flight that is fitted."""
        return self.rows_of(*_FLIGHT)

    def rows_of(self, share: float, least: int) -> int:
        """Rows over a share of the fall time, no fewer than `least`."""
        return max(least, round(share * self.fall_s / float(np.median(np.diff(self.t_s)))) + 1)

    @cached_property
    def corner_positions(self) -> FloatArray:
        """(n, m, 3) of every corner."""
        return self.com[:, None] + np.einsum("nij,mj->nmi", self.matrices, self.corners)

    @property
    def heights(self) -> FloatArray:
        """(n, m) of every corner over the support."""
        return self.corner_positions[:, :, 2]

    @cached_property
    def gap(self) -> FloatArray:
        """(n,) of the lowest corner; negative is penetration."""
        return self.heights.min(axis=1)

    @cached_property
    def flights(self) -> list[slice]:
        """Stretches that touch nothing; a bounce between two rows ends one."""
        if not self.body.has_support:
            return [slice(0, len(self.t_s))]
        # By corners: while one leaves the support, another that comes down may be the lowest already.
        height, step = self.heights, np.abs(np.diff(self.heights, axis=0))
        turns = (height[1:-1] <= height[:-2]) & (height[1:-1] <= height[2:])
        touched = turns & (height[1:-1] < 1.5 * np.maximum(step[:-1], step[1:]))
        free = self.gap > _TOUCH_SHARE * self.size
        free[1:-1] &= ~touched.any(axis=1)
        return _stretches(free, self.rows_of(*_SHORTEST_FLIGHT))

    @cached_property
    def impacts(self) -> list[Impact]:
        """The ends of flights at which one corner or one edge meets the support."""
        return [i for f in self.flights if (i := self._impact(f)) is not None]

    @cached_property
    def slides(self) -> list[Slide]:
        """Moments in steady contact with slip well over the noise."""
        if not self.body.has_support:
            return []
        touching = np.abs(self.gap) < 2.0 * _TOUCH_SHARE * self.size
        slide_stretches, length = [], self.rows_of(*_SLIDE)
        for part in _stretches(touching, length):
            for first in range(part.start, part.stop - length + 1, length // 2):
                slide = self._slide(slice(first, first + length))
                slide_stretches += [slide] if slide is not None else []
        return slide_stretches

    @property
    def least_slip(self) -> float:
        """m/s: slower is rest."""
        return _STILL * float(np.sqrt(np.linalg.norm(self.gravity) * self.size))

    @cached_property
    def rest(self) -> slice | None:
        """The last rows, when nothing moves in them and the body is at the support."""
        moving = np.flatnonzero(
            np.linalg.norm(self.corner_positions - self.corner_positions[-1], axis=2).max(axis=1) > 0.005 * self.size
        )
        first = int(moving[-1]) + 1 if len(moving) else 0
        long = self.t_s[-1] - self.t_s[min(first, len(self.t_s) - 1)] > _SHORTEST_REST * self.fall_s
        return slice(first, len(self.t_s)) if long and self.body.has_support else None

    def motion(self, rows: slice, at_s: float, falling: bool) -> Motion:
        """The motion over `rows`, carried to `at_s`: in free fall, or under an unknown steady force and torque."""
        t = self.t_s[rows] - self.t_s[rows].mean()
        when = at_s - self.t_s[rows].mean()
        known = self.gravity if falling else np.zeros(3)
        order = 1 if falling else 2
        fit = np.linalg.pinv(np.stack([t**k for k in range(order + 1)], axis=1))
        c = fit @ (self.com[rows] - 0.5 * t[:, None] ** 2 * known)
        middle = self.R[rows.start + len(t) // 2]
        turn = fit @ (self.R[rows] * middle.inv()).as_rotvec()
        acceleration = known if falling else 2.0 * c[2]
        return Motion(
            p=c[0] + c[1] * when + 0.5 * acceleration * when**2,
            v=c[1] + acceleration * when,
            acceleration=acceleration,
            R=(Rotation.from_rotvec(when ** np.arange(order + 1) @ turn) * middle).as_matrix(),
            w=turn[1] + (0.0 if falling else 2.0 * when * turn[2]),
        )

    def _impact(self, flight: slice) -> Impact | None:
        """The impact at the end of a flight, if a corner or an edge meets the support and rises before another does."""
        side, last, step_s = self.rows_of(*_IMPACT_SIDE), flight.stop - 1, float(np.median(np.diff(self.t_s)))
        before = slice(max(flight.start, flight.stop - side), flight.stop)
        after_touch = np.flatnonzero(self.t_s > self.t_s[last])
        soon = after_touch[self.t_s[after_touch] < self.t_s[last] + max(_LONGEST_IMPACT * self.fall_s, 1.5 * step_s)]
        if not len(soon) or not self.body.has_support:
            return None
        lowest = int(soon[np.argmin(self.gap[soon])])
        after = slice(lowest + 1, lowest + 1 + side)
        if after.stop > len(self.t_s):
            return None
        touch_s = self._touch(self.motion(before, float(self.t_s[last]), True), last, lowest)
        landing = self.motion(before, touch_s, True)
        leaving = self.motion(after, touch_s, False)
        reach = landing.R @ self.corners.T
        near = reach[2] < reach[2].min() + 0.5 * _PATCH * self.size
        edge, narrow = _line(reach[:, near].T, _PATCH * self.size)
        if not narrow:
            return None
        others = self.heights[before.stop : after.stop][:, ~near]
        return Impact(
            before=landing,
            after=leaving,
            lever=reach[:, near].mean(axis=1),
            edge=edge,
            clear=bool((others > _TOUCH_SHARE * self.size).all()),
        )

    def _touch(self, falling: Motion, last: int, lowest: int) -> float:
        """When the lowest corner of a body that keeps falling after row `last` reaches the support, s."""
        since = np.linspace(0.0, self.t_s[lowest + 1] - self.t_s[last], _INSTANTS)
        R = Rotation.from_rotvec(since[:, None] * falling.w).as_matrix() @ falling.R
        height = falling.p[2] + since * falling.v[2] + 0.5 * since**2 * self.gravity[2]
        gap = height + (R[:, 2, :] @ self.corners.T).min(axis=1)
        below = np.flatnonzero(gap <= 0.0)
        return float(self.t_s[last] + since[below[0] if len(below) else np.argmin(gap)])

    def _slide(self, rows: slice) -> Slide | None:
        at = (rows.start + rows.stop) // 2
        motion = self.motion(rows, float(self.t_s[at]), False)
        slip, speed, spread = self._slip(motion, at)
        force = motion.acceleration - self.gravity
        weight = float(np.linalg.norm(self.gravity))
        if speed < self.least_slip or spread > 0.5 * speed or not 0.3 < force[2] / weight < 3.0:
            return None
        for end in (rows.start, rows.stop - 1):
            # What sticks on the way carries less than friction could.
            there, fast, _ = self._slip(self.motion(rows, float(self.t_s[end]), False), end)
            if fast < self.least_slip or float(there @ slip) < _STEADY_COSINE * fast * speed:
                return None
        along = np.array([*(slip / speed), 0.0])
        return Slide(-float(force @ along) / float(force[2]), self.matrices[at].T @ along, speed)

    def _slip(self, motion: Motion, row: int) -> tuple[FloatArray, float, float]:
        """Velocity (2,) of the lowest corners along the support, its size, and how much it differs between them."""
        reach = self.matrices[row] @ self.corners.T
        near = reach[2] < reach[2].min() + 0.5 * _TOUCH_SHARE * self.size
        middle: FloatArray = reach[:, near].mean(axis=1)
        slip = (motion.v + np.cross(motion.w, middle))[:2]
        spread = float(np.linalg.norm(motion.w)) * float(np.ptp(reach[:, near], axis=1).max())
        return slip, float(np.linalg.norm(slip)), spread


def _line(points: FloatArray, width: float) -> tuple[FloatArray | None, bool]:
    """Direction (3,) of points (n, 3) on a line, None if they are one spot; and whether no two are further off it."""
    if np.ptp(points, axis=0).max() <= width:
        return None, True
    across = points - points.mean(axis=0)
    along = np.linalg.svd(across)[2][0]
    return along, bool(np.linalg.norm(across - np.outer(across @ along, along), axis=1).max() <= 0.5 * width)


def resting_facet(toss: Toss) -> FloatArray | None:
    """Outward normal (3,) in the body of the facet that lies on the support at rest; None when none is near level."""
    if toss.rest is None:
        return None
    facets = facet_directions(toss.body.shapes)
    down = -toss.matrices[toss.rest][:, 2, :].mean(axis=0)
    if not len(facets) or (facets @ down).max() < np.cos(_LEVEL_RAD):
        return None
    return facets[int(np.argmax(facets @ down))]


def fall_time_s(size_m: float, gravity: FloatArray, t_s: FloatArray, p: FloatArray) -> float:
    """Time in which a body falls about its own length; without gravity, in which it moves as far."""
    pull = float(np.linalg.norm(gravity))
    if pull > 0.0:
        return float(np.sqrt(size_m / pull))
    moved = float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum())
    return float(t_s[-1] - t_s[0]) * min(1.0, size_m / max(moved, 1e-300))


def corners(shapes: Sequence[CollisionShape]) -> FloatArray:
    """Points (m, 3) that bound the shapes; curved ones as fine polyhedra."""
    return np.concatenate([surface(shape)[0] for shape in shapes])


def _stretches(mask: BoolArray, least: int) -> list[slice]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return [slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= least]
