"""Physical-material classes (density, friction, restitution) from tables, and the class that names mention.

`materials.csv` holds one class per row and `contacts.csv` measured pairs of classes, each row with its source. The
values are for typical household surfaces; the bounds are what randomisation should use.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources

from schemas.evidence import Evidence, default, inferred
from schemas.physics import Contact

UNKNOWN, UNKNOWN_FULL = "unknown", "unknown_full"
ANY = "any"
UNANIMOUS, DISPUTED = 0.4, 0.25
# Camel case, digits and punctuation end a word.
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")


@dataclass(frozen=True)
class PhysicalMaterial:
    """One class; pairs are (low, high). Friction bounds hold for both coefficients.

    `may_be_hollow`: things of this class are often modelled solid but made with thin walls.
    """

    name: str
    density_kgm3: float
    density_bounds_kgm3: tuple[float, float]
    static_friction: float
    dynamic_friction: float
    friction_bounds: tuple[float, float]
    restitution: float
    restitution_bounds: tuple[float, float]
    may_be_hollow: bool
    words: frozenset[str]
    source: str


@cache
def materials() -> dict[str, PhysicalMaterial]:
    """All classes by name, in the order of the table."""
    return {row["name"]: _material(row) for row in _rows("materials.csv")}


def material_for(names: Sequence[str]) -> Evidence[str]:
    """The class that most of `names` (file, materials, meshes) mention as a whole word, `unknown` if none does.

    Within a name the first word counts: in "foam brick" or "rubber duck" the material precedes the thing. Always
    low confidence, lower when names disagree; `inputs` lists the names that agree.
    """
    votes: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        material = mentioned_material(name)
        if material is not None:
            votes.setdefault(material, []).append(name)
    if not votes:
        return default(UNKNOWN, "no name mentions a material")
    winner = Counter({material: len(agreeing) for material, agreeing in votes.items()}).most_common(1)[0][0]
    confidence = UNANIMOUS if len(votes) == 1 else DISPUTED
    return inferred(winner, "material word in a name", confidence, inputs=tuple(votes[winner]))


def contacts_of(material: Evidence[str]) -> tuple[Evidence[Contact], ...]:
    """Contact records of a class, `any` counterpart first, then the pairs with a measurement of their own."""
    m = materials()[material.value]
    general = _contact_evidence(m, ANY, m.static_friction, m.dynamic_friction, m.source, material)
    pairs = []
    for row in _rows("contacts.csv"):
        if m.name in (row["material"], row["counterpart"]):
            other = row["counterpart"] if row["material"] == m.name else row["material"]
            static, dynamic = float(row["static_friction"]), float(row["dynamic_friction"])
            pairs.append(_contact_evidence(m, other, static, dynamic, row["source"], material))
    return (general, *pairs)


def _contact_evidence(
    m: PhysicalMaterial, counterpart: str, static: float, dynamic: float, source: str, material: Evidence[str]
) -> Evidence[Contact]:
    """The bounds of a pair are those of the class, widened to hold the pair's own value."""
    low, high = min(m.friction_bounds[0], dynamic), max(m.friction_bounds[1], static)
    least, most = m.restitution_bounds
    return Evidence(
        value=Contact(
            counterpart=counterpart, static_friction=static, dynamic_friction=dynamic, restitution=m.restitution
        ),
        source=material.source,
        method=f"material class {m.name}: {source}",
        confidence=material.confidence,
        bounds=(
            Contact(counterpart=counterpart, static_friction=low, dynamic_friction=low, restitution=least),
            Contact(counterpart=counterpart, static_friction=high, dynamic_friction=high, restitution=most),
        ),
        inputs=material.inputs,
    )


def mentioned_material(name: str) -> str | None:
    """The class of the first material word in `name`."""
    by_word = {word: m.name for m in materials().values() for word in m.words}
    for word in _WORD.findall(name):
        if word.lower() in by_word:
            return by_word[word.lower()]
    return None


def _material(row: dict[str, str]) -> PhysicalMaterial:
    def pair(key: str) -> tuple[float, float]:
        return float(row[f"{key}_low"]), float(row[f"{key}_high"])

    return PhysicalMaterial(
        name=row["name"],
        density_kgm3=float(row["density_kgm3"]),
        density_bounds_kgm3=pair("density"),
        static_friction=float(row["static_friction"]),
        dynamic_friction=float(row["dynamic_friction"]),
        friction_bounds=pair("friction"),
        restitution=float(row["restitution"]),
        restitution_bounds=pair("restitution"),
        may_be_hollow=row["may_be_hollow"] == "yes",
        words=frozenset(row["words"].split()),
        source=row["source"],
    )


def _rows(file: str) -> Iterable[dict[str, str]]:
    with resources.files("assetkit").joinpath("taxonomy", file).open(encoding="utf-8") as text:
        yield from csv.DictReader(text)
