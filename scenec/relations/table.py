"""The tables of relations by kind, one file of this folder for each: all, and those that words of the language have."""

from __future__ import annotations

from importlib import import_module

from scenec.relations import keep_clear
from scenec.relations.protocol import RelationMeaning, WordMeaning
from schemas.scene.relations import RELATION_KINDS

WRITTEN_RELATIONS: dict[str, WordMeaning] = {
    kind: import_module(f"scenec.relations.{kind}").RELATION for kind in RELATION_KINDS
}
RELATIONS: dict[str, RelationMeaning] = {**WRITTEN_RELATIONS, keep_clear.RELATION.kind: keep_clear.RELATION}
