"""Posterior probability of each unit where none is stated, from tool, format, usual sizes and round lengths."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from assetkit.options import METERS_PER_UNIT
from assetkit.readers.by_format import CAD_FORMATS

TYPICAL_SIZE_M, LOG_SPREAD = 0.15, 1.2  # Largest extent of household objects: median and spread of its logarithm.
_STANDARD_SHARE = 0.7  # Prior of the unit that a format's own standard implies where the file leaves it out.
# A designed length is round in the designer's unit: likelihood ratio of a unit in which it is round.
_ROUND_LENGTH, _BINARY_FRACTIONS = 5.0, 3.0
# A cube, ball or cylinder of side 1 or 2 is what modelling tools start with, in their scene units, which are metres.
_PRIMITIVE, _PRIMITIVE_SIDES = 5.0, (1.0, 2.0)

# Prior probability of each unit, by the tool that wrote the file, else by its format.
_CAD = {"m": 0.20, "cm": 0.05, "mm": 0.70, "in": 0.05}
_METRIC = {"m": 0.60, "cm": 0.10, "mm": 0.25, "in": 0.05}
_UNKNOWN = {"m": 0.50, "cm": 0.25, "mm": 0.15, "in": 0.10}
_CAD_TOOLS = re.compile(
    r"solidworks|\brhino|fusion ?360|onshape|\bcreo\b|catia|autodesk inventor|autocad|freecad|openscad|tinkercad"
    r"|\batf\b|slic3r|prusaslicer|\bcura\b|makerbot|materialise|netfabb|meshmixer"
)
_METRIC_TOOLS = re.compile(r"blender|open3d|\btrimesh\b|gazebo")


def unit_prior(format_: str, texts: Sequence[str], implied: str | None = None) -> dict[str, float]:
    """Prior probabilities of m, cm, mm and in by the habit of the tool named in `texts`, else of the format; sums to 1.

    `implied` is the unit that the format's standard prescribes, if it does.
    """
    text = "\n".join(texts).lower()
    if _CAD_TOOLS.search(text):
        prior = _CAD
    elif _METRIC_TOOLS.search(text):
        prior = _METRIC
    else:
        prior = _CAD if format_ in CAD_FORMATS else _UNKNOWN  # Printing and CAD write millimetres, robotics metres.
    if implied is None:
        return prior
    others = sum(p for u, p in prior.items() if u != implied)
    return {u: (1 - _STANDARD_SHARE) * p / others for u, p in prior.items()} | {implied: _STANDARD_SHARE}


def posterior(prior: dict[str, float], extent: tuple[float, float, float]) -> dict[str, float]:
    """Probability of each unit of `prior`, given the extent in source units: usual sizes and round lengths win."""
    weight = {
        unit: p
        * math.exp(-0.5 * (math.log(max(extent) * METERS_PER_UNIT[unit] / TYPICAL_SIZE_M) / LOG_SPREAD) ** 2)
        * roundness(extent, unit)
        * (_PRIMITIVE if unit == "m" and prior is not _CAD and _is_primitive(extent) else 1.0)
        for unit, p in prior.items()
    }
    total = sum(weight.values()) or 1.0
    return {unit: w / total for unit, w in weight.items()}


def roundness(extent: tuple[float, float, float], unit: str) -> float:
    """Likelihood of the lengths in a unit: higher for lengths that become multiples of 0.5 mm without being round
    in source units (1.33858 in is 34 mm), and for sixteenths, which are rare in metric units (1.375).
    """
    mm = [e * METERS_PER_UNIT[unit] * 1000.0 for e in extent]
    telling = [
        not _is_multiple(e, 0.01, 1e-4) and _is_multiple(m, 0.5, 1e-5 * max(m, 1.0))
        for e, m in zip(extent, mm, strict=True)
    ]
    likelihood = _ROUND_LENGTH ** min(sum(telling), 2)
    sixteenths = all(_is_multiple(e, 1 / 16, 1e-6) for e in extent) and not all(
        _is_multiple(e, 0.5, 1e-6) for e in extent
    )
    return likelihood * (_BINARY_FRACTIONS if unit == "in" and sixteenths else 1.0)


def _is_primitive(extent: tuple[float, float, float]) -> bool:
    return any(all(math.isclose(e, side, rel_tol=1e-5) for e in extent) for side in _PRIMITIVE_SIDES)


def _is_multiple(value: float, step: float, tolerance: float) -> bool:
    return abs(value - step * round(value / step)) <= tolerance
