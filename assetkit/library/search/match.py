"""Matches one asset with one search criterion: the matching field of the record, its confidence and evidence."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from assetkit.annotate.annotator import UNKNOWN
from assetkit.annotate.name_reading import category_by_name
from assetkit.library.search.facts import Facts, RatedValue
from assetkit.library.search.query import Criterion

# Confidence of indirect evidence, as a factor: a mere hypothesis, an anchor instead of an affordance, a part usual for
# the category, nothing recorded that contradicts a negated criterion. Colours below FAINT_COLOUR of the surface are no
# match.
HYPOTHESIS, BY_ANCHOR, USUAL_PART, FAINT_COLOUR, NOT_CONTRADICTED = 0.5, 0.6, 0.3, 0.15, 0.7
PLACEHOLDER_FIGURE = 0.05  # Least confidence of a figure within the limits: one of confidence 0 still counts a little.
# The anchor that a task needs, used where no affordance was recorded.
ANCHOR_OF_TASK = {"pour": "volume", "fill": "volume", "stand on": "surface"}
_ANCHOR_WORDS = {"volume": "an inside with an opening", "surface": "a surface to stand things on"}


@dataclass(frozen=True)
class Match:
    """How an asset matches a criterion: `field`, `value` and `evidence` are the reason; `confidence` 0 is no match."""

    criterion: Criterion
    field: str
    value: str
    confidence: float
    evidence: str


TextHit = Mapping[str, tuple[str, float, str]]  # asset id -> field, confidence, matched words


def match_criterion(criterion: Criterion, asset: Facts, texts: Mapping[Criterion, TextHit]) -> Match:
    """The match of an asset. `texts` holds, for each criterion of field "text", the assets whose texts contain it."""
    if criterion.negated:
        return _negated(criterion, _match(criterion, asset, texts))
    return _match(criterion, asset, texts)


def _negated(criterion: Criterion, result: Match) -> Match:
    """The match of the opposite: another recorded value matches, an unknown one does not."""
    if result.confidence > 0.0 or result.value == UNKNOWN:
        return Match(criterion, result.field, result.value, 0.0, f"not to be so; {result.evidence}")
    return Match(criterion, result.field, result.value, NOT_CONTRADICTED, f"nothing says so; {result.evidence}")


def _match(criterion: Criterion, asset: Facts, texts: Mapping[Criterion, TextHit]) -> Match:
    match criterion.field:
        case "category":
            return _category(criterion, asset)
        case "family":
            return _named(criterion, "semantics.family", [asset.family])
        case "role":
            return _named(criterion, "semantics.roles", asset.roles)
        case "material":
            return _named(criterion, "physics.material", asset.materials)
        case "outcome":
            return _named(criterion, "outcome", [RatedValue(asset.outcome, 1.0, "record")])
        case "colour":
            return _colour(criterion, asset)
        case "size_m":
            return _figure(
                criterion, "geometry.extent_m", max(asset.extent_m), asset.extent_confidence, "m, longest edge"
            )
        case "height_m":
            return _figure(criterion, "geometry.extent_m", asset.extent_m[2], asset.extent_confidence, "m high")
        case "mass_kg":
            return _figure(criterion, "physics.mass_kg", asset.mass_kg, asset.mass_confidence, "kg")
        case "anchor":
            return _anchor(criterion, asset, criterion.values[0])
        case "task":
            return _task(criterion, asset)
        case "part":
            return _part(criterion, asset)
        case "text":
            field, confidence, words = texts[criterion].get(asset.asset_id, ("texts", 0.0, ""))
            return Match(criterion, field, words, confidence, "in the texts" if confidence else "not in the texts")


def _category(criterion: Criterion, asset: Facts) -> Match:
    field, category = "semantics.category", asset.category
    if category.value in criterion.values:
        return Match(criterion, field, category.value, category.confidence, category.method)
    likeliest = next(((name, p) for name, p in asset.possible[:1] if name in criterion.values), None)
    if likeliest is None or criterion.stated or category.value != UNKNOWN:
        return Match(criterion, field, category.value, 0.0, category.method)
    name, probability = likeliest
    evidence = f"category unknown: {category.method}"
    return Match(criterion, "semantics.hypotheses", name, HYPOTHESIS * probability, evidence)


def _named(criterion: Criterion, field: str, values: Iterable[RatedValue]) -> Match:
    """The matching value of highest confidence; without one no match, with all values of the asset."""
    listed = tuple(values)
    best = max((s for s in listed if s.value in criterion.values), key=lambda s: s.confidence, default=None)
    if best is not None:
        return Match(criterion, field, best.value, best.confidence, best.method)
    return Match(criterion, field, ", ".join(s.value for s in listed) or UNKNOWN, 0.0, "other than asked for")


def _colour(criterion: Criterion, asset: Facts) -> Match:
    field = "appearance.colours"
    if asset.colours is None:
        return Match(criterion, field, UNKNOWN, 0.0, "no material states a colour, or a picture was lost")
    share = max(asset.colours.get(value, 0.0) for value in criterion.values)
    shown = ", ".join(f"{name} {part:.0%}" for name, part in asset.colours.items())
    if share < FAINT_COLOUR:
        return Match(criterion, field, shown, 0.0, "share of the surface")
    return Match(criterion, field, shown, share, "share of the surface")


def _figure(criterion: Criterion, field: str, value: float, confidence: float, unit: str) -> Match:
    """A figure within the limits; one of confidence 0 (a placeholder) still counts a little."""
    inside = criterion.low <= value <= criterion.high
    weight = max(confidence, PLACEHOLDER_FIGURE) if inside else 0.0
    return Match(criterion, field, f"{value:.4g} {unit}", weight, f"{confidence:.0%} sure")


def _anchor(criterion: Criterion, asset: Facts, kind: str) -> Match:
    best = max((a for a in asset.anchors if a.value == kind), key=lambda a: a.confidence, default=None)
    if best is None:
        return Match(criterion, "anchors", "none", 0.0, f"{_ANCHOR_WORDS[kind]} was not found")
    return Match(criterion, "anchors", best.method, best.confidence, f"has {_ANCHOR_WORDS[kind]}")


def _task(criterion: Criterion, asset: Facts) -> Match:
    """By the affordances of the asset; where none is about the task, by the anchor that the task needs."""
    task = criterion.values[0]
    best = max((t for t in asset.tasks if task in t.value), key=lambda t: t.confidence, default=None)
    if best is not None:
        return Match(criterion, "affordances", best.value, best.confidence, best.method)
    if task not in ANCHOR_OF_TASK:
        return Match(criterion, "affordances", UNKNOWN, 0.0, f"nothing recorded about '{task}'")
    anchor = _anchor(criterion, asset, ANCHOR_OF_TASK[task])
    evidence = f"no affordance says so; {anchor.evidence}"
    return Match(criterion, "anchors", anchor.value, BY_ANCHOR * anchor.confidence, evidence)


def _part(criterion: Criterion, asset: Facts) -> Match:
    part = criterion.values[0]
    named = next((p for p in (*asset.parts, *(t.value for t in asset.tasks)) if part in p.lower()), None)
    if named is not None:
        return Match(criterion, "parts", named, 1.0, "named in the record")
    known = category_by_name(asset.category.value)
    if known is not None and part in known.parts:
        confidence = USUAL_PART * asset.category.confidence
        evidence = f"things of this category often have a {part}"
        return Match(criterion, "semantics.category", known.id, confidence, evidence)
    return Match(criterion, "parts", UNKNOWN, 0.0, f"no {part} recorded")
