"""Affordance regions of an object beside grasps: rims, spouts, handles, hang holes; lids, knobs, buttons by name.

Each is a relation (part, task, interaction) with evidence from geometry or names; metres, asset frame.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from assetkit.affordances.named_regions import DIGITS, named_regions, part_at
from geom.features.elongated_ends import ElongatedEnd, find_elongated_end
from geom.features.spouts import find_spout
from geom.features.through_holes import ThroughHole, find_through_holes
from schemas.affordances import OrientationRequirement, Region
from schemas.anchors import Anchor, ContainmentVolume
from schemas.arrays import FloatArray
from schemas.asset import vec3
from schemas.evidence import Evidence, inferred, measured
from schemas.parts import Part
from schemas.physics import Solid

HOOK_M = 0.004  # the thinnest hook
FINGERS_M, ARM_M = 0.018, 0.2  # Least and greatest loop of a handle: fingers pass it; an arm's width is no handle.
BAR_M = (0.003, 0.05)  # thickness of a bar that fingers close around
OFF_CENTRE = 0.35  # of the radius of the silhouette: the hole of a ring is in its middle
HOLES = 6
BY_LOOP, BY_GRIP, BY_HOLE, BY_LIP = 0.8, 0.6, 0.8, 0.7
LEVEL_RAD = math.radians(30.0)


def find_regions(
    solid: Solid, anchors: Sequence[Evidence[Anchor]], parts: Sequence[Evidence[Part]]
) -> tuple[Evidence[Region], ...]:
    """Rims and lips of upright volumes, handles, holes, and regions of named parts; metres, asset frame.

    A region that geometry finds on a part of the same name belongs to that part, which is not listed again.
    """
    volumes = [e for e in anchors if e.value.kind == "volume"]
    holes = find_through_holes(solid)
    shaped = [*_rims(volumes), *_spouts(volumes), *_handles(holes, find_elongated_end(solid)), *_hang_holes(holes)]
    shaped = [with_part(e, parts) for e in shaped]
    taken = {(e.value.part, e.value.kind) for e in shaped}
    named = named_regions(parts, solid.points.min(axis=0), solid.points.max(axis=0))
    return tuple(_numbered([*shaped, *(e for e in named if (e.value.part, e.value.kind) not in taken)]))


def with_part(evidence: Evidence[Region], parts: Sequence[Evidence[Part]]) -> Evidence[Region]:
    """The region with the named part that its middle lies in."""
    part = part_at(parts, [evidence.value.position_m])
    return evidence.model_copy(update={"value": evidence.value.model_copy(update={"part": part})})


def upright_requirement(anchors: Sequence[Evidence[Anchor]]) -> OrientationRequirement | None:
    """How far an open vessel may lean when it is half full: `atan(height / width)` of its largest volume."""
    volumes = [e.value for e in anchors if isinstance(e.value, ContainmentVolume)]
    if not volumes:
        return None
    outline = np.array(volumes[0].opening.outline_m)
    width = float(np.ptp(outline, axis=0).max())
    return OrientationRequirement(
        axis=volumes[0].direction, toward="up", within_rad=round(math.atan2(volumes[0].height_m, width), DIGITS)
    )


def _rims(volumes: Sequence[Evidence[Anchor]]) -> list[Evidence[Region]]:
    rims = []
    for evidence in volumes:
        inside = evidence.value
        assert isinstance(inside, ContainmentVolume), "of kind volume"
        loop = _rim_loop(inside)
        region = Region(
            kind="rim",
            affordance_id="",
            task="pour",
            interaction="tilt",
            position_m=_point(loop.mean(axis=0)),
            direction=inside.direction,
            outline_m=_line(loop),
            size_m=inside.passes_m,
            orientation=OrientationRequirement(axis=inside.direction, toward="horizontal", within_rad=LEVEL_RAD),
        )
        rims.append(inferred(region, f"rim of {inside.anchor_id}", evidence.confidence, inputs=(inside.anchor_id,)))
    return rims


def _spouts(volumes: Sequence[Evidence[Anchor]]) -> list[Evidence[Region]]:
    """Lips that stick out of a rim. A tube is a spout only by name: a slot in a wall is a second way out, too."""
    spouts = []
    for evidence in volumes:
        inside = evidence.value
        assert isinstance(inside, ContainmentVolume), "of kind volume"
        lip = find_spout(_rim_loop(inside))
        if lip is not None:
            tip, outward, ends = lip
            region = _spout(tip, outward, ends, float(np.linalg.norm(ends[-1] - ends[0])))
            spouts.append(inferred(region, f"lip of the rim of {inside.anchor_id}", BY_LIP, inputs=(inside.anchor_id,)))
    return spouts


def _spout(tip: FloatArray, outward: FloatArray, lip: FloatArray, width_m: float) -> Region:
    return Region(
        kind="spout",
        affordance_id="",
        task="pour",
        interaction="tilt",
        position_m=_point(tip),
        direction=_point(outward),
        outline_m=_line(lip),
        size_m=round(width_m, DIGITS),
        orientation=OrientationRequirement(axis=_point(outward), toward="down", within_rad=math.radians(60.0)),
    )


def _handles(through_holes: Sequence[ThroughHole], grip: ElongatedEnd | None) -> list[Evidence[Region]]:
    handles = []
    for hole in through_holes:
        if not is_handle(hole):
            continue
        region = Region(
            kind="handle",
            affordance_id="",
            task="carry",
            interaction="wrap",
            position_m=_point(hole.bar_at_m),
            direction=_point(hole.direction),
            outline_m=_line(hole.outline_m),
            size_m=round(hole.bar_m, DIGITS),
        )
        handles.append(measured(region, "a bar around a through-hole for fingers", confidence=BY_LOOP))
    if grip is not None:
        outward = grip.axis_m[-1] - grip.axis_m[0]
        region = Region(
            kind="handle",
            affordance_id="",
            task="carry",
            interaction="wrap",
            position_m=_point(0.5 * (grip.axis_m[0] + grip.axis_m[-1])),
            direction=_point(outward / np.linalg.norm(outward)),
            outline_m=_line(grip.axis_m),
            size_m=round(grip.width_m, DIGITS),
        )
        handles.append(measured(region, "thin, even end of an elongated object", confidence=BY_GRIP))
    return handles


def is_handle(hole: ThroughHole) -> bool:
    """Whether fingers go through a hole and around a bar on its outer side."""
    bar = max(hole.bar_m, hole.bar_depth_m) if np.isfinite(hole.bar_depth_m) else hole.bar_m
    fits = FINGERS_M <= hole.diameter_m <= ARM_M and BAR_M[0] <= hole.bar_m and bar <= BAR_M[1]
    return fits and hole.offset >= OFF_CENTRE


def _hang_holes(holes: Sequence[ThroughHole]) -> list[Evidence[Region]]:
    return [
        measured(
            Region(
                kind="hang_hole",
                affordance_id="",
                task="hang",
                interaction="hook",
                position_m=_point(hole.centre_m),
                direction=_point(hole.direction),
                outline_m=_line(hole.outline_m),
                size_m=round(hole.diameter_m, DIGITS),
                orientation=OrientationRequirement(
                    axis=_point(hole.direction), toward="horizontal", within_rad=LEVEL_RAD
                ),
            ),
            "through-hole in the silhouette",
            confidence=BY_HOLE,
        )
        for hole in holes[:HOLES]
        if hole.diameter_m >= HOOK_M
    ]


def _rim_loop(inside: ContainmentVolume) -> FloatArray:
    """(k, 3) the outline of the opening at the height of the rim."""
    x, y, z = inside.position_m
    outline = np.array(inside.opening.outline_m)
    return np.column_stack([outline + np.array([x, y]), np.full(len(outline), z + inside.height_m)])


def _numbered(regions: Sequence[Evidence[Region]]) -> list[Evidence[Region]]:
    """With ids `rim_0`, `rim_1`, `handle_0` ..., in order of discovery."""
    counts: dict[str, int] = {}
    named = []
    for evidence in regions:
        kind = evidence.value.kind
        region = evidence.value.model_copy(update={"affordance_id": f"{kind}_{counts.get(kind, 0)}"})
        counts[kind] = counts.get(kind, 0) + 1
        named.append(evidence.model_copy(update={"value": region}))
    return named


def _line(points: FloatArray) -> tuple[tuple[float, float, float], ...]:
    return tuple(_point(p) for p in points)


def _point(values: FloatArray) -> tuple[float, float, float]:
    return vec3(np.round(np.asarray(values, dtype=np.float64), DIGITS) + 0.0)
