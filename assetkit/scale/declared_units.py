"""Metres per source unit with evidence, from the user's option, the declared unit, texts, names and the size.

The user's unit wins. A declared unit is used as long as it gives a usual size; a size that no robot meets contradicts
it, and only a statement, a name or a doubled conversion factor resolves that. Where nothing is declared the same clues
decide, then the unit that the format's standard implies, and last the plausibility of the size, whose confidence stays
below 1. Where several units are plausible a person decides.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from assetkit.options import METERS_PER_UNIT, UnitName
from assetkit.scale.unit_clues import Extent, UnitClue, scaled_nodes, stated_in_name, stated_in_text
from assetkit.scale.unit_posterior import posterior, unit_prior
from schemas.diagnostics import Diagnostic, InvalidInput, Severity, finding
from schemas.evidence import Evidence, declared, default, inferred
from schemas.model import Node
from schemas.outcome import Repair

PLAUSIBLE_M = (1e-4, 1e4)  # Outside, nothing a robot handles or drives through: refused.
CREDIBLE_M = (1e-3, 100.0)  # Outside, no single prop or building: a contradiction.
USUAL_M = (5e-3, 5.0)  # Outside, a size deserves a look.
# Below, plausibility does not decide. A wrong unit is wrong by 2.5 in size and by 16 in mass at least, so that a guess
# must be clearly more probable than all other units together (3 : 2); habits are known no better than that.
MIN_POSTERIOR = 0.6
LEAST_UNIT_PROBABILITY = 0.05  # Units less probable than this are left out of the bounds.

_NAME = {0.001: "mm", 0.01: "cm", 0.0254: "in", 1.0: "m", 0.3048: "ft", 0.1: "dm", 1e-6: "um"}
_REPAIR_NAME = {0.001: "unit_mm", 0.01: "unit_cm", 0.0254: "unit_inch", 1.0: "unit_m"}


def is_reliable(unit: Evidence[float], stated: Evidence[float]) -> bool:
    """Whether the user, the file or its texts state the unit, not its format alone; however unusual the size is.

    `stated` is the unit by the file and its format alone.
    """
    if unit.source == "declared":
        return stated.source != "declared" or stated.confidence > 0.5 or unit.method != stated.method
    return unit.source == "inferred" and bool(unit.inputs)


@dataclass(frozen=True)
class UnitDecision:
    """Metres per source unit with its evidence and findings; `review`: a person must decide the unit."""

    meters_per_unit: Evidence[float]
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()
    review: bool = False


def decide_unit(
    *,
    stated: Evidence[float],
    chosen: UnitName = "auto",
    chosen_by: str = "--units",
    extent: Extent,
    format_: str,
    name: str = "",
    hints: Sequence[str] = (),
    nodes: Sequence[Node] = (),
) -> UnitDecision:
    """The unit of the source. `extent` is its bounding box in source units, `name` its path, `hints` its texts.

    `stated` with source `declared` and confidence above 0.5 is declared by the file; with 0.5 or less it is implied by
    the format's standard where the file declares none. Raises InvalidInput (`asset/scale-implausible`) when no reading
    of the numbers gives an object between 0.1 mm and 10 km.
    """
    if chosen != "auto":
        return _as_declared(declared(METERS_PER_UNIT[chosen], f"{chosen_by} {chosen}"), max(extent))
    clues = [*stated_in_text(hints, extent), *stated_in_name(name, extent)]
    if stated.source != "default" and stated.confidence > 0.5:
        return _declared(stated, [*clues, *scaled_nodes(nodes, stated.value)], extent)
    return _undeclared(stated, clues, format_, hints, extent)


def _declared(stated: Evidence[float], clues: list[UnitClue], extent: Extent) -> UnitDecision:
    """The declared unit, unless its size is unusual and the strongest other clue gives a usual one."""
    size = max(extent) * stated.value
    others = _strongest([c for c in clues if not math.isclose(c.meters_per_unit, stated.value, rel_tol=0.01)])
    statements = [c for c in others if c.confidence >= 0.9]
    if _within(size, USUAL_M):
        return UnitDecision(stated) if not statements else _against_texts(stated, statements, size)
    better = {c.meters_per_unit: c for c in others if _within(max(extent) * c.meters_per_unit, USUAL_M)}
    if len(better) == 1:
        clue = next(iter(better.values()))
        weaker = replace(clue, confidence=min(clue.confidence, 0.8))
        return _rescaled(weaker, stated.value, extent, against=f"the declared {_unit(stated.value)}")
    _require_plausible(max(extent), (stated.value,))
    if _within(size, CREDIBLE_M):
        return _as_declared(stated, max(extent))
    return _for_review(
        stated, extent, f"the declared unit makes the object {size:.3g} m large and nothing else tells its size"
    )


def _undeclared(
    stated: Evidence[float], clues: list[UnitClue], format_: str, hints: Sequence[str], extent: Extent
) -> UnitDecision:
    """The unit by the strongest clues; where there are none, by the standard or the plausibility of the size."""
    largest = max(extent)
    signs = _strongest(clues)
    sizes = {c.meters_per_unit: largest * c.meters_per_unit for c in signs}
    usual = [c for c in signs if _within(sizes[c.meters_per_unit], USUAL_M)]
    is_statement = any(c.confidence >= 0.9 for c in signs)
    credible = all(_within(size, CREDIBLE_M) for size in sizes.values())
    if len(sizes) == 1 and (usual or (is_statement and credible)):
        return _rescaled(signs[0], stated.value, extent)
    if len({c.meters_per_unit for c in usual}) == 1:
        return _rescaled(replace(usual[0], confidence=0.5), stated.value, extent, against="another statement")
    if is_statement:
        _require_plausible(largest, METERS_PER_UNIT.values())
        quotes = ", ".join(f"'{c.quote}'" for c in signs)
        return _for_review(stated, extent, f"what the file says about its unit does not fit: {quotes}")
    return _by_size(stated, format_, hints, extent)


def _strongest(clues: list[UnitClue]) -> list[UnitClue]:
    return [c for c in clues if c.confidence == max(d.confidence for d in clues)]


def _as_declared(evidence: Evidence[float], largest: float) -> UnitDecision:
    """A declared unit is used unchanged; an unusual size is reported, an impossible one refused."""
    _require_plausible(largest, (evidence.value,))
    size_m = largest * evidence.value
    if _within(size_m, USUAL_M):
        return UnitDecision(evidence)
    warning = finding(
        "asset/scale-unverified",
        f"the unit {_unit(evidence.value)} makes the object {size_m:.3g} m large, which is unusual",
        value=size_m,
        bound=f"{USUAL_M[0]:g}..{USUAL_M[1]:g}",
        unit="m",
    )
    return UnitDecision(evidence.model_copy(update={"confidence": min(evidence.confidence, 0.5)}), (warning,))


def _against_texts(stated: Evidence[float], statements: list[UnitClue], size: float) -> UnitDecision:
    """The declared unit against texts with another one: it is kept, since its size is usual, with a finding."""
    note = finding(
        "asset/contradictory-evidence",
        f"the file declares {_unit(stated.value)}, which gives a usual size, but says '{statements[0].quote}'",
        value=size,
        bound=f"{size / stated.value * statements[0].meters_per_unit:.4g} by that text",
        unit="m",
    )
    quotes = (*stated.inputs, *(c.quote for c in statements))
    return UnitDecision(stated.model_copy(update={"confidence": 0.8, "inputs": quotes}), (note,))


def _for_review(stated: Evidence[float], extent: Extent, headline: str) -> UnitDecision:
    """The stated unit as a placeholder of confidence 0, bounded by the units of usual size; a person must decide."""
    largest = max(extent)
    fitting = [s for s in METERS_PER_UNIT.values() if _within(largest * s, USUAL_M)]
    bounds = (min(*fitting, stated.value), max(*fitting, stated.value)) if fitting else None
    note = finding(
        "asset/contradictory-evidence",
        f"{headline}; say the unit with --units",
        value=largest * stated.value,
        bound=f"{CREDIBLE_M[0]:g}..{CREDIBLE_M[1]:g}",
        unit="m",
    )
    return UnitDecision(stated.model_copy(update={"confidence": 0.0, "bounds": bounds}), (note,), review=True)


def _by_size(stated: Evidence[float], format_: str, hints: Sequence[str], extent: Extent) -> UnitDecision:
    """The unit by tool, format and plausible size. An undecided one keeps confidence 0 and bounds."""
    largest = max(extent)
    _require_plausible(largest, METERS_PER_UNIT.values())
    implied = next((u for u, s in METERS_PER_UNIT.items() if s == stated.value), "m")
    by_standard = stated.source != "default"
    share = posterior(unit_prior(format_, hints, implied if by_standard else None), extent)
    holds = by_standard and _within(largest * stated.value, CREDIBLE_M)
    unit = implied if holds else _most_credible(share, implied)
    scale = METERS_PER_UNIT[unit]
    candidates = {u: p for u, p in share.items() if p >= LEAST_UNIT_PROBABILITY or u == unit}
    spanned = [METERS_PER_UNIT[u] for u in candidates]
    bounds = (min(spanned), max(spanned)) if len(spanned) > 1 else None
    usual = _within(largest * scale, USUAL_M)
    if not _within(largest * scale, CREDIBLE_M):
        return _for_review(stated, extent, f"no unit is declared and no reading of {largest:.3g} units is credible")
    if by_standard and unit == implied:
        evidence = stated.model_copy(update={"bounds": bounds, "confidence": stated.confidence if usual else 0.25})
    elif share[unit] >= MIN_POSTERIOR:
        worth = 0.8 * share[unit] if usual else 0.4
        evidence = inferred(scale, "habit of tool or format and plausible size", worth, bounds=bounds)
    else:
        evidence = default(scale, "no unit declared and the size fits several", bounds=bounds)
        return _ambiguous(evidence, candidates, stated.value, extent)
    note = _provisional(evidence, share[unit], largest)
    if unit != implied:
        return with_repair(evidence, stated.value, extent, (note,))
    if by_standard and usual:
        return UnitDecision(evidence)
    sure = evidence.source == "inferred" and usual
    return UnitDecision(evidence, (note.model_copy(update={"severity": Severity.INFO}) if sure else note,))


def _most_credible(share: dict[str, float], implied: str) -> str:
    """The most probable unit; else the implied unit, unless that is too improbable as a placeholder."""
    best = max(share, key=lambda u: share[u])
    return implied if share[best] < MIN_POSTERIOR and share[implied] >= LEAST_UNIT_PROBABILITY else best


def _ambiguous(
    placeholder: Evidence[float], candidates: dict[str, float], implied: float, extent: Extent
) -> UnitDecision:
    """The `placeholder`, and all `candidates` with size and probability: a person must decide."""
    largest = max(extent)
    by_share = sorted(candidates, key=lambda u: -candidates[u])
    readings = ", ".join(f"{u} {_size(largest * METERS_PER_UNIT[u])} ({candidates[u]:.0%})" for u in by_share)
    note = finding(
        "asset/scale-unverified",
        f"no unit is declared and the size fits several: {readings}; a person must say it with --units",
        value=round(candidates[by_share[0]], 3),
        bound=MIN_POSTERIOR,
        unit="probability of the first",
    )
    if math.isclose(placeholder.value, implied, rel_tol=1e-6):
        return UnitDecision(placeholder, (note,), review=True)
    return replace(with_repair(placeholder, implied, extent, (note,)), review=True)


def _size(size_m: float) -> str:
    return f"{size_m:.3g} m" if size_m >= 1.0 else f"{1000.0 * size_m:.3g} mm"


def _provisional(evidence: Evidence[float], posterior: float, largest: float) -> Diagnostic:
    unit = _unit(evidence.value)
    return finding(
        "asset/scale-unverified",
        f"no unit is declared; read in {unit} the object is {largest * evidence.value:.3g} m large",
        value=round(posterior, 3),
        bound=MIN_POSTERIOR,
        unit="probability of this unit",
    )


def _rescaled(clue: UnitClue, implied: float, extent: Extent, against: str = "") -> UnitDecision:
    """The unit of a clue instead of the `implied` one. `against` names the unit that it overrides, if any."""
    size = max(extent) * clue.meters_per_unit
    rescaled = _as_declared(
        inferred(clue.meters_per_unit, clue.method, clue.confidence, inputs=(clue.quote,)), max(extent)
    )
    evidence, notes = rescaled.meters_per_unit, rescaled.diagnostics
    if against:
        headline = f"'{clue.quote}' against {against}: only {_unit(clue.meters_per_unit)} gives a usual size"
        bound = f"{USUAL_M[0]:g}..{USUAL_M[1]:g}"
        notes += (finding("asset/contradictory-evidence", headline, value=size, bound=bound, unit="m"),)
    if math.isclose(clue.meters_per_unit, implied, rel_tol=1e-6):
        return UnitDecision(evidence, notes)
    return with_repair(evidence, implied, extent, notes)


def with_repair(
    evidence: Evidence[float], implied: float, extent: Extent, notes: tuple[Diagnostic, ...]
) -> UnitDecision:
    """The decision for `evidence`, with the repair from the `implied` unit (metres)."""
    size, before = max(extent) * evidence.value, max(extent) * implied
    note = finding(
        "asset/unit-mismatch",
        f"the numbers are in {_unit(evidence.value)}, not in {_unit(implied)} ({evidence.method})",
        value=size,
        bound=f"{before:.4g} as they stand",
        unit="m",
    )
    repair = Repair(
        name=_REPAIR_NAME.get(evidence.value, "unit_scale"),
        code="asset/unit-mismatch",
        stage="canonicalize",
        before={"largest_extent_m": before},
        after={"largest_extent_m": size},
    )
    return UnitDecision(evidence, (note, *notes), (repair,))


def _require_plausible(largest: float, hypotheses: object) -> None:
    sizes = [largest * h for h in hypotheses]  # pyright: ignore[reportGeneralTypeIssues]
    if not any(_within(s, PLAUSIBLE_M) for s in sizes):
        raise InvalidInput(
            finding(
                "asset/scale-implausible",
                f"the largest extent of {largest:.3g} units is between {min(sizes):.2g} m and {max(sizes):.2g} m",
                value=largest,
                bound=f"{PLAUSIBLE_M[0]:g}..{PLAUSIBLE_M[1]:g} m",
                unit="source units",
            )
        )


def _within(size_m: float, bounds: tuple[float, float]) -> bool:
    return bounds[0] * (1 - 1e-6) <= size_m <= bounds[1] * (1 + 1e-6)


def _unit(meters: float) -> str:
    return _NAME.get(meters) or f"units of {meters:.4g} m"
