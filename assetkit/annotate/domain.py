"""Detects objects outside the domain by name and size: vehicles, characters, rooms and buildings, cloth."""

from __future__ import annotations

from functools import cache

from pydantic import BaseModel, ConfigDict

from assetkit.annotate.annotator import UNKNOWN, Annotation, Observation
from assetkit.annotate.name_reading import read_name
from assetkit.taxonomy.tables import Words, rows_of

# Shortest edge (m) that nothing in a room reaches.
LARGEST_M = 1.4


class Domain(BaseModel):
    """One row of `domains.csv`: `words` name it clearly, `weak_words` not where unknown words precede them; a thing
    with such a name and a longest edge below `toy_below_m` is a toy (0: never).
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    domain: str
    words: Words
    weak_words: Words
    toy_below_m: float


def out_of_domain(observation: Observation, annotation: Annotation) -> str:
    """Why the object is out of the domain, "" without evidence for it or with a category of the vocabulary.

    The name of the file or its title decides, that of the folder where the file's name is uninformative; without any
    name, a size beyond furniture.
    """
    if annotation.category != UNKNOWN:
        return ""
    readings = [
        ("file", observation.file, read_name(observation.file)),
        *(("title", t, read_name(t)) for t in observation.titles[:1]),
    ]
    if readings[0][2].is_uninformative:
        readings += [("folder", f, r) for f in observation.folders if not (r := read_name(f)).is_uninformative][:1]
    for place, name, reading in readings:
        row, weak = _table().get(reading.other, (None, False))
        if row is None or reading.unknown_after or (weak and reading.unknown_before):
            continue
        if not observation.shape.metric or observation.shape.extents_m[2] >= row.toy_below_m:
            return f"the {place} is called '{name}': {row.domain}"
    if (
        observation.shape.metric
        and observation.shape.extents_m[0] >= LARGEST_M
        and all(r.is_uninformative for _, _, r in readings)
    ):
        size = " x ".join(f"{edge:.3g}" for edge in observation.shape.extents_m)
        return f"{size} m is larger than what stands in a room"
    return ""


@cache
def _table() -> dict[str, tuple[Domain, bool]]:
    rows = [Domain.model_validate(row) for row in rows_of("domains.csv")]
    return {word: (row, word in row.weak_words) for row in rows for word in (*row.words, *row.weak_words)}
