"""Decisions of people about one source asset; `decisions.jsonl` of an output folder holds one per line."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

DecidedField = Literal["category", "role", "units", "up_axis", "license", "author"]


class PartLabel(BaseModel):
    """What a part is called; an empty text withdraws that. `region`: hash of the triangles that the person saw."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    label: str = Field(max_length=80)
    region: str


class Decision(BaseModel):
    """One decision, kept for good: a later one about the same thing overrules it, nothing is ever deleted.

    It is about content, not about a place: it holds wherever a file with `source_sha256` is ingested beside the same
    `references` (file, seen from the source's folder -> sha256). `source` is its path then, for people. `object` is
    the number of the object in a file of several, 0 for all of them. `set` maps fields to what is stated of them, an
    empty text withdraws a statement; `parts` maps part ids to labels. `accept`: the asset is good as it is, in spite of
    the findings `known` to the person; False withdraws that, None says nothing about it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    source: str
    source_sha256: str
    references: dict[str, str] = {}
    object: int = Field(default=0, ge=0)
    set: dict[DecidedField, str] = {}
    parts: dict[str, PartLabel] = {}
    accept: bool | None = None
    known: tuple[str, ...] = Field(default=(), description="codes of the findings that the person saw")
    by: str = Field(min_length=1)
    reason: str = ""
    date: str | None = Field(default=None, description="of SOURCE_DATE_EPOCH where that is set; no clock is read")
