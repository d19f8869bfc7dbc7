"""Does an asset grant a wish? Each answer says what in the record speaks for it, and how sure that is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from assetkit.annotate.annotator import UNKNOWN
from assetkit.annotate.name_reading import category_called
from assetkit.library.search.facts import Facts, Sure
from assetkit.library.search.query import Wish

# How far an indirect sign counts against a direct one.
CHANCE, BY_SHAPE, USUAL_PART, FAINT_COLOUR, NOT_SO = 0.5, 0.6, 0.3, 0.15, 0.7
# What a task needs where no affordance was recorded: an opening for what goes in and out, a face for what stands on it.
_ANCHOR_OF_TASK = {"pour": "volume", "fill": "volume", "stand on": "surface"}
_ANCHOR_WORDS = {"volume": "an inside with an opening", "surface": "a surface to stand things on"}


@dataclass(frozen=True)
class Answer:
    """An asset's answer to one wish: `confidence` 0 is no; `field`, `value` and `evidence` say why, or why not."""

    wish: Wish
    field: str
    value: str
    confidence: float
    evidence: str


TextHit = Mapping[str, tuple[str, float, str]]  # asset id -> field, confidence, words found


def judge(wish: Wish, asset: Facts, texts: Mapping[Wish, TextHit]) -> Answer:
    """The answer of an asset. `texts` holds, for wishes that ask for a text, the assets whose texts hold it."""
    if wish.denied:
        return _denied(wish, _granted(wish, asset, texts))
    return _granted(wish, asset, texts)


def _denied(wish: Wish, answer: Answer) -> Answer:
    """The answer to the opposite: what is recorded otherwise grants it, what nobody knows does not."""
    if answer.confidence > 0.0 or answer.value == UNKNOWN:
        return Answer(wish, answer.field, answer.value, 0.0, f"not to be so; {answer.evidence}")
    return Answer(wish, answer.field, answer.value, NOT_SO, f"nothing says so; {answer.evidence}")


def _granted(wish: Wish, asset: Facts, texts: Mapping[Wish, TextHit]) -> Answer:
    match wish.field:
        case "category":
            return _category(wish, asset)
        case "family":
            return _named(wish, "semantics.family", [asset.family])
        case "role":
            return _named(wish, "semantics.roles", asset.roles)
        case "material":
            return _named(wish, "physics.material", asset.materials)
        case "outcome":
            return _named(wish, "outcome", [Sure(asset.outcome, 1.0, "record")])
        case "colour":
            return _colour(wish, asset)
        case "size_m":
            return _figure(wish, "geometry.extent_m", max(asset.extent_m), asset.extent_confidence, "m, longest edge")
        case "height_m":
            return _figure(wish, "geometry.extent_m", asset.extent_m[2], asset.extent_confidence, "m high")
        case "mass_kg":
            return _figure(wish, "physics.mass_kg", asset.mass_kg, asset.mass_confidence, "kg")
        case "anchor":
            return _anchor(wish, asset, wish.values[0])
        case "task":
            return _task(wish, asset)
        case "part":
            return _part(wish, asset)
        case "text":
            field, confidence, found = texts[wish].get(asset.asset_id, ("texts", 0.0, ""))
            return Answer(wish, field, found, confidence, "in the texts" if confidence else "not in the texts")


def _category(wish: Wish, asset: Facts) -> Answer:
    field, said = "semantics.category", asset.category
    if said.value in wish.values:
        return Answer(wish, field, said.value, said.confidence, said.method)
    likeliest = next(((name, chance) for name, chance in asset.possible[:1] if name in wish.values), None)
    if likeliest is None or wish.stated or said.value != UNKNOWN:
        return Answer(wish, field, said.value, 0.0, said.method)
    name, chance = likeliest
    return Answer(wish, "semantics.hypotheses", name, CHANCE * chance, f"category unknown: {said.method}")


def _named(wish: Wish, field: str, said: Iterable[Sure]) -> Answer:
    """The surest of the values that are wanted; else what is there instead."""
    listed = tuple(said)
    best = max((s for s in listed if s.value in wish.values), key=lambda s: s.confidence, default=None)
    if best is not None:
        return Answer(wish, field, best.value, best.confidence, best.method)
    return Answer(wish, field, ", ".join(s.value for s in listed) or UNKNOWN, 0.0, "other than asked for")


def _colour(wish: Wish, asset: Facts) -> Answer:
    field = "appearance.colours"
    if asset.colours is None:
        return Answer(wish, field, UNKNOWN, 0.0, "no material states a colour, or a picture was lost")
    share = max(asset.colours.get(value, 0.0) for value in wish.values)
    shown = ", ".join(f"{name} {part:.0%}" for name, part in asset.colours.items())
    if share < FAINT_COLOUR:
        return Answer(wish, field, shown, 0.0, "share of the surface")
    return Answer(wish, field, shown, share, "share of the surface")


def _figure(wish: Wish, field: str, value: float, confidence: float, unit: str) -> Answer:
    """A figure of which nobody is sure still counts a little: its placeholder lies within the limits."""
    inside = wish.low <= value <= wish.high
    sureness = f"{confidence:.0%} sure"
    return Answer(wish, field, f"{value:.4g} {unit}", max(confidence, 0.05) if inside else 0.0, sureness)


def _anchor(wish: Wish, asset: Facts, kind: str) -> Answer:
    best = max((a for a in asset.anchors if a.value == kind), key=lambda a: a.confidence, default=None)
    if best is None:
        return Answer(wish, "anchors", "none", 0.0, f"{_ANCHOR_WORDS[kind]} was not found")
    return Answer(wish, "anchors", best.method, best.confidence, f"has {_ANCHOR_WORDS[kind]}")


def _task(wish: Wish, asset: Facts) -> Answer:
    """By its affordances; where none speaks of the task, by the anchor that the task needs."""
    task = wish.values[0]
    best = max((t for t in asset.tasks if task in t.value), key=lambda t: t.confidence, default=None)
    if best is not None:
        return Answer(wish, "affordances", best.value, best.confidence, best.method)
    if task not in _ANCHOR_OF_TASK:
        return Answer(wish, "affordances", UNKNOWN, 0.0, f"nothing recorded about '{task}'")
    by_shape = _anchor(wish, asset, _ANCHOR_OF_TASK[task])
    return Answer(
        wish, "anchors", by_shape.value, BY_SHAPE * by_shape.confidence, f"no affordance says so; {by_shape.evidence}"
    )


def _part(wish: Wish, asset: Facts) -> Answer:
    part = wish.values[0]
    found = next((p for p in (*asset.parts, *(t.value for t in asset.tasks)) if part in p.lower()), None)
    if found is not None:
        return Answer(wish, "parts", found, 1.0, "named in the record")
    known = category_called(asset.category.value)
    if known is not None and part in known.parts:
        sure = USUAL_PART * asset.category.confidence
        return Answer(wish, "semantics.category", known.id, sure, f"things of this category often have a {part}")
    return Answer(wish, "parts", UNKNOWN, 0.0, f"no {part} recorded")
