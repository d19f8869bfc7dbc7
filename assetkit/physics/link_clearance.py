"""Collision shapes of links that reach into each other at rest: slight overlaps are cut away, deep ones filtered.

Two links that collide and overlap burst apart, along whatever their joints leave them: two doors of a fridge that
share 0.7 mm throw each other open. A plane through the middle of the overlap cuts both convex shapes back. Links that
scrape along each other in motion, too, are filtered: no cut at rest would free them.
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
SCRAPE_POSITIONS = 9  # along the range of each joint
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
    slightly along the range of a joint, the others at rest.
    """
    shapes = {name: list(of_link) for name, of_link in links.items()}
    pairs, repairs, deepest = list[tuple[str, str]](), list[Repair](), 0.0
    for first, second in combinations(shapes, 2):
        size = min(_diagonal(shapes[first]), _diagonal(shapes[second]))
        depth = _deepest(shapes[first], shapes[second])
        if depth <= ROUNDING_SHARE * size:
            continue
        cut = None
        if depth <= OVERLAP_SHARE * size:
            cut = _cut_pair(shapes[first], shapes[second], GAP_SHARE * size)
        if cut is None or ROUNDING_SHARE * size < _scraping(mechanism, first, second, cut) <= SCRAPE_SHARE * size:
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
    mechanism: Mechanism, first: str, second: str, cut: tuple[Sequence[CollisionShape], Sequence[CollisionShape]]
) -> float:
    """The deepest overlap (m) of two links over the range of any joint that moves one of them alone; 0 if joined."""
    if any({joint.parent, joint.child} == {first, second} for joint in mechanism.joints):
        return 0.0  # They never collide.
    clouds_a, clouds_b = ([surface(shape)[0] for shape in shapes] for shapes in cut)
    deepest = 0.0
    for joint in movable_joints(mechanism):
        low, high = joint.limits or (joint.rest - np.pi, joint.rest + np.pi)
        for position in np.linspace(low, high, SCRAPE_POSITIONS):
            M = link_motions(mechanism, {joint.name: float(position)})
            if np.allclose(M[first], M[second]):
                continue
            moved_a, moved_b = [apply(M[first], c) for c in clouds_a], [apply(M[second], c) for c in clouds_b]
            depths = [penetration(a, b)[0] for a in moved_a for b in moved_b if box_overlap(a, b) > 0.0]
            deepest = max(deepest, *depths, 0.0)
    return deepest


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
