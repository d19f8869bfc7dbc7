"""Reads impact events: every table in the folder holds one event per row."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.arrays import FloatArray
from schemas.diagnostics import InvalidInput, Location, finding
from simgap.recording.reading.columns import IMPACT, Column, take
from simgap.recording.reading.tables import Table
from simgap.recording.recording import Impacts


def impact_rows(tables: Sequence[tuple[str, Table]], columns: Sequence[Column]) -> Impacts:
    """All events of all tables; ids are those of the `id` column, else the row numbers from 0. Poses may be NaN.

    Raises InvalidInput (`gap/missing-column`, `gap/unreadable-table`, `gap/trial-id-twice`).
    """
    parts: dict[str, list[FloatArray]] = {name: [] for name in IMPACT}
    rows = 0
    for file, table in tables:
        taken = {c.name: take(table, c, file) for c in columns}
        n = min(len(v) for v in taken.values())
        for name, width in IMPACT.items():
            default = np.arange(rows, rows + n, dtype=np.float64) if name == "id" else np.full((n, width), np.nan)
            parts[name].append(taken.get(name, default))
        rows += n
    whole = {name: np.concatenate(arrays) for name, arrays in parts.items()}
    numbers = whole["id"]
    if not np.isfinite(numbers).all() or len(np.unique(numbers)) < len(numbers):
        text = "the ids of the events are not one number each; leave the column out to count rows"
        raise InvalidInput(finding("gap/trial-id-twice", text, where=Location(file=tables[0][0])))
    return Impacts(
        ids=tuple(f"{i:g}" if abs(i) < 1e6 else str(int(i)) for i in numbers),
        pose_before=whole["pose_before"],
        velocity_before=whole["velocity_before"],
        pose_after=whole["pose_after"],
        velocity_after=whole["velocity_after"],
        normal=whole["normal_jacobian"],
        tangent=whole["tangent_jacobian"],
    )
