"""Searchable facts and texts of one asset record, as the catalog stores them; the record stays authoritative."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from typing import NamedTuple

from pydantic import BaseModel, ConfigDict

from assetkit.annotate.annotator import UNKNOWN
from assetkit.annotate.name_reading import category_by_name
from assetkit.taxonomy.words import words_of
from schemas.affordances import Affordance
from schemas.asset import AssetRecord
from schemas.evidence import Evidence

_LOST_PICTURE = {"asset/missing-texture", "asset/corrupt-texture", "asset/unsupported-texture"}


class RatedValue(NamedTuple):
    """A value of the record with its confidence (0..1) and the source and method it comes from."""

    value: str
    confidence: float
    method: str


class Facts(BaseModel):
    """The searchable facts of one asset. Lengths in metres, masses in kilograms; `colours` are shares of the surface.

    `colours` is None where they are unknown: no material states one, or a picture was lost. `possible` holds the
    hypotheses of the category with their probabilities. `tasks` holds the words of each affordance.
    """

    model_config = ConfigDict(frozen=True)

    asset_id: str
    outcome: str
    category: RatedValue
    family: RatedValue
    possible: tuple[tuple[str, float], ...]
    roles: tuple[RatedValue, ...]
    materials: tuple[RatedValue, ...]
    colours: dict[str, float] | None
    extent_m: tuple[float, float, float]
    extent_confidence: float
    mass_kg: float
    mass_confidence: float
    anchors: tuple[RatedValue, ...]
    tasks: tuple[RatedValue, ...]
    parts: tuple[str, ...]


class Texts(NamedTuple):
    """The texts of one asset for full-text search, by where they come from."""

    names: str
    source_texts: str
    aliases: str
    others: str


def facts_of(record: AssetRecord) -> Facts:
    """The searchable facts of a record."""
    semantics, physics = record.semantics, record.physics
    materials = [physics.material, *(part.material for part in physics.mass_parts)]
    materials += [p.value.material for p in record.parts if p.value.material.confidence > 0.0]
    lost = any(d.code in _LOST_PICTURE for d in record.diagnostics)
    return Facts(
        asset_id=record.asset_id,
        outcome=record.outcome.value,
        category=_rated(semantics.category),
        family=_rated(semantics.family),
        possible=tuple((h.category, h.score) for h in semantics.hypotheses),
        roles=tuple(map(_rated, semantics.roles)),
        materials=tuple(_rated(m) for m in {m.value: m for m in reversed(materials)}.values()),
        colours=None if lost or not record.appearance.colours else record.appearance.colours,
        extent_m=record.geometry.extent_m.value,
        extent_confidence=record.geometry.extent_m.confidence,
        mass_kg=physics.mass_kg.value,
        mass_confidence=physics.mass_kg.confidence,
        anchors=tuple(RatedValue(a.value.kind, a.confidence, a.value.anchor_id) for a in record.anchors),
        tasks=tuple(
            RatedValue(_affordance_words(a.value), a.confidence, a.method)
            for a in record.affordances
            if a.confidence > 0.0
        ),
        parts=tuple(p.value.name for p in record.parts),
    )


def texts_of(record: AssetRecord) -> Texts:
    """The texts of a record, split into words so that `CoffeeMug_v2` is found by "mug"."""
    semantics = record.semantics
    known = category_by_name(semantics.category.value)
    others = [record.physics.material.value, semantics.family.value, semantics.category.value]
    others += [role.value for role in semantics.roles] + [part.value.name for part in record.parts]
    return Texts(
        names=_words([record.asset_id, semantics.name]),
        source_texts=_words([*semantics.source_texts, *record.appearance.materials]),
        aliases=_words(known.aliases if known else ()),
        others=_words(others),
    )


def _rated(evidence: Evidence[str]) -> RatedValue:
    return RatedValue(evidence.value, evidence.confidence, f"{evidence.source}: {evidence.method}")


def _affordance_words(affordance: Affordance) -> str:
    """Kind, task and interaction of an affordance, in words."""
    return f"{affordance.kind} {affordance.task} {affordance.interaction}".replace("_", " ")


def _words(texts: Sequence[str]) -> str:
    """Each word of the texts once, as written and as split at case changes; the text "unknown" is left out."""
    known = [unicodedata.normalize("NFC", text) for text in texts if text != UNKNOWN]
    return " ".join(dict.fromkeys(word for text in known for word in (*re.findall(r"[^\W_]+", text), *words_of(text))))
