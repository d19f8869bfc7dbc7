"""Regions from named parts (lids to open, knobs to turn, buttons to press), and the part that a position belongs to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.affordances import WHOLE, Interaction, OrientationRequirement, Region, RegionKind, Task
from schemas.arrays import FloatArray
from schemas.asset import vec3
from schemas.evidence import Evidence, inferred
from schemas.parts import UNLABELLED, Part

DIGITS = 6  # of recorded lengths in metres: a micrometre
BY_NAME = 0.9  # of the confidence of the part's label
WITHIN_M = 0.003
# Label of a part, kind of region, task, interaction.
TABLE: tuple[tuple[str, RegionKind, Task, Interaction], ...] = (
    ("handle", "handle", "carry", "wrap"),
    ("spout", "spout", "pour", "tilt"),
    ("lid", "lid", "open", "lift_off"),
    ("cap", "lid", "open", "twist"),
    ("knob", "knob", "turn", "twist"),
    ("button", "button", "press", "push"),
)


def named_regions(parts: Sequence[Evidence[Part]], low_m: FloatArray, high_m: FloatArray) -> list[Evidence[Region]]:
    """A region for each part whose label is in `TABLE`; `low_m`, `high_m` (3,) are the corners of the object."""
    regions = []
    for label, kind, task, interaction in TABLE:
        for part in parts:
            if part.value.label.value == label and part.value.label.confidence > 0.0:
                region = _region(part.value, kind, task, interaction, 0.5 * (low_m + high_m))
                confidence = round(BY_NAME * part.value.label.confidence, 3)
                regions.append(inferred(region, f"part called {label}", confidence, inputs=(part.value.part_id,)))
    return regions


def part_at(parts: Sequence[Evidence[Part]], places_m: Sequence[Sequence[float]]) -> str:
    """The labelled part whose box, the smallest of several, contains all positions; `WHOLE` when none does."""
    holding = [
        (float(np.prod(np.subtract(p.value.high_m, p.value.low_m))), p.value.part_id)
        for p in parts
        if p.value.label.value != UNLABELLED
        and (np.asarray(places_m) >= np.array(p.value.low_m) - WITHIN_M).all()
        and (np.asarray(places_m) <= np.array(p.value.high_m) + WITHIN_M).all()
    ]
    return min(holding)[1] if holding else WHOLE


def _region(part: Part, kind: RegionKind, task: Task, interaction: Interaction, centre_m: FloatArray) -> Region:
    """The part's box: its middle, its longest axis, and the way out of the object along an axis of the asset frame."""
    low, high = np.array(part.low_m), np.array(part.high_m)
    middle, edges = 0.5 * (low + high), high - low
    apart = middle - centre_m
    outward = np.zeros(3)
    axis = 2 if kind == "lid" else int(np.abs(apart).argmax())
    outward[axis] = 1.0 if kind == "lid" or apart[axis] >= 0.0 else -1.0
    along = np.zeros(3)
    along[int(edges.argmax())] = 0.5 * edges.max()
    pour = OrientationRequirement(axis=_point(outward), toward="down", within_rad=1.0) if task == "pour" else None
    return Region(
        kind=kind,
        affordance_id="",
        part=part.part_id,
        task=task,
        interaction=interaction,
        position_m=_point(middle),
        direction=_point(outward),
        outline_m=(_point(middle - along), _point(middle + along)),
        size_m=round(float(edges.min()), DIGITS),
        orientation=pour,
    )


def _point(values: FloatArray) -> tuple[float, float, float]:
    return vec3(np.round(np.asarray(values, dtype=np.float64), DIGITS) + 0.0)
