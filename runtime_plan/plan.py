"""A plan that is ready to be sampled."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

from runtime_plan.consistency import faults
from runtime_plan.tables import PlanTables, tables_of
from schemas.diagnostics import InvalidInput
from schemas.scene.runtime_plan import RuntimePlan


@dataclass(frozen=True)
class Plan:
    """`document` as read, the SHA-256 of its file, and its arrays."""

    document: RuntimePlan
    sha256: str
    tables: PlanTables


def prepare(document: RuntimePlan, sha256: str | None = None) -> Plan:
    """A plan in memory; without a file, its hash is that of its JSON. Raises InvalidInput (`plan/inconsistent`)."""
    found = faults(document)
    if found:
        raise InvalidInput(found[0])
    return Plan(
        document, sha256 or hashlib.sha256(document.model_dump_json().encode()).hexdigest(), tables_of(document)
    )
