"""Density (kg/m3) of standard machine components, such as motors and batteries, from the name of a mesh."""

from __future__ import annotations

import math
from functools import cache

from pydantic import BaseModel, ConfigDict

from assetkit.taxonomy.tables import Words, fillers, rows_of
from assetkit.taxonomy.words import singulars, words_of
from schemas.evidence import Evidence, inferred

TRUST = 0.6  # Confidence that a mesh of this name is modelled as a solid and is not part of a toy.


class Component(BaseModel):
    """One row of `components.csv`: names and the mass over the volume inside the outer surface (95 % of them)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    words: Words
    low_kgm3: float
    high_kgm3: float
    source: str


def component_density(name: str) -> Evidence[float] | None:
    """Density (kg/m3) of the component that a mesh name names, None where it names none of the table.

    As everywhere in names the last noun is the head: a battery holder is no battery.
    """
    words = [word for word in words_of(name) if word not in fillers()]
    for count in (3, 2, 1):
        if len(words) < count:
            continue
        *before, last = words[-count:]
        for form in (last, *singulars(last)):
            component = _table().get(" ".join((*before, form)))
            if component is not None:
                bounds = (component.low_kgm3, component.high_kgm3)
                method = f"a {component.words[0]}: {component.source}"
                return inferred(math.sqrt(bounds[0] * bounds[1]), method, TRUST, bounds=bounds, inputs=(name,))
    return None


@cache
def _table() -> dict[str, Component]:
    rows = [Component.model_validate(row) for row in rows_of("components.csv")]
    return {word: row for row in rows for word in row.words}
