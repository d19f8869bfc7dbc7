"""Candidate up directions of an object and geometric features of each, independent of its category.

The features follow Fu et al. 2008, "Upright orientation of man-made objects": static stability, roundness and flatness
about the direction; and the water that stays in the object, or the space between its legs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from geom.convex.hull import centroid, convex_hull, volume
from geom.convex.primitive_fits import fit_box
from geom.features.heightfield import fill_depressions, heightfield
from geom.features.resting_planes import resting_planes
from geom.mesh.rays import Rays
from geom.mesh.surface_distance import sample_surface
from geom.pose import rotation_to_z
from schemas.arrays import FloatArray
from schemas.physics import Solid

SAME_RAD = np.radians(4.0)  # Directions closer than this are one; the coordinate axes come first.
MAX_FACETS = 8
FOOT_SHARE = 0.03  # of the height: points this low touch the ground, since the bottom of a scan is uneven
END_SHARE = 0.15  # of the height: the top and the bottom of an object
UPRIGHT_SAMPLES = 20_000  # enough that thin walls, which rays may miss, appear in every cell of the heightfield
FALLS_RAD = np.radians(-3.0)  # An object that falls by itself is not upright; one that rolls may be.
PROFILE = (8, 5)
ALIKE_SHARE = 0.2  # of the surface, half of the area that must move; sampling alone makes 0.05


@dataclass(frozen=True)
class UprightFeatures:
    """Features of an object with the unit vector `up` (3,) of its own frame upward; all but `tip_rad` have no unit.

    tip_rad   tilt at which it falls over, on the outline of its lowest 3 %; negative: it falls by itself.
    water     volume of water that stays in it, as a share of its convex hull.
    under     volume below it, open to the sides, as a share of its convex hull: between legs.
    flat      logarithm of its width (edge of the square of the same area seen from above) over its height.
    round     roundness of its outline from above: 1 a circle, 0.79 a square (isoperimetric quotient of the outline).
    profile   (8, 5) share of the surface by height and by distance from the upright axis; sums to 1.
    top, bottom   area of its uppermost and lowest 15 %, as a share of the area seen from above.
    """

    up: FloatArray
    tip_rad: float
    water: float
    under: float
    flat: float
    round: float
    top: float
    bottom: float
    profile: FloatArray


def upright_features(solid: Solid) -> tuple[UprightFeatures, ...]:
    """Features for each candidate up direction, +z first; () for a solid that spans no volume.

    Directions in which the object falls by itself are left out, except +z.
    """
    try:
        hull = convex_hull(solid.points)
    except ValueError:
        return ()
    samples, _ = sample_surface(solid.points, solid.triangles, UPRIGHT_SAMPLES, 0)
    middle = centroid(solid.points, solid.triangles) if solid.kind == "closed" else samples.mean(axis=0)
    rays, hull_rays = Rays(solid.points, solid.triangles), Rays(*hull)
    hull_volume = volume(*hull)

    @cache
    def water_and_room(up: tuple[float, ...]) -> tuple[float, float]:
        """Volumes of water, and of the space under the hull visible from above, as shares of the hull's volume."""
        frame = rotation_to_z(np.array(up))
        ground, _, step, _ = heightfield(rays, hull[0], samples, frame)
        lid = heightfield(hull_rays, hull[0], hull[0][:1], frame).ground
        met = ~np.isneginf(ground) & ~np.isneginf(lid)
        level, cell = fill_depressions(ground)[met], step * step / hull_volume
        room = float(np.maximum(lid[met] - ground[met], 0.0).sum()) * cell
        return float((level - ground[met]).sum()) * cell, room

    def features_of(up: FloatArray) -> UprightFeatures | None:
        height, hull_height, across = samples @ up, hull[0] @ up, rotation_to_z(up)[:2].T
        low, tall = float(hull_height.min()), float(np.ptp(hull_height))
        lever = _inside_by(hull[0][hull_height < low + FOOT_SHARE * tall] @ across, middle @ across)
        tip_rad = float(np.arctan2(lever, float(middle @ up) - low))
        if tip_rad < FALLS_RAD and up[2] < 1.0:
            return None
        area, outline = _outline(hull[0] @ across)
        (water, _), (filled, room) = water_and_room(tuple(up)), water_and_room(tuple(-up))
        away = np.linalg.norm((samples - middle) @ across, axis=1)
        profile, _, _ = np.histogram2d(
            (height - low) / tall, away / max(float(away.max()), 1e-300), bins=PROFILE, range=((0, 1), (0, 1))
        )
        return UprightFeatures(
            up=up,
            tip_rad=tip_rad,
            water=water,
            under=max(room - filled, 0.0),
            flat=float(np.log(np.sqrt(area) / tall)),
            round=4.0 * np.pi * area / outline**2,
            top=_outline(samples[height > low + (1.0 - END_SHARE) * tall] @ across)[0] / area,
            bottom=_outline(samples[height < low + END_SHARE * tall] @ across)[0] / area,
            profile=profile / len(samples),
        )

    return tuple(s for s in map(features_of, candidate_directions(solid.points, samples)) if s is not None)


def same_profile(a: UprightFeatures, b: UprightFeatures) -> bool:
    """Whether two up directions give the same distribution of surface over height and distance from the axis."""
    return float(np.abs(a.profile - b.profile).sum()) < ALIKE_SHARE


def candidate_directions(points: FloatArray, samples: FloatArray) -> FloatArray:
    """(k, 3) unit vectors that may be up: both ways along the coordinate axes, the normals of broad facets, the edges
    of the smallest box and the principal axes of `samples` (m, 3) of the surface.
    """
    axes = np.eye(3)[[2, 1, 0]]
    facets = resting_planes(points).normals[:MAX_FACETS]
    box = fit_box(points)
    boxed = box.X_AS[:3, :3].T if box is not None else np.empty((0, 3))
    centred = samples - samples.mean(axis=0)
    principal = np.linalg.eigh(centred.T @ centred)[1].T
    directions: list[FloatArray] = []
    for axis in (*axes, *facets, *boxed, *principal):
        for up in (axis, -axis):
            if all(up @ other < np.cos(SAME_RAD) for other in directions):
                directions.append(up)
    return np.array(directions)


def _inside_by(flat: FloatArray, place: FloatArray) -> float:
    """Depth of `place` (2,) inside the convex outline of points (n, 2); negative outside."""
    try:
        edges = ConvexHull(flat).equations
    except (QhullError, ValueError):
        return -float(np.linalg.norm(flat - place, axis=1).min())
    return -float((edges[:, :2] @ place + edges[:, 2]).max())


def _outline(flat: FloatArray) -> tuple[float, float]:
    """Area and length of the convex outline of points (n, 2); 0 and inf without area."""
    try:
        hull = ConvexHull(flat)
    except (QhullError, ValueError):
        return 0.0, np.inf
    return float(hull.volume), float(hull.area)
