"""What the catalog keeps of a record so that it can be searched; the record stays the truth."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from typing import NamedTuple

from pydantic import BaseModel, ConfigDict

from assetkit.annotate.annotator import UNKNOWN
from assetkit.annotate.name_reading import category_called
from assetkit.taxonomy.words import words_of
from schemas.affordances import Affordance
from schemas.asset import AssetRecord
from schemas.evidence import Evidence

_LOST_PICTURE = {"asset/missing-texture", "asset/corrupt-texture", "asset/unsupported-texture"}


class Sure(NamedTuple):
    """A value of the record, how sure it is, and by what."""

    value: str
    confidence: float
    method: str


class Facts(BaseModel):
    """One asset as search sees it. Lengths in metres, masses in kilograms; `colours` are shares of the surface.

    `colours` is None where nobody knows them: no material states one, or a picture was lost. `possible` are the
    categories that came into question, with their chance. `tasks` holds the words of each affordance.
    """

    model_config = ConfigDict(frozen=True)

    asset_id: str
    outcome: str
    category: Sure
    family: Sure
    possible: tuple[tuple[str, float], ...]
    roles: tuple[Sure, ...]
    materials: tuple[Sure, ...]
    colours: dict[str, float] | None
    extent_m: tuple[float, float, float]
    extent_confidence: float
    mass_kg: float
    mass_confidence: float
    anchors: tuple[Sure, ...]
    tasks: tuple[Sure, ...]
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
        category=_sure(semantics.category),
        family=_sure(semantics.family),
        possible=tuple((h.category, h.score) for h in semantics.hypotheses),
        roles=tuple(map(_sure, semantics.roles)),
        materials=tuple(_sure(m) for m in {m.value: m for m in reversed(materials)}.values()),
        colours=None if lost or not record.appearance.colours else record.appearance.colours,
        extent_m=record.geometry.extent_m.value,
        extent_confidence=record.geometry.extent_m.confidence,
        mass_kg=physics.mass_kg.value,
        mass_confidence=physics.mass_kg.confidence,
        anchors=tuple(Sure(a.value.kind, a.confidence, a.value.anchor_id) for a in record.anchors),
        tasks=tuple(Sure(_spoken(a.value), a.confidence, a.method) for a in record.affordances if a.confidence > 0.0),
        parts=tuple(p.value.name for p in record.parts),
    )


def texts_of(record: AssetRecord) -> Texts:
    """The texts of a record, split into words so that `CoffeeMug_v2` is found by "mug"."""
    semantics = record.semantics
    known = category_called(semantics.category.value)
    others = [record.physics.material.value, semantics.family.value, semantics.category.value]
    others += [role.value for role in semantics.roles] + [part.value.name for part in record.parts]
    return Texts(
        names=_words([record.asset_id, semantics.name]),
        source_texts=_words([*semantics.source_texts, *record.appearance.materials]),
        aliases=_words(known.aliases if known else ()),
        others=_words(others),
    )


def _sure(evidence: Evidence[str]) -> Sure:
    return Sure(evidence.value, evidence.confidence, f"{evidence.source}: {evidence.method}")


def _spoken(affordance: Affordance) -> str:
    """What it is, what it serves and how, in words."""
    return f"{affordance.kind} {affordance.task} {affordance.interaction}".replace("_", " ")


def _words(texts: Sequence[str]) -> str:
    """Each word of the texts once, as it stands and as it is split; texts that say nothing is known are left out."""
    said = [unicodedata.normalize("NFC", text) for text in texts if text != UNKNOWN]
    return " ".join(dict.fromkeys(word for text in said for word in (*re.findall(r"[^\W_]+", text), *words_of(text))))
