"""A runtime plan prepared for sampling: its document, the SHA-256 of its file and its lookup tables."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

from runtime_plan.consistency import find_inconsistencies
from runtime_plan.tables import PlanTables, tables_of
from schemas.diagnostics import InvalidInput
from schemas.scene.runtime_plan import RuntimePlan


@dataclass(frozen=True)
class Plan:
    """`document` as read, the SHA-256 of its file, and its lookup tables."""

    document: RuntimePlan
    sha256: str
    tables: PlanTables


def prepare(document: RuntimePlan, sha256: str | None = None) -> Plan:
    """A plan in memory; without a file, its hash is that of its JSON. Raises InvalidInput (`plan/inconsistent`)."""
    inconsistencies = find_inconsistencies(document)
    if inconsistencies:
        raise InvalidInput(inconsistencies[0])
    return Plan(
        document, sha256 or hashlib.sha256(document.model_dump_json().encode()).hexdigest(), tables_of(document)
    )
