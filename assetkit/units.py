"""Which unit are the numbers in? Declared units are used; otherwise named evidence, never a silent guess."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from assetkit.options import METERS_PER_UNIT, UnitName
from schemas.diagnostics import Diagnostic, InvalidInput, Severity, finding
from schemas.evidence import Evidence, declared, default, inferred
from schemas.outcome import Repair

PLAUSIBLE_M = (1e-4, 1e4)  # Outside, nothing a robot handles or drives through.
USUAL_M = (2e-3, 5.0)  # Outside, a declared size deserves a look.
MIN_POSTERIOR = 0.6  # Below, the metre is kept and the scale is called unverified.

_TYPICAL_SIZE_M, _LOG_SPREAD = 0.15, 1.2  # Largest extent of household objects: median and spread of its logarithm.
_PRIORS = {
    "stl": {"m": 0.20, "cm": 0.05, "mm": 0.70, "in": 0.05},  # Printing and CAD write millimetres, robotics metres.
    "other": {"m": 0.50, "cm": 0.25, "mm": 0.15, "in": 0.10},
}
# A designed length is round in the designer's unit: how much more likely a reading is that makes it so.
_ROUND_LENGTH, _BINARY_FRACTIONS = 5.0, 3.0
_NAMES = {
    "mm": r"mm|millimet(?:er|re)s?",
    "cm": r"cm|centimet(?:er|re)s?",
    "in": r"inch(?:es)?|in(?=\s*$|\s*[;,.)])",
    "m": r"met(?:er|re)s?|m(?=\s*$|\s*[;,.)])",
}
_STATEMENT = r"\b(?:units?|scale|exported|measured|dimensions?|coordinates?|lengths?)\b[^\n]{{0,24}}?\b(?:{name})\b"
_REPAIR_NAME = {"mm": "unit_mm", "cm": "unit_cm", "in": "unit_inch"}


@dataclass(frozen=True)
class UnitDecision:
    """Metres per source unit with its evidence, and what the user should know."""

    meters_per_unit: Evidence[float]
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()


def decide_unit(
    *,
    stated: Evidence[float],
    chosen: UnitName,
    extent: tuple[float, float, float],
    format_: str,
    stem: str,
    hints: tuple[str, ...],
) -> UnitDecision:
    """The unit of the source, from the user, the file, its comments, its name or the plausibility of its size.

    `extent` is the bounding box in source units. Raises InvalidInput (`asset/scale-implausible`) when no reading of
    the numbers gives an object between 0.1 mm and 10 km.
    """
    largest = max(extent)
    if chosen != "auto":
        return _checked(declared(METERS_PER_UNIT[chosen], f"--units {chosen}"), largest)
    if stated.source != "default":
        return _checked(stated, largest)
    _require_plausible(largest, METERS_PER_UNIT.values())
    said = _stated_in_text(hints)
    if said is not None:
        return _rescaled(said, 0.9, "comment or header of the file", extent)
    named = _stated_in_name(stem, extent)
    if named is not None:
        return _rescaled(named, 0.9, "size named in the file name", extent)
    return _by_size(extent, format_)


def _checked(evidence: Evidence[float], largest: float) -> UnitDecision:
    """A declared unit is used as it is; an unusual size is reported, an impossible one refused."""
    _require_plausible(largest, (evidence.value,))
    size_m = largest * evidence.value
    if USUAL_M[0] <= size_m <= USUAL_M[1]:
        return UnitDecision(evidence)
    warning = finding(
        "asset/scale-unverified",
        f"declared units make the object {size_m:.3g} m large, which is unusual",
        value=size_m,
        bound=f"{USUAL_M[0]:g}..{USUAL_M[1]:g}",
        unit="m",
    )
    return UnitDecision(evidence.model_copy(update={"confidence": 0.5}), (warning,))


def _require_plausible(largest: float, hypotheses: object) -> None:
    sizes = [largest * h for h in hypotheses]  # pyright: ignore[reportGeneralTypeIssues]
    if not any(PLAUSIBLE_M[0] <= s <= PLAUSIBLE_M[1] for s in sizes):
        raise InvalidInput(
            finding(
                "asset/scale-implausible",
                f"the largest extent of {largest:.3g} units is between {min(sizes):.2g} m and {max(sizes):.2g} m",
                value=largest,
                bound=f"{PLAUSIBLE_M[0]:g}..{PLAUSIBLE_M[1]:g} m",
                unit="source units",
            )
        )


def _stated_in_text(hints: tuple[str, ...]) -> str | None:
    """The unit a comment states, when all statements agree."""
    text = "\n".join(hints).lower()
    found = {unit for unit, name in _NAMES.items() if re.search(_STATEMENT.format(name=name), text, re.MULTILINE)}
    return found.pop() if len(found) == 1 else None


def _stated_in_name(stem: str, extent: tuple[float, float, float]) -> str | None:
    """The unit of a size in the file name ("20mm-cube") when the mesh has that number as an extent."""
    for number, unit in re.findall(r"(\d+(?:[.,]\d+)?)\s*_?(mm|cm|in|inch)(?![a-z])", stem.lower()):
        value = float(number.replace(",", "."))
        if any(math.isclose(value, e, rel_tol=0.03) for e in extent):
            return "in" if unit == "inch" else unit
    return None


def _by_size(extent: tuple[float, float, float], format_: str) -> UnitDecision:
    """Bayes over unit hypotheses: prior of the format, how usual the resulting size is, how round the lengths are."""
    prior = _PRIORS.get(format_, _PRIORS["other"])
    largest = max(extent)
    weight = {
        unit: p
        * math.exp(-0.5 * (math.log(largest * METERS_PER_UNIT[unit] / _TYPICAL_SIZE_M) / _LOG_SPREAD) ** 2)
        * _roundness(extent, unit)
        for unit, p in prior.items()
    }
    total = sum(weight.values()) or 1.0
    best = max(weight, key=lambda u: weight[u])
    posterior = weight[best] / total
    if best != "m" and posterior >= MIN_POSTERIOR:
        return _rescaled(best, 0.8 * posterior, "format habit and plausible size", extent)
    candidates = [METERS_PER_UNIT[u] for u, w in weight.items() if w / total >= 0.05] or [1.0]
    bounds = (min(*candidates, 1.0), max(*candidates, 1.0))
    confident = best == "m" and posterior >= MIN_POSTERIOR
    evidence = (
        inferred(1.0, "plausible size in metres", 0.8 * posterior, bounds=bounds)
        if confident
        else default(1.0, "no unit declared and the size fits several", bounds=bounds)
    )
    note = finding(
        "asset/scale-unverified",
        f"no unit is declared; read as metres the object is {largest:.3g} m large",
        value=posterior,
        bound=MIN_POSTERIOR,
        unit="probability of the best unit",
        severity=Severity.INFO if confident else None,
    )
    return UnitDecision(evidence, (note,))


def _roundness(extent: tuple[float, float, float], unit: str) -> float:
    """How much the lengths speak for a unit: lengths that become whole half-millimetres without being round as they
    stand (1.33858 in is 34 mm), or sixteenths that nobody writes in metric units (1.375).
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


def _is_multiple(value: float, step: float, tolerance: float) -> bool:
    return abs(value - step * round(value / step)) <= tolerance


def _rescaled(unit: str, confidence: float, method: str, extent: tuple[float, float, float]) -> UnitDecision:
    scale = METERS_PER_UNIT[unit]
    evidence = inferred(scale, method, confidence)
    if unit == "m":
        return UnitDecision(evidence)
    size = max(extent)
    note = finding(
        "asset/unit-mismatch",
        f"the numbers are in {unit}, not in metres ({method})",
        value=size * scale,
        bound=f"{size:.4g} if read as metres",
        unit="m",
    )
    extra = (
        ()
        if confidence >= 0.8
        else (
            finding(
                "asset/scale-unverified",
                f"the unit {unit} follows from plausibility only",
                value=round(confidence, 3),
                bound=0.8,
                unit="confidence",
            ),
        )
    )
    repair = Repair(
        name=_REPAIR_NAME[unit],
        code="asset/unit-mismatch",
        stage="canonicalize",
        before={"largest_extent_m": size},
        after={"largest_extent_m": size * scale},
    )
    return UnitDecision(evidence, (note, *extra), (repair,))
