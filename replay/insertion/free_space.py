"""Free space over a support: its area less that of the envelope and of static obstacles at the heights of an object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely.geometry import MultiPoint, Polygon
from shapely.geometry.base import BaseGeometry

from geom.convex.circumscribed_hull import circumscribed_hull
from geom.pose import apply
from replay.envelope.envelope import Envelope
from replay.envelope.trajectory import as_robot
from replay.insertion.supports import Support
from replay.recording.episode import Episode
from replay.recording.kinematics import link_poses, moving_links
from schemas.arrays import BoolArray, FloatArray

SLICE_M = 0.02  # the envelope is cut into slices this thick, each projected once
_MERGED = 1.0 + 1e-5  # GEOS merges corners of an outline that are nearer than a millionth of its distance
_QUARTER_SEGMENTS = 6  # corners of a quarter circle at the ends of capsules
_CIRCUMSCRIBED = _MERGED / np.cos(np.pi / (4 * _QUARTER_SEGMENTS))  # so that the polygon lies around the circle
_CORNER_SEGMENTS = 16  # the same at the corners of outlines, where GEOS may turn by a step and a half at once
_CIRCUMSCRIBED_CORNER = _MERGED / np.cos(1.5 * np.pi / (4 * _CORNER_SEGMENTS))
_RESTING_M = 1e-3  # a piece that rises this little over a support is no obstacle on it


@dataclass(frozen=True)
class Obstacle:
    """A convex piece of something that never moves: outline in x and y of W, and its heights."""

    name: str
    outline: BaseGeometry
    low_m: float
    high_m: float


def obstacles(episode: Episode) -> tuple[Obstacle, ...]:
    """Fixtures, and links and objects that never move."""
    still_bodies = [
        _obstacle(name, apply(fixture.X_WB, circumscribed_hull(shape)))
        for fixture in episode.fixtures
        for name, shape in zip(fixture.shape_names, fixture.shapes, strict=True)
    ]
    for robot in [*episode.robots, *map(as_robot, episode.objects)]:
        poses, moving = link_poses(robot, robot.q[:1], robot.X_WR[:1])[0], moving_links(robot)
        still = [number for number in range(len(robot.links)) if number not in moving]
        still_bodies += [
            _obstacle(robot.links[number].name, apply(poses[number], circumscribed_hull(shape)))
            for number in still
            for shape in robot.links[number].shapes
        ]
    return tuple(still_bodies)


def _obstacle(name: str, corners_W: FloatArray) -> Obstacle:
    heights = corners_W[:, 2]
    return Obstacle(name, MultiPoint(corners_W[:, :2]).convex_hull, float(heights.min()), float(heights.max()))


@dataclass
class FreeSpace:
    """Free space over one support. Slices of the envelope are projected at first use."""

    support: Support
    envelope: Envelope
    obstacles: Sequence[Obstacle]
    _slices: dict[int, BaseGeometry] = field(default_factory=dict)
    _free: dict[int, BaseGeometry] = field(default_factory=dict)

    def free(self, top_m: float) -> BaseGeometry:
        """The part of the support over which nothing is at heights up to `top_m`, with the clearance."""
        count = max(1, int(np.ceil(top_m / SLICE_M - 1e-9)))
        if count not in self._free:
            low = self.support.height_m
            high = low + count * SLICE_M
            near = [self._slice(number) for number in range(count)]
            near += [
                buffered(thing.outline, self.envelope.clearance_m)
                for thing in self.obstacles
                if thing.high_m > low + _RESTING_M and thing.low_m < high + self.envelope.clearance_m
            ]
            self._free[count] = self.support.area.difference(shapely.union_all(near))
        return self._free[count]

    def blocked_by(self, top_m: float) -> dict[str, float]:
        """Share of the support that each body's sweep takes at heights up to `top_m`, largest first."""
        low = self.support.height_m
        shares = {}
        for number, name in enumerate(self.envelope.bodies):
            projection = _projection(self.envelope, self.envelope.body == number, low, low + top_m)
            share = projection.intersection(self.support.area).area / self.support.area.area
            if share > 0.0:
                shares[name] = float(share)
        return dict(sorted(shares.items(), key=lambda item: -item[1]))

    def _slice(self, number: int) -> BaseGeometry:
        if number not in self._slices:
            low = self.support.height_m + number * SLICE_M
            everything = np.ones(len(self.envelope.body), dtype=bool)
            projection = _projection(self.envelope, everything, low, low + SLICE_M)
            self._slices[number] = shapely.intersection(projection, self.support.area.envelope)
        return self._slices[number]


def buffered(outline: BaseGeometry, by_m: float) -> BaseGeometry:
    """`outline` and all within `by_m` of it, and a little more."""
    return outline.buffer(by_m * _CIRCUMSCRIBED_CORNER, quad_segs=_CORNER_SEGMENTS)


def _projection(envelope: Envelope, is_included: BoolArray, low_m: float, high_m: float) -> BaseGeometry:
    """Projection to x and y of the capsules between the heights `low_m` and `high_m`, or more; never less.

    The part of a segment within its radius of the slab, as wide as the ball is where the segment comes nearest to it.
    """
    radius = envelope.radius_m
    start, end = envelope.start_W, envelope.end_W
    reaches = is_included & (np.minimum(start[:, 2], end[:, 2]) - radius < high_m)
    reaches &= np.maximum(start[:, 2], end[:, 2]) + radius > low_m
    start, end, radius = start[reaches], end[reaches], radius[reaches]
    if not len(radius):
        return Polygon()
    rise = end[:, 2] - start[:, 2]
    steep = np.abs(rise) > 1e-12
    slope = np.where(steep, rise, 1.0)
    bounds = np.sort(np.stack([low_m - radius - start[:, 2], high_m + radius - start[:, 2]]) / slope, axis=0)
    first = np.where(steep, np.clip(bounds[0], 0.0, 1.0), 0.0)[:, None]
    last = np.where(steep, np.clip(bounds[1], 0.0, 1.0), 1.0)[:, None]
    part = np.stack([start + first * (end - start), start + last * (end - start)], axis=1)
    apart = np.maximum(np.maximum(low_m - part[:, :, 2].max(axis=1), part[:, :, 2].min(axis=1) - high_m), 0.0)
    width = np.sqrt(np.maximum(radius**2 - apart**2, 0.0)) * _CIRCUMSCRIBED
    return shapely.union_all(shapely.buffer(shapely.linestrings(part[:, :, :2]), width, quad_segs=_QUARTER_SEGMENTS))
