"""Lists and counts the assets of a catalog by exact filters."""

from __future__ import annotations

import sqlite3
from dataclasses import dataclass
from pathlib import Path

from assetkit.library.catalog.store import reading

_HIDDEN = frozenset({"key", "extent_confidence", "mass_confidence"})
_EQUAL = ("outcome", "category", "family", "format")
# Filters of values of which an asset may have several: their field in `traits`.
_TRAITS = {"role": "role", "interaction_group": "group", "joint_type": "joint", "anchor": "anchor"}
_PARTS = {"license": "license", "name": "asset_id"}
_LEAST = {"min_size_m": "longest_m", "min_mass_kg": "mass_kg", "min_capacity_m3": "capacity_m3"}
_MOST = {"max_size_m": "longest_m", "max_mass_kg": "mass_kg"}


@dataclass(frozen=True)
class Selection:
    """Filters of a listing, all of which must hold.

    `license` and `name` are parts of the value. `interaction_group` is that of the object or of one of its joints,
    `anchor` "surface" or "volume". Sizes are the longest edge; `min_capacity_m3` is of the largest volume anchor.
    """

    outcome: str | None = None
    category: str | None = None
    role: str | None = None
    format: str | None = None
    license: str | None = None
    name: str | None = None
    limit: int = -1  # all
    offset: int = 0
    family: str | None = None
    interaction_group: str | None = None
    joint_type: str | None = None
    anchor: str | None = None
    min_size_m: float | None = None
    max_size_m: float | None = None
    min_mass_kg: float | None = None
    max_mass_kg: float | None = None
    min_capacity_m3: float | None = None


ALL = Selection()


def listing(out: Path, chosen: Selection = ALL) -> list[dict[str, object]]:
    """Rows of the catalog, by asset id. Raises as `reading`."""
    conditions = [
        *_conditions(chosen, {name: f"{name} = ?" for name in _EQUAL}),
        *_conditions(
            chosen,
            {
                name: f"EXISTS (SELECT 1 FROM traits t WHERE t.key = assets.key AND field = '{field}' AND value = ?)"
                for name, field in _TRAITS.items()
            },
        ),
        *_conditions(chosen, {name: f"instr(lower({column}), lower(?))" for name, column in _PARTS.items()}),
        *_conditions(chosen, {name: f"{column} >= ?" for name, column in _LEAST.items()}),
        *_conditions(chosen, {name: f"{column} <= ?" for name, column in _MOST.items()}),
    ]
    where = f"WHERE {' AND '.join(sql for sql, _ in conditions)} " if conditions else ""
    values = (*(value for _, value in conditions), chosen.limit, chosen.offset)
    with reading(out) as db:
        rows = db.execute(f"SELECT * FROM assets {where}ORDER BY asset_id LIMIT ? OFFSET ?", values)
        return [{name: row[name] for name in row.keys() if name not in _HIDDEN} for row in rows]  # noqa: SIM118


def _conditions(chosen: Selection, sql: dict[str, str]) -> list[tuple[str, str | float]]:
    """The SQL conditions of those filters that are set, with their values."""
    return [(text, value) for name, text in sql.items() if (value := getattr(chosen, name)) is not None]


def counts(out: Path, column: str) -> dict[str, int]:
    """Number of packages by the value of a column, most first; an asset counts in each of its roles. Raises as
    `reading`.
    """
    with reading(out) as db:
        if column == "roles":
            sql = (
                "SELECT coalesce(value, '') AS value, count(*) AS n FROM assets "
                "LEFT JOIN traits ON traits.key = assets.key AND field = 'role' GROUP BY 1"
            )
        else:
            sql = f"SELECT {column} AS value, count(*) AS n FROM assets GROUP BY value"
        return _tally(db, f"{sql} ORDER BY n DESC, value")


def values_of(out: Path, field: str) -> list[str]:
    """Every value that some asset has in a field of `traits`, in order. Raises as `reading`."""
    with reading(out) as db:
        return vocabulary(db, field)


def vocabulary(db: sqlite3.Connection, field: str) -> list[str]:
    """As `values_of`; one look-up in the index for each value, however many assets have it."""
    sql = """
    WITH RECURSIVE word (value) AS (
      SELECT min(value) FROM traits WHERE field = :field
      UNION ALL
      SELECT (SELECT min(value) FROM traits WHERE field = :field AND value > word.value) FROM word
      WHERE word.value IS NOT NULL)
    SELECT value FROM word WHERE value IS NOT NULL"""
    return [str(row[0]) for row in db.execute(sql, {"field": field})]


def _tally(db: sqlite3.Connection, sql: str) -> dict[str, int]:
    return {str(row["value"]): int(row["n"]) for row in db.execute(sql)}
