"""Verifies proposed anchors in simulation: probes released onto a surface or into a volume must come to rest there.

Small boxes are released at positions spread over each surface, small balls at positions over each opening, above the
colliders as released; where an opening is level, on the floor behind it. An anchor is verified when most of its probes
end on or in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from assetkit.affordances.anchors import shape_of
from geom.convex.support_function import diagonal
from geom.features.containment import UPWARD_COSINE
from geom.pose import pose
from schemas.anchors import Anchor, ContainmentVolume, SupportSurface
from schemas.arrays import BoolArray, FloatArray
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence, measured
from schemas.physics import CollisionShape
from sim.port import ProbeResult, Simulator, natural_time_s

# Edge of a box as a share of the diagonal of the object, of the disc that fits the surface, and of its clearance; it is
# half as high and released half an edge above.
BOX_OF_DIAGONAL, BOX_OF_DISC, BOX_OF_CLEARANCE = 0.05, 0.7, 0.5
# Radius of a ball as a share of the largest that passes the opening and of the usable height.
BALL_OF_PASSING, BALL_OF_HEIGHT = 0.4, 0.35
PLACES, GRID = 9, 16
# Colliders follow the visible surface to this share of the diagonal.
OFF_SHARE = 0.02
STAY_SHARE = 0.8
DURATION = 5.0  # natural times of the object
SLOW = 0.1  # of the natural speed: the probe is about to rest; a ball in a bowl may still roll


@dataclass(frozen=True)
class VerifiedAnchors:
    """The anchors that hold, and findings on the others."""

    anchors: tuple[Evidence[Anchor], ...]
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True)
class AnchorTrial:
    """How many of the probes of one anchor ended on or in it."""

    staying: int
    probes: int

    @property
    def share(self) -> float:
        """Share of the probes."""
        return self.staying / self.probes

    @property
    def holds(self) -> bool:
        """Whether the anchor is verified."""
        return self.share >= STAY_SHARE


def verify_anchors(
    proposed: Sequence[Anchor], fixed: Sequence[CollisionShape], simulator: Simulator
) -> VerifiedAnchors:
    """Each proposed anchor of an object with the collision shapes `fixed` (asset frame), tried in one simulation."""
    trials = try_anchors(proposed, fixed, simulator)
    pairs = list(zip(proposed, trials, strict=True))
    holding = [verified_anchor(anchor, trial, simulator.name) for anchor, trial in pairs if trial.holds]
    return VerifiedAnchors(
        tuple(holding), tuple(unverified(anchor, trial) for anchor, trial in pairs if not trial.holds)
    )


def try_anchors(
    anchors: Sequence[Anchor], fixed: Sequence[CollisionShape], simulator: Simulator
) -> tuple[AnchorTrial, ...]:
    """What the probes of each anchor do over the collision shapes `fixed`, all in one simulation."""
    if not anchors:
        return ()
    size = diagonal(fixed)
    probes = [_probes(anchor, size) for anchor in anchors]
    ended = simulator.drop_probes(
        fixed, [p for of_anchor in probes for p in of_anchor], DURATION * natural_time_s(size)
    )
    trials: list[AnchorTrial] = []
    first = 0
    for anchor, of_anchor in zip(anchors, probes, strict=True):
        part = slice(first, first + len(of_anchor))
        end = ProbeResult(ended.centres_m[part], ended.lowest_m[part], ended.speeds_mps[part])
        stays = _stays(anchor, end, size)
        first += len(of_anchor)
        trials.append(AnchorTrial(int(stays.sum()), len(stays)))
    return tuple(trials)


def verified_anchor(anchor: Anchor, trial: AnchorTrial, simulator: str, state: str = "") -> Evidence[Anchor]:
    """The anchor with its evidence; `state` says where joints were, if not at rest."""
    method = f"geometry; {trial.staying} of {trial.probes} probes stay in {simulator}{state}"
    return measured(anchor, method, confidence=trial.share)


def unverified(anchor: Anchor, trial: AnchorTrial, state: str = "") -> Diagnostic:
    """The finding on an anchor that does not hold."""
    preposition = "on" if anchor.kind == "surface" else "in"
    count = f"{trial.staying} of {trial.probes} probes"
    headline = f"{anchor.anchor_id}: {count} stay {preposition} it{state}, so it is left out"
    return finding("asset/anchor-unverified", headline, value=trial.share, bound=STAY_SHARE, unit="of the probes")


def _probes(anchor: Anchor, size: float) -> list[CollisionShape]:
    return _boxes(anchor, size) if anchor.kind == "surface" else _balls(anchor)


def _boxes(surface: SupportSurface, size: float) -> list[CollisionShape]:
    x, y, z = surface.position_m
    polygon = shape_of(surface.polygon, x, y)
    edge = min(BOX_OF_DIAGONAL * size, BOX_OF_DISC * 2.0 * _inscribed_radius(polygon))
    if surface.clearance_m is not None:
        edge = min(edge, BOX_OF_CLEARANCE * surface.clearance_m)
    margin_m = np.sqrt(0.5) * edge
    positions = spread_positions(polygon, margin_m, margin_m)
    return [
        CollisionShape("box", (edge, edge, 0.5 * edge), pose(None, (px, py, z + 0.75 * edge))) for px, py in positions
    ]


def _balls(volume: ContainmentVolume) -> list[CollisionShape]:
    x, y, z = volume.position_m
    radius = min(BALL_OF_PASSING * 0.5 * volume.passes_m, BALL_OF_HEIGHT * volume.height_m)
    positions = spread_positions(shape_of(volume.opening, x, y), 1.5 * radius, 1.5 * radius)
    # Into a volume that opens sideways nothing falls: its balls are released inside.
    start = volume.height_m + 1.2 * radius if opens_up(volume) else 1.2 * radius
    return [CollisionShape("sphere", (radius,), pose(None, (px, py, z + start))) for px, py in positions]


def opens_up(volume: ContainmentVolume) -> bool:
    """Whether things fall into a volume, as against one behind a door."""
    return volume.direction[2] >= UPWARD_COSINE


def _stays(anchor: Anchor, end: ProbeResult, size: float) -> BoolArray:
    """(k,) whether each probe ended on or in the anchor, and slow."""
    off = OFF_SHARE * size
    x, y, z = anchor.position_m
    if anchor.kind == "surface":
        region = shape_of(anchor.polygon, x, y)
        level = np.abs(end.lowest_m - z) <= off
    else:
        region = shapely.union_all([shape_of(p, x, y) for cut in anchor.slices for p in cut.polygons])
        level = (end.lowest_m >= z - off) & (end.centres_m[:, 2] <= z + anchor.height_m)
    there = shapely.contains_xy(region.buffer(off), end.centres_m[:, 0], end.centres_m[:, 1])
    return level & there & (end.speeds_mps <= SLOW * size / natural_time_s(size))


def spread_positions(polygon: shapely.Polygon, margin_m: float, apart_m: float) -> FloatArray:
    """(k, 2) up to nine positions at least `margin_m` from the edge and more than `apart_m` from one another; at least
    the innermost one.

    Farthest-point sampling (Gonzalez 1985) of a grid, from the innermost position on.
    """
    circle = shapely.maximum_inscribed_circle(polygon)
    middle = np.asarray(circle.coords[0])
    low, high = np.array(polygon.bounds).reshape(2, 2)
    shares = (np.arange(GRID) + 0.5) / GRID
    grid = low + np.stack(np.meshgrid(shares, shares, indexing="ij"), axis=-1).reshape(-1, 2) * (high - low)
    inner = polygon.buffer(-margin_m)
    grid = grid[shapely.contains_xy(inner, grid[:, 0], grid[:, 1])]
    chosen = [middle]
    apart = np.linalg.norm(grid - middle, axis=1)
    while len(chosen) < PLACES and len(grid) and apart.max() > apart_m:
        chosen.append(grid[int(apart.argmax())])
        apart = np.minimum(apart, np.linalg.norm(grid - chosen[-1], axis=1))
    return np.array(chosen)


def _inscribed_radius(polygon: shapely.Polygon) -> float:
    return float(shapely.maximum_inscribed_circle(polygon).length)
