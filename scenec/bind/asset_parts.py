"""Parts and affordances of an asset as directions: where each lies from the origin of the asset frame (metres)."""

from __future__ import annotations

from math import atan2, hypot

import numpy as np

from scenec.ir.problem import Body
from schemas.affordances import Region
from schemas.asset import AssetRecord
from schemas.diagnostics import InvalidInput, finding
from schemas.parts import UNLABELLED
from source.hint import did_you_mean

LEAST_M = 2e-3  # a part nearer to the vertical through the origin has no direction
AssetParts = tuple[tuple[str, tuple[float, float]], ...]  # names, each with the middle in x and y


def asset_parts(record: AssetRecord, scale: float, moved: bool) -> AssetParts:
    """Names of parts (its own, its label, its id) and of affordances (its kind, its id), each with its middle in the
    asset frame; the first of a name counts. Those on links are left out where joints have moved them."""
    middles: dict[str, tuple[float, float]] = {}
    for evidence in record.parts:
        part = evidence.value
        if moved and part.link is not None:
            continue
        low, high = np.array(part.low_m), np.array(part.high_m)
        x, y, _ = (scale * 0.5 * (low + high)).tolist()
        for name in {part.name, part.label.value, part.part_id} - {UNLABELLED}:
            middles.setdefault(name, (x, y))
    for evidence in record.affordances:
        region = evidence.value
        if isinstance(region, Region) and not (moved and region.joint is not None):
            x, y, _ = (scale * v for v in region.position_m)
            for name in (region.kind, region.affordance_id):
                middles.setdefault(name, (x, y))
    return tuple(middles.items())


def heading_of_part(body: Body, part: str, is_upright: bool) -> float:
    """Heading (rad) of a part from the origin of a body at yaw 0. Raises InvalidInput (`scene/unknown-part`,
    `scene/part-without-direction`)."""
    middles = dict(body.parts)
    if part not in middles:
        there = f"it has {', '.join(sorted(middles))}" if middles else "its record has none"
        headline = f"`{body.asset_id}` has no part or affordance `{part}`{did_you_mean(part, middles)}; {there}"
        raise InvalidInput(finding("scene/unknown-part", headline, bound=", ".join(sorted(middles)) or None))
    x, y = middles[part]
    if not is_upright or hypot(x, y) < LEAST_M:
        why = "the object may be turned over" if not is_upright else "it lies over the origin"
        headline = f"`{part}` of `{body.asset_id}` has no direction: {why}"
        raise InvalidInput(finding("scene/part-without-direction", headline))
    return atan2(y, x)
