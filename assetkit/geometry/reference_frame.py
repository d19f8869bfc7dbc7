"""Scale and pose of an object by its category: the frame that semantics, then interaction, give to canonicalize.

A reliable unit is never changed, and neither is an up axis from the user.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from assetkit.options import METERS_PER_UNIT, Options
from assetkit.pose.front import turn_to_front
from assetkit.pose.upright import UprightCandidate, least_probability, rank_upright
from assetkit.scale.declared_units import UnitDecision, is_reliable, with_repair
from assetkit.scale.metric_scale import ScaleEstimate, estimate_scale, is_normalised
from assetkit.scale.size_prior import CATEGORY_PRECISION
from assetkit.stage import Canonical, Draft, Frame, Interaction, Semantics
from assetkit.steps import Revision
from assetkit.taxonomy.tables import Category
from geom.features.upright_directions import upright_features
from geom.pose import shortest_rotation
from schemas.arrays import FloatArray
from schemas.asset import RepeatReason, UprightHypothesis, vec3
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence, default, inferred
from schemas.outcome import Repair

Z = np.array([0.0, 0.0, 1.0])
MIN_UP_CHANCE = 0.2  # Below this chance the way up of the source gets a warning, although no other one is certain.
MOST_UPRIGHTS = 4


@dataclass(frozen=True)
class FrameEstimate:
    """Scale and pose for the record, the frame that follows (None: that of the file), and findings for review."""

    scale: Evidence[float] | None
    upright: Evidence[tuple[float, float, float]]
    hypotheses: tuple[UprightHypothesis, ...]
    frame: Frame | None
    findings: tuple[Diagnostic, ...] = ()


def reference_frame(
    draft: Draft, category: Category | None, edges_m: tuple[float, float, float], options: Options
) -> FrameEstimate:
    """Scale and way up of a canonical object whose smallest box has sorted `edges_m`; `category` None when unknown."""
    canonical = draft[Canonical]
    scale = _scale(draft, canonical, category, edges_m)
    unit = _decision(scale, draft, known=category is not None) if scale is not None else None
    candidates = rank_upright(upright_features(canonical.solid), category, canonical.up_axis)
    best = candidates[0] if candidates else None
    least = 1.0 if best is None else least_probability(best, category, canonical.up_axis)
    turns = best is not None and best.probability >= least and not best.keeps_z and options.up_axis == "auto"
    R, notes = np.eye(3), ((), ())
    if best is not None and turns:
        R, notes = _turn(best), _turn_notes(best, least, canonical)
    frame = Frame(R @ canonical.R_AS, unit, *notes) if turns or unit is not None else None
    upright = _evidence(candidates, canonical, options, turned=turns)
    listed = tuple(
        UprightHypothesis(
            up=_in_source(h.up, canonical),
            chance=h.probability,
            signs=h.signs,
            alike=tuple(_in_source(other, canonical) for other in h.alike),
        )
        for h in candidates[:MOST_UPRIGHTS]
    )
    findings = () if turns or best is None else _review_findings(candidates, options)
    return FrameEstimate(scale.meters_per_unit if scale else None, upright, listed, frame, findings)


def revise_by_semantics(draft: Draft) -> Revision | None:
    """The frame that semantics decided, once; None where it keeps that of the file or another one holds already."""
    frame = draft[Semantics].frame
    if draft.frame is not None or frame is None:
        return None
    canonical = draft[Canonical]
    reasons: dict[RepeatReason, dict[str, float]] = {}
    if frame.unit is not None:
        before, after = canonical.meters_per_unit.value, frame.unit.meters_per_unit.value
        reasons[RepeatReason.UNIT] = {"meters_per_unit_before": before, "meters_per_unit_after": after}
    if (turn_deg := angle_deg(frame.R_AS @ canonical.R_AS.T)) > 0.0:
        reasons[RepeatReason.WAY_UP] = {"turn_deg": turn_deg}
    return Revision(frame, reasons)


def revise_by_front(draft: Draft) -> Revision | None:
    """The frame in which the front that the interaction stage found is +x; None when it already is, or is unknown."""
    canonical, front = draft[Canonical], draft[Interaction].front
    turned = None if front is None else turn_to_front(front)
    if turned is None:
        return None
    R, front = turned
    frame = replace(draft.frame or Frame(canonical.R_AS), R_AS=R @ canonical.R_AS, front=front)
    reason = {"turn_deg": angle_deg(R), "confidence": front.direction.confidence}
    return Revision(frame, {RepeatReason.FRONT: reason})


def angle_deg(R: FloatArray) -> float:
    """The angle (degrees, 0 to 180) of a rotation (3, 3), to 1e-4 degrees."""
    sine = np.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return round(float(np.degrees(np.arctan2(sine, np.trace(R) - 1.0))), 4)


def _scale(
    draft: Draft, canonical: Canonical, category: Category | None, edges_m: tuple[float, float, float]
) -> ScaleEstimate | None:
    """None where the unit is reliable, where several objects share it, and where only habits of tools are known."""
    unit, item = canonical.meters_per_unit, draft.intake
    if is_reliable(unit, item.model.meters_per_unit) or item.siblings:
        return None
    if category is None and not is_normalised(item.file_extent):
        return None
    stated = item.model.meters_per_unit
    implied = next((u for u, s in METERS_PER_UNIT.items() if s == stated.value), None)
    return estimate_scale(
        item.file_extent,
        [edge / unit.value for edge in edges_m],
        category,
        CATEGORY_PRECISION,
        format_=item.format,
        hints=item.model.hints,
        implied=implied if stated.source != "default" else None,
    )


def _decision(scale: ScaleEstimate, draft: Draft, *, known: bool) -> UnitDecision:
    """The unit by the category; with a repair where it is not the unit that the numbers imply."""
    evidence, implied = scale.meters_per_unit, draft.intake.model.meters_per_unit.value
    largest = max(draft.intake.file_extent)
    if not known:  # An unknown size is no reason to change the numbers.
        evidence = default(implied, evidence.method, bounds=evidence.bounds)
    sizes = [largest * s for s in (evidence.bounds or (evidence.value, evidence.value))]
    headline = f"no unit is declared; {scale.reading}" + ("; a person must say it with --units" if scale.review else "")
    note = finding(
        "asset/scale-unverified",
        headline,
        value=largest * evidence.value,
        bound=f"{sizes[0]:.3g}..{sizes[1]:.3g}",
        unit="m",
    )
    if abs(evidence.value / implied - 1.0) < 1e-6:
        return UnitDecision(evidence, (note,), review=scale.review)
    changed = with_repair(evidence, implied, draft.intake.file_extent, (note,))
    return UnitDecision(evidence, changed.diagnostics, changed.repairs, review=scale.review)


def _turn(best: UprightCandidate) -> FloatArray:
    """The least rotation (3, 3) that brings the way up to +z, exact for quarter turns."""
    R = shortest_rotation(np.array(best.up), Z)
    whole = np.rint(R)
    return whole if np.allclose(R, whole, atol=1e-9) else R


def _turn_notes(
    best: UprightCandidate, least: float, canonical: Canonical
) -> tuple[tuple[Diagnostic, ...], tuple[Repair, ...]]:
    degrees = float(np.degrees(np.arccos(np.clip(best.up[2], -1.0, 1.0))))
    signs = "; ".join(best.signs[:3])
    note = finding(
        "asset/turned-upright",
        f"the object lay by {degrees:.0f} degrees from its upright pose: standing, it {signs}",
        value=best.probability,
        bound=least,
        unit="probability of this way up",
    )
    size = canonical.section.extent_m.value
    repair = Repair(
        name="turn_upright",
        code="asset/turned-upright",
        stage="canonicalize",
        before={"degrees_from_upright": round(degrees, 3), "height_m": size[2]},
        after={"degrees_from_upright": 0.0, "height_m": _height(best, canonical)},
    )
    return (note,), (repair,)


def _height(best: UprightCandidate, canonical: Canonical) -> float:
    return float(np.ptp(np.concatenate([m.points for m in canonical.meshes]) @ np.array(best.up)))


def _evidence(
    candidates: tuple[UprightCandidate, ...], canonical: Canonical, options: Options, *, turned: bool
) -> Evidence[tuple[float, float, float]]:
    """The direction of the source that is up in the reference pose."""
    given = _in_source((0.0, 0.0, 1.0), canonical)
    if options.up_axis != "auto":
        return Evidence(value=given, source="declared", method=options.origin("up_axis"), confidence=1.0)
    if not candidates:
        return default(given, "no way up is meant, or the form tells none")
    chosen = candidates[0] if turned else next(h for h in candidates if h.keeps_z)
    value = _in_source(chosen.up, canonical) if turned else given
    return inferred(value, "up axis of the source, form and reference pose", chosen.probability, inputs=chosen.signs)


def _review_findings(candidates: tuple[UprightCandidate, ...], options: Options) -> tuple[Diagnostic, ...]:
    """A warning where the way up of the source is improbable, but no other one is sure enough to turn the object."""
    source_up_chance = sum(h.probability for h in candidates if h.keeps_z)
    if source_up_chance >= MIN_UP_CHANCE or candidates[0].probability <= 2.0 * source_up_chance:
        return ()
    where = "stated" if options.up_axis != "auto" else "of the file"
    headline = f"the way up {where} is improbable: another one would mean that it {'; '.join(candidates[0].signs[:3])}"
    return (
        finding(
            "asset/upright-uncertain",
            headline,
            value=source_up_chance,
            bound=MIN_UP_CHANCE,
            unit="probability of this way up",
        ),
    )


def _in_source(up: tuple[float, float, float], canonical: Canonical) -> tuple[float, float, float]:
    return vec3(np.round(canonical.R_AS.T @ np.array(up), 9) + 0.0)
