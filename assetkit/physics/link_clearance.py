"""Collision shapes of links that reach into each other at rest: slight overlaps are cut away, deep ones filtered.

Two links that collide and overlap burst apart, along whatever their joints leave them: two doors of a fridge that
share 0.7 mm throw each other open. A plane through the middle of the overlap cuts both convex shapes back. Links that
scrape along each other in motion are filtered, too: no cut at rest would free them, and drawers one above the other
jam by a quarter of a millimetre.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from manifold3d import Manifold

from geom.convex.hull import convex_hull
from geom.convex.penetration import box_overlap, penetration
from geom.convex.support_function import surface
from geom.mechanism_pose import link_motions, movable_joints
from geom.pose import apply
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, finding
from schemas.mechanism import Mechanism
from schemas.outcome import Repair
from schemas.physics import CollisionShape

OVERLAP_SHARE = 0.002  # of the smaller link's diagonal: deeper overlaps are meant, as a hinge in its housing
GAP_SHARE = 1e-4  # of the smaller link's diagonal, left between shapes that were cut
SCRAPE_SHARE = 0.01  # of the smaller link's diagonal: what fitted hulls are off by (`gate.rules.joint.links_overlap`)
SCRAPE_POSITIONS = 17  # along the range of each joint
MOST_SCRAPE_TESTS = 1500  # of pairs of shapes that are apart at rest, about 3 ms each; a heavier object is not searched
# Of the smaller link's diagonal. Faces that slide along each other nearer than this jam in PyBullet: the normals of
# contacts between hulls that hardly touch point any way (drawers of 0.3 m, 0.2 mm apart).
TOUCH_SHARE = 1e-3
ROUNDING_SHARE = 1e-6  # of the smaller link's diagonal: single precision of the files
MAX_CORNERS = 64  # of a hull, as PhysX takes
CODE = "asset/colliders-trimmed"

Shapes = Mapping[str, Sequence[CollisionShape]]


@dataclass(frozen=True)
class Clearance:
    """Shapes of all links by name, in their order; pairs of links that do not collide; what was done."""

    shapes: dict[str, tuple[CollisionShape, ...]]
    filtered_pairs: tuple[tuple[str, str], ...]
    repairs: tuple[Repair, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()


def clear_links(links: Shapes, mechanism: Mechanism) -> Clearance:
    """`links` (asset frame at rest, m) with slight overlaps cut away; pairs that stay in each other are filtered.

    Only hulls and boxes are cut; a pair whose overlap cannot be cut away is filtered, and so is one that overlaps
    slightly along the range of a joint that carries one of the two, the others at rest.
    """
    shapes = {name: list(of_link) for name, of_link in links.items()}
    pairs, repairs, deepest = list[tuple[str, str]](), list[Repair](), 0.0
    tests = MOST_SCRAPE_TESTS
    for first, second in combinations(shapes, 2):
        size = min(_diagonal(shapes[first]), _diagonal(shapes[second]))
        depth = _deepest(shapes[first], shapes[second])
        if depth <= ROUNDING_SHARE * size:
            apart = shapes[first], shapes[second]
            if _gap(*apart) <= SCRAPE_SHARE * size and tests > 0:
                scrape, taken = _scraping(mechanism, first, second, apart)
                tests -= taken
                if ROUNDING_SHARE * size < scrape <= SCRAPE_SHARE * size:
                    pairs.append((first, second))
                    deepest = max(deepest, scrape)
            continue
        cut = None
        if depth <= OVERLAP_SHARE * size:
            cut = _cut_pair(shapes[first], shapes[second], GAP_SHARE * size)
        scrape = 0.0 if cut is None else _scraping(mechanism, first, second, cut)[0]
        if cut is None or ROUNDING_SHARE * size < scrape <= SCRAPE_SHARE * size:
            pairs.append((first, second))
            deepest = max(deepest, depth)
            continue
        shapes[first], shapes[second] = cut
        left = _deepest(*cut)
        links_named: dict[str, float | int | str] = {"links": f"{first}, {second}"}
        repairs.append(
            Repair(
                name="collider_trim",
                code=CODE,
                stage="physics",
                before={**links_named, "overlap_m": depth},
                after={**links_named, "overlap_m": left},
            )
        )
    frozen = {name: tuple(of_link) for name, of_link in shapes.items()}
    return Clearance(frozen, tuple(pairs), tuple(repairs), tuple(_notes(repairs, pairs, deepest)))


def _scraping(
    mechanism: Mechanism, first: str, second: str, shapes: tuple[Sequence[CollisionShape], Sequence[CollisionShape]]
) -> tuple[float, int]:
    """The deepest overlap (m) of two links over the ranges of the joints that carry them, the others at rest, and the
    number of pairs of shapes that were tested. 0 for links that a joint connects; the search ends where links collide
    for good, deeper than by scraping. One link is grown by what counts as touching.
    """
    if any({joint.parent, joint.child} == {first, second} for joint in mechanism.joints):
        return 0.0, 0  # They never collide.
    size = min(_diagonal(shapes[0]), _diagonal(shapes[1]))
    clouds_a, clouds_b = ([surface(shape)[0] for shape in of_link] for of_link in shapes)
    clouds_a = [_grown(cloud, TOUCH_SHARE * size) for cloud in clouds_a]
    most = SCRAPE_SHARE * size
    deepest, tests = 0.0, 0
    for joint in (j for j in movable_joints(mechanism) if j.child in (first, second)):
        low, high = joint.limits or (joint.rest - np.pi, joint.rest + np.pi)
        for position in np.linspace(low, high, SCRAPE_POSITIONS):
            M = link_motions(mechanism, {joint.name: float(position)})
            moved_a, moved_b = [apply(M[first], c) for c in clouds_a], [apply(M[second], c) for c in clouds_b]
            near = [(a, b) for a in moved_a for b in moved_b if box_overlap(a, b) > 0.0]
            tests += len(near)
            deepest = max([deepest, *(penetration(a, b)[0] for a, b in near)])
            if deepest > most:
                return deepest, tests
    return deepest, tests


def _grown(points: FloatArray, margin_m: float) -> FloatArray:
    """Corners of a convex shape, moved away from the middle of its box so that its sides move by a margin."""
    low, high = points.min(axis=0), points.max(axis=0)
    half = np.maximum(0.5 * (high - low), margin_m)
    return 0.5 * (low + high) + (points - 0.5 * (low + high)) * (1.0 + margin_m / half)


def _gap(first: Sequence[CollisionShape], second: Sequence[CollisionShape]) -> float:
    """The largest distance (m) of the boxes around two links along x, y or z; negative where they overlap."""
    clouds = [np.concatenate([surface(shape)[0] for shape in of_link]) for of_link in (first, second) if of_link]
    return -box_overlap(*clouds) if len(clouds) == 2 else np.inf


def _notes(repairs: Sequence[Repair], pairs: Sequence[tuple[str, str]], deepest: float) -> list[Diagnostic]:
    notes: list[Diagnostic] = []
    if repairs:
        depth = max(float(repair.before["overlap_m"]) for repair in repairs)
        names = "; ".join(str(repair.before["links"]) for repair in repairs[:3])
        headline = f"colliders of links that overlapped slightly at rest were cut back: {names}"
        notes.append(finding(CODE, headline, value=depth, bound=0.0, unit="m"))
    if pairs:
        names = "; ".join(f"{a}, {b}" for a, b in pairs[:3]) + ("; ..." if len(pairs) > 3 else "")
        headline = f"links that overlap at rest do not collide with each other: {names}"
        notes.append(finding("asset/links-filtered", headline, value=deepest, unit="m"))
    return notes


def _cut_pair(
    first: Sequence[CollisionShape], second: Sequence[CollisionShape], gap_m: float
) -> tuple[list[CollisionShape], list[CollisionShape]] | None:
    """Both links with every overlap of their shapes cut away; None where that is not possible."""
    a_shapes, b_shapes = list(first), list(second)
    for i, j in ((i, j) for i in range(len(a_shapes)) for j in range(len(b_shapes))):
        a, b = surface(a_shapes[i])[0], surface(b_shapes[j])[0]
        if box_overlap(a, b) <= 0.0:
            continue
        depth, normal = penetration(a, b)
        if depth <= 0.0:
            continue
        middle = 0.5 * (float((a @ normal).max()) + float((b @ normal).min()))
        cut_a = _cut(a_shapes[i], normal, middle - 0.5 * gap_m)
        cut_b = _cut(b_shapes[j], -normal, -(middle + 0.5 * gap_m))
        if cut_a is None or cut_b is None:
            return None
        a_shapes[i], b_shapes[j] = cut_a, cut_b
    return a_shapes, b_shapes


def _cut(shape: CollisionShape, normal: FloatArray, offset: float) -> CollisionShape | None:
    """The part of a hull or box where normal . x <= offset; None where nothing is left or it has too many corners."""
    if shape.kind not in ("hull", "box"):
        return None
    whole = Manifold.hull_points(np.ascontiguousarray(surface(shape)[0], dtype=np.float64))
    part = whole.trim_by_plane((-normal).tolist(), -offset)
    if part.is_empty() or part.volume() < 0.5 * whole.volume():
        return None
    try:
        points, triangles = convex_hull(np.asarray(part.to_mesh64().vert_properties[:, :3], dtype=np.float64))
    except ValueError:
        return None
    if len(points) > MAX_CORNERS:
        return None
    return replace(shape, kind="hull", size_m=(), X_AS=np.eye(4), points=points, triangles=triangles.astype(np.int32))


def _deepest(first: Sequence[CollisionShape], second: Sequence[CollisionShape]) -> float:
    clouds_a, clouds_b = ([surface(shape)[0] for shape in shapes] for shapes in (first, second))
    depths = [penetration(a, b)[0] for a in clouds_a for b in clouds_b if box_overlap(a, b) > 0.0]
    return max(depths, default=0.0)


def _diagonal(shapes: Sequence[CollisionShape]) -> float:
    points = np.concatenate([np.zeros((0, 3)), *(surface(shape)[0] for shape in shapes)])
    return float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0
