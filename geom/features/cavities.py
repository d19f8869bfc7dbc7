"""Cavities of a solid that an object fits into: the inside of a mug, bowl, basket or bin, and large through-holes.

Method: depression filling, as in hydrology. Along an opening direction the surface is a heightfield, and a depression
that fills up before it overflows is a cavity. Cavities behind a neck (`geom.features.necked_cavities`) are added.
Inner cells that no ray hits are closed by the support below, so pipes and rings hold water too (`through`). Metres.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from pydantic import ConfigDict
from scipy import ndimage

from geom.convex.hull import beyond_planes, contains, convex_hull, volume
from geom.convex.support_function import surface
from geom.features.clearance_grid import ClearanceGrid, clearance_grid
from geom.features.heightfield import fill_depressions, heightfield, wall_points
from geom.features.leaks import widest_leak
from geom.features.necked_cavities import find_necked_cavities
from geom.mesh.rays import Rays
from geom.mesh.surface_distance import NearestOnSurface, closest_on_surface
from geom.pose import rotation_to_z
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.physics import CollisionShape, Solid

OPENING_DIRECTIONS = np.array([[0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]], dtype=np.float64)

# A cavity matters when its water is at least this share of the hull: upward, and in any other direction, where things
# are seldom put in and most furniture has a recess.
UPWARD_SHARE, OTHER_SHARE = 0.04, 0.12
# ... and when it is at least this deep against its opening, so that a dented plate is not a container.
LEAST_DEPTH_SHARE = 0.12
# Through: the support closes more than this share of the ground. A hole in a wall or a ring holds little water and
# matters by its width, as a share of the diagonal.
THROUGH_SHARE = 0.5
THROUGH_DIAMETER_SHARE = 0.1
# The mouth of a necked cavity is at least this wide, as a share of the edge of a cube of the hull's volume: a smaller
# one only lets air or a cable in.
MOUTH_DIAMETER_SHARE = 0.1
# A ball that gets less deep than this share of the deepest water rests on partitions.
COMPARTMENT_SHARE = 0.5
FULLER = 1.2
ALIGNED = 0.99  # cosine from which an axis counts as a coordinate axis
# The probe ball, as a share of the opening radius; it must get this share of the depth that it reaches in the solid.
PROBE_SHARE, PROBE_DEPTH_SHARE = 0.6, 0.8
PROBE_STEPS = 24
# A ball so many radii from the box of a shape does not touch it, whatever single precision rounds.
BOX_MARGIN = 1.001


@dataclass(frozen=True)
class Cavity:
    """One significant opening; lengths in metres, frame of the points.

    direction   (3,) unit vector out of the opening.
    opening_m   (3,) centre of the largest circle that fits into the opening, at the rim.
    diameter_m  diameter of that circle, short by up to three grid cells.
    depth_m     from the rim to the ground below that centre.
    probe_m     radius of the probe ball, 60 % of the opening.
    reach_m     depth below the rim that the lowest point of that ball reaches in the solid.
    volume_m3   water it holds.
    through     the ground is mostly open: a pipe or ring rather than a container.
    way_m       (k, 3) centres of the probe ball on its path in, as deep as it must get.
    second_m    60 % of the radius of the widest ball that leaves by another opening than the mouth, as from a funnel, a
                pot or a teapot; 0 where no opening is wide enough, and for `through`.
    second_way_m  (j, 3) centres of a ball on that path.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    direction: FloatArray
    opening_m: FloatArray
    diameter_m: float
    depth_m: float
    probe_m: float
    reach_m: float
    volume_m3: float
    through: bool
    way_m: FloatArray
    second_m: float = 0.0
    second_way_m: FloatArray = field(default_factory=lambda: np.empty((0, 3)))


def find_cavities(solid: Solid) -> tuple[Cavity, ...]:
    """Significant cavities along the six axis directions, upward first, then along the principal axes of an oblique
    solid; none for a solid of kind `hull`.

    A through-hole is listed once, not from both ends, and an opening seen along two directions as seen from the first,
    unless its volume is larger along the other: a leaning bin.
    """
    if solid.kind == "hull":
        return ()
    try:
        hull = convex_hull(solid.points)
    except ValueError:
        return ()
    hull_volume = volume(*hull)
    surface_of = solid.points, solid.triangles
    walls, rays = wall_points(*surface_of), Rays(*surface_of)
    cavities: list[Cavity] = []
    for direction in (*OPENING_DIRECTIONS, *_oblique_axes(hull[0])):
        share = UPWARD_SHARE if direction[2] > ALIGNED else OTHER_SHARE
        for cavity in _cavities_along(solid, rays, walls, direction, share * hull_volume):
            before = [other for other in cavities if _is_same(cavity, other)]
            if not before:
                cavities.append(cavity)
            elif not cavity.through and all(cavity.volume_m3 > FULLER * other.volume_m3 for other in before):
                cavities = [*(other for other in cavities if not _is_same(cavity, other)), cavity]
    may_have_necked = solid.kind != "closed" or volume(*surface_of) <= (1.0 - UPWARD_SHARE) * hull_volume
    if not may_have_necked and all(cavity.through for cavity in cavities):
        return tuple(cavities)
    nearest = NearestOnSurface(*surface_of)
    grid = clearance_grid(*surface_of, nearest)
    if may_have_necked:
        cavities = _with_necked_cavities(solid, nearest, grid, walls, hull_volume, cavities)
    return tuple(_with_leak(grid, cavity, least_mouth_radius(hull_volume)) for cavity in cavities)


def _with_necked_cavities(
    solid: Solid,
    nearest: NearestOnSurface,
    grid: ClearanceGrid,
    walls: FloatArray,
    hull_volume: float,
    seen_cavities: Sequence[Cavity],
) -> list[Cavity]:
    """`seen_cavities` and the necked cavities, whose volume is mostly hidden from above the mouth.

    A necked cavity replaces one that was already found only where a straight drop does not get far into it.
    """
    least_radius = least_mouth_radius(hull_volume)
    cavities = list(seen_cavities)
    for necked in find_necked_cavities(nearest, grid, walls, UPWARD_SHARE * hull_volume, least_radius):
        probe = PROBE_SHARE * necked.radius
        depth_m = _insertion_depth(solid, necked.mouth, necked.outward, probe, necked.depth)
        cavity = Cavity(
            necked.outward,
            necked.mouth,
            2.0 * necked.radius,
            necked.depth,
            probe,
            depth_m,
            necked.volume,
            False,
            necked.way,
        )
        same = [other for other in cavities if _is_same(cavity, other)]
        if all(other.reach_m < COMPARTMENT_SHARE * necked.depth for other in same):
            cavities = [*(other for other in cavities if not _is_same(cavity, other)), cavity]
    return cavities


def _with_leak(grid: ClearanceGrid, cavity: Cavity, least_m: float) -> Cavity:
    if cavity.through:
        return cavity
    place = (cavity.way_m[-1], cavity.opening_m, cavity.direction)
    radius, way = widest_leak(grid, *place, cavity.probe_m, least_m)
    return replace(cavity, second_m=PROBE_SHARE * radius, second_way_m=way)


def least_mouth_radius(hull_volume_m3: float) -> float:
    """Radius (m) of the smallest ball that must pass a mouth, for a solid with a hull of `hull_volume_m3`."""
    return 0.5 * MOUTH_DIAMETER_SHARE * hull_volume_m3 ** (1.0 / 3.0)


def keeps_cavity(shapes: Sequence[CollisionShape], cavity: Cavity) -> bool:
    """True iff the probe ball can follow its path into the opening between the collision shapes, and its path out."""
    ways = ((cavity.way_m, cavity.probe_m), (cavity.second_way_m, cavity.second_m))
    return all(_ball_clear(shape, way, radius) for shape in shapes for way, radius in ways)


def _ball_clear(shape: CollisionShape, centres_m: FloatArray, radius_m: float) -> bool:
    """Whether balls at `centres_m` (k, 3) do not touch the shape."""
    points, triangles = surface(shape)
    beside = np.maximum(np.maximum(points.min(axis=0) - centres_m, centres_m - points.max(axis=0)), 0.0)
    if (np.linalg.norm(beside, axis=1) > BOX_MARGIN * radius_m).all():
        return True
    hull = convex_hull(points)
    # Beyond a face plane by the radius is far enough; only the rest needs exact distances.
    near = centres_m[beyond_planes(*hull, centres_m) < radius_m]
    if len(near) == 0:
        return True
    if contains(*hull, near).any():
        return False
    nearest, _ = closest_on_surface(near, points, triangles)
    return not bool((np.linalg.norm(nearest - near, axis=1) < radius_m).any())


def _oblique_axes(points: FloatArray) -> FloatArray:
    """Both directions (k, 3) of each principal axis of hull corners (n, 3) that is no coordinate axis."""
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1].T
    axes = axes[np.abs(axes).max(axis=1) < ALIGNED]
    return np.concatenate([axes, -axes])


def _is_same(cavity: Cavity, other: Cavity) -> bool:
    """Whether two cavities are one opening: a pipe from its other end, or one seen along a similar direction."""
    cosine = float(cavity.direction @ other.direction)
    if cavity.through and other.through and cosine < -0.5:
        return True
    apart = float(np.linalg.norm(cavity.opening_m - other.opening_m))
    return cosine > 0.5 and apart < 0.5 * max(cavity.diameter_m, other.diameter_m)


def _cavities_along(
    solid: Solid, rays: Rays, walls: FloatArray, direction: FloatArray, least_volume_m3: float
) -> list[Cavity]:
    """Cavities that open along `direction` and hold at least `least_volume_m3`, and wide through-holes."""
    frame = rotation_to_z(direction)
    local = solid.points @ frame.T
    ground, floor, step, corner = heightfield(rays, solid.points, walls, frame)
    open_floor = np.isneginf(ground)
    outside, _ = _label(open_floor)
    drain = open_floor & np.isin(outside, np.concatenate([outside[0], outside[-1], outside[:, 0], outside[:, -1]]))
    ground = np.where(open_floor & ~drain, floor, ground)
    depth = np.zeros(ground.shape)
    depth[~drain] = fill_depressions(ground)[~drain] - ground[~drain]
    size = float(np.linalg.norm(np.ptp(local, axis=0)))

    def cavity_in(pool: BoolArray) -> Cavity | None:
        water = float(depth[pool].sum()) * step * step
        through = bool((open_floor & ~drain)[pool].mean() > THROUGH_SHARE)
        if not through and water < least_volume_m3:
            return None
        # Half a cell more: the distance runs to the centre of the first dry cell.
        clearance = np.asarray(ndimage.distance_transform_edt(pool))
        row, column = np.unravel_index(int(np.argmax(clearance)), pool.shape)
        radius = (float(clearance[row, column]) - 0.5) * step
        deepest = float(depth[row, column])
        deep = water >= least_volume_m3 and deepest >= LEAST_DEPTH_SHARE * 2.0 * radius
        wide = through and 2.0 * radius >= THROUGH_DIAMETER_SHARE * size
        if radius <= 0.0 or not (deep or wide):
            return None
        rim = float(ground[row, column]) + deepest
        opening = frame.T @ np.array([corner[0] + row * step, corner[1] + column * step, rim])
        probe = PROBE_SHARE * radius
        depth_m = _insertion_depth(solid, opening, direction, probe, deepest)
        way = _ball_centres(opening, direction, probe, np.linspace(0.0, PROBE_DEPTH_SHARE * depth_m, PROBE_STEPS))
        return Cavity(direction, opening, 2.0 * radius, deepest, probe, depth_m, water, through, way)

    cavities: list[Cavity | None] = []
    for pool in _patches(depth > 0.02 * max(float(np.ptp(local[:, 2])), step)):
        cavity = cavity_in(pool)
        lowest = float(depth[pool].max())
        if cavity is None or cavity.reach_m < COMPARTMENT_SHARE * lowest:
            # Partitions under water: each compartment is a cavity, unless there is only one.
            compartments = list(_patches(pool & (depth > COMPARTMENT_SHARE * lowest)))
            inner = [cavity_in(c) for c in compartments] if len(compartments) > 1 else []
            cavities += inner if any(inner) else [cavity]
        else:
            cavities.append(cavity)
    return [cavity for cavity in cavities if cavity is not None]


def _patches(mask: BoolArray) -> Iterator[BoolArray]:
    """Each connected patch of True cells as a mask of its own."""
    labels, count = _label(mask)
    for k in range(1, count + 1):
        yield labels == k


def _insertion_depth(solid: Solid, opening: FloatArray, direction: FloatArray, radius: float, depth: float) -> float:
    """Depth below the rim at which the bottom of a ball first touches the solid, at most `depth`."""
    bottoms = np.linspace(0.0, depth, 4 * PROBE_STEPS)
    centres = _ball_centres(opening, direction, radius, bottoms)
    nearest, _ = closest_on_surface(centres, solid.points, solid.triangles)
    touching = np.linalg.norm(nearest - centres, axis=1) < radius
    return float(bottoms[max(int(touching.argmax()) - 1, 0)] if touching.any() else depth)


def _ball_centres(opening: FloatArray, direction: FloatArray, radius: float, bottoms: FloatArray) -> FloatArray:
    """Centres (k, 3) of balls whose lowest points lie `bottoms` (k,) below the rim."""
    return opening + (radius - bottoms)[:, None] * direction


def _label(mask: BoolArray) -> tuple[IntArray, int]:
    """Number (rows, columns) of each cell's patch of True cells, from 1, and how many there are."""
    labels = np.zeros(mask.shape, dtype=np.int32)
    return labels, ndimage.label(mask, output=labels)
