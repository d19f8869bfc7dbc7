"""The table of relations by kind: one file of this folder for each kind of `schemas.scene.relations` and for
those that no word writes."""

from __future__ import annotations

from importlib import import_module

from scenec.relations.protocol import RelationMeaning
from schemas.scene.relations import RELATION_KINDS

UNWRITTEN_KINDS = ("keep_clear",)  # made by the solver's model

RELATIONS: dict[str, RelationMeaning] = {
    kind: import_module(f"scenec.relations.{kind}").RELATION for kind in (*RELATION_KINDS, *UNWRITTEN_KINDS)
}
