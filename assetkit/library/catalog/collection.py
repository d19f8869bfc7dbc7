"""Collection tables of a catalog as papers print them: by category, interaction group, joint type, outcome, licence."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from statistics import median

from assetkit.library.catalog.store import reading

Table = list[dict[str, object]]


def collection(out: Path) -> dict[str, Table]:
    """The tables by name. Sizes are longest edges (m), masses kg, capacities those of the largest volume (m3).

    totals       packages, rigid and articulated ones, joints, anchors, distinct categories and source files.
    categories   of each category how many, how many are articulated, how many have surfaces or volumes, and medians.
    groups       of each interaction group and joint type how many objects and joints.
    roles, outcomes, licences, formats   numbers of packages; `outcomes` also of the sources of the last run.
    Raises as `reading`.
    """
    with reading(out) as db:
        return {
            "totals": _rows(db, _TOTALS),
            "categories": _categories(db),
            "groups": _rows(db, _GROUPS),
            "joints": _rows(db, _JOINTS),
            "roles": _rows(db, _traits("role", "role")),
            "outcomes": _rows(db, _OUTCOMES),
            "licences": _rows(db, _by("license", "licence")),
            "formats": _rows(db, _by("format", "format")),
            "materials": _rows(db, _by("material", "material")),
        }


_TOTALS = """
SELECT count(*) AS packages, count(*) FILTER (WHERE joints = 0) AS rigid, count(*) FILTER (WHERE joints > 0) AS
  articulated, coalesce(sum(joints), 0) AS joints, coalesce(sum(surfaces), 0) AS surfaces, coalesce(sum(volumes), 0) AS
  volumes, count(DISTINCT category) AS categories, (SELECT count(DISTINCT sha256) FROM sources) AS source_files
FROM assets"""
_GROUPS = """
SELECT value AS interaction_group, count(*) AS packages, sum(joints) AS joints FROM traits
JOIN assets USING (key) WHERE field = 'group' GROUP BY value ORDER BY packages DESC, value"""
_JOINTS = """
SELECT value AS joint, count(*) AS packages FROM traits WHERE field = 'joint'
GROUP BY value ORDER BY packages DESC, value"""
_OUTCOMES = """
SELECT outcome, sum(packages) AS packages, sum(sources) AS sources_of_last_run FROM (
  SELECT outcome, count(*) AS packages, 0 AS sources FROM assets GROUP BY outcome
  UNION ALL SELECT outcome, 0, count(*) FROM outcomes GROUP BY outcome)
GROUP BY outcome ORDER BY outcome"""


def _traits(field: str, name: str) -> str:
    return (
        f"SELECT value AS {name}, count(*) AS packages FROM traits WHERE field = '{field}' "
        "GROUP BY value ORDER BY packages DESC, value"
    )


def _by(column: str, name: str) -> str:
    return f"SELECT {column} AS {name}, count(*) AS packages FROM assets GROUP BY 1 ORDER BY packages DESC, 1"


def _rows(db: sqlite3.Connection, sql: str) -> Table:
    return [dict(row) for row in db.execute(sql)]


def _categories(db: sqlite3.Connection) -> Table:
    """One row per category; SQLite has no median, so sizes and masses are read once in the order of categories."""
    sql = "SELECT category, joints, surfaces, volumes, longest_m, mass_kg FROM assets"
    members: dict[str, list[sqlite3.Row]] = {}
    for row in db.execute(sql):
        members.setdefault(row["category"], []).append(row)
    rows: Table = [
        {
            "category": category,
            "packages": len(of_category),
            "articulated": sum(row["joints"] > 0 for row in of_category),
            "with_surface": sum(row["surfaces"] > 0 for row in of_category),
            "with_volume": sum(row["volumes"] > 0 for row in of_category),
            "median_size_m": median(row["longest_m"] for row in of_category),
            "median_mass_kg": median(row["mass_kg"] for row in of_category),
        }
        for category, of_category in members.items()
    ]
    return sorted(rows, key=lambda row: (-int(str(row["packages"])), str(row["category"])))
