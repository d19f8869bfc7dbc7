"""Reads the answer of a model into ids of the vocabulary with chances; its schema is checked here again."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from typing import Annotated, get_args

from pydantic import BaseModel, ConfigDict, Field

from assetkit.annotate.prompt import cleaned
from assetkit.taxonomy.tables import categories
from schemas.asset import EndpointAnswer, Role

MAX_DESCRIPTION, _MAX_REFUSED = 400, 60
_Chance = Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class _Category(_Strict):
    category: str
    confidence: _Chance


class _Role(_Strict):
    role: str
    confidence: _Chance


class _Answer(_Strict):
    categories: list[_Category] = Field(max_length=16)
    roles: list[_Role] = Field(max_length=16)
    description: str


def read_answer(text: str, method: str, settings: Mapping[str, float]) -> EndpointAnswer:
    """The answer in `text`: ids of the vocabulary, best first, everything else in `refused`.

    Ids count as in the tables: no other spelling, no alias. Raises ValueError when `text` does not keep the
    schema.
    """
    answer = _Answer.model_validate_json(text)
    kinds, other_kinds = _known(((c.category, c.confidence) for c in answer.categories), categories())
    roles, other_roles = _known(((r.role, r.confidence) for r in answer.roles), get_args(Role))
    return EndpointAnswer(
        method=method,
        categories=kinds,
        roles=roles,
        description=cleaned(answer.description, MAX_DESCRIPTION),
        refused=(*other_kinds, *other_roles),
        settings=dict(settings),
    )


def _known(chances: Iterable[tuple[str, float]], vocabulary: Container[str]) -> tuple[dict[str, float], list[str]]:
    """Chances by id, greatest first, the greater of an id given twice; and names in no vocabulary, cleaned."""
    ranked = sorted(chances, key=lambda pair: (-pair[1], pair[0]))
    known: dict[str, float] = {}
    for name, chance in ranked:
        if name in vocabulary:
            known.setdefault(name, round(chance, 3))
    refused = dict.fromkeys(cleaned(name, _MAX_REFUSED) for name, _ in ranked if name not in vocabulary)
    return known, list(refused)
