"""How dense the components are that many machines have and whose names are the same everywhere: motors, batteries."""

from __future__ import annotations

import math
from functools import cache

from pydantic import BaseModel, ConfigDict

from assetkit.taxonomy.tables import Words, fillers, rows_of
from assetkit.taxonomy.words import singulars, words_of
from schemas.evidence import Evidence, inferred

TRUST = 0.6  # that what is called so is drawn full and is none of a toy


class Component(BaseModel):
    """One row of `components.csv`: names and the mass over the volume inside the outer surface (95 % of them)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    words: Words
    low_kgm3: float
    high_kgm3: float
    source: str


def component_density(name: str) -> Evidence[float] | None:
    """Density (kg/m3) of what a mesh of this name is, None where it names no component of the table.

    As everywhere in names the last noun is the thing: a battery holder is no battery.
    """
    words = [word for word in words_of(name) if word not in fillers()]
    for count in (3, 2, 1):
        if len(words) < count:
            continue
        *before, last = words[-count:]
        for form in (last, *singulars(last)):
            found = _table().get(" ".join((*before, form)))
            if found is not None:
                bounds = (found.low_kgm3, found.high_kgm3)
                method = f"a {found.words[0]}: {found.source}"
                return inferred(math.sqrt(bounds[0] * bounds[1]), method, TRUST, bounds=bounds, inputs=(name,))
    return None


@cache
def _table() -> dict[str, Component]:
    rows = [Component.model_validate(row) for row in rows_of("components.csv")]
    return {word: row for row in rows for word in row.words}
