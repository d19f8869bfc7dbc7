"""Whether an object is none of the things that Mana prepares: a vehicle, a character, a room or building, cloth."""

from __future__ import annotations

from functools import cache

from pydantic import BaseModel, ConfigDict

from assetkit.annotate.annotator import UNKNOWN, Annotation, Observation
from assetkit.annotate.name_reading import read_name
from assetkit.taxonomy.tables import Words, rows_of

# Nothing that stands in a room is as large as this along its shortest edge.
LARGEST_M = 1.4


class Domain(BaseModel):
    """One row of `domains.csv`: names that leave no doubt, those that do where unknown words stand before them, and
    the longest edge below which a thing called so is a toy (0: never).
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    domain: str
    words: Words
    weak_words: Words
    toy_below_m: float


def out_of_domain(seen: Observation, annotation: Annotation) -> str:
    """Why the object is out of the domain, "" where nothing says so or it has a category of the vocabulary.

    The name of the file or its title decides, that of the folder where the file's own says nothing; where nobody
    named it, a size beyond furniture.
    """
    if annotation.category != UNKNOWN:
        return ""
    readings = [("file", seen.file, read_name(seen.file)), *(("title", t, read_name(t)) for t in seen.titles[:1])]
    if readings[0][2].silent:
        readings += [("folder", f, r) for f in seen.folders if not (r := read_name(f)).silent][:1]
    for place, name, reading in readings:
        row, weak = _table().get(reading.other, (None, False))
        if row is None or reading.unknown_after or (weak and reading.unknown_before):
            continue
        if not seen.shape.metric or seen.shape.extents_m[2] >= row.toy_below_m:
            return f"the {place} is called '{name}': {row.domain}"
    if seen.shape.metric and seen.shape.extents_m[0] >= LARGEST_M and all(r.silent for _, _, r in readings):
        size = " x ".join(f"{edge:.3g}" for edge in seen.shape.extents_m)
        return f"{size} m is larger than what stands in a room"
    return ""


@cache
def _table() -> dict[str, tuple[Domain, bool]]:
    rows = [Domain.model_validate(row) for row in rows_of("domains.csv")]
    return {word: (row, word in row.weak_words) for row in rows for word in (*row.words, *row.weak_words)}
