"""`catalog.sqlite`: one row per package, for listing and searching; rebuilt from the (authoritative) records."""

from __future__ import annotations

import sqlite3
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from assetkit.library.search.facts import Facts, facts_of, texts_of
from assetkit.library.search.match import TextHit
from assetkit.library.search.query import Criterion
from assetkit.package.record import RECORD, read_record
from schemas.asset import AssetRecord
from schemas.diagnostics import InvalidInput, finding

CATALOG = "catalog.sqlite"
_TABLES = """
CREATE TABLE assets (
  asset_id TEXT PRIMARY KEY, name TEXT, outcome TEXT, category TEXT, roles TEXT, license TEXT, format TEXT,
  size_x_m REAL, size_y_m REAL, size_z_m REAL, mass_kg REAL, material TEXT, collider TEXT, triangles INTEGER);
CREATE TABLE facts (asset_id TEXT PRIMARY KEY, facts TEXT);
CREATE VIRTUAL TABLE words USING fts5 (asset_id UNINDEXED, names, source_texts, aliases, others);
"""
# Confidence of a word by the column of texts that contains it, highest first: names are given by people, for reasons.
_TEXT_CONFIDENCE = {"names": 0.6, "others": 0.5, "source_texts": 0.4, "aliases": 0.4}


def records(out: Path) -> Iterator[tuple[Path, AssetRecord]]:
    """Every package folder in `out` with its record, by name."""
    for path in sorted(out.glob(f"[!.]*/{RECORD}")):
        record = read_record(path.parent)
        if record is not None:
            yield path.parent, record


def rebuild(out: Path) -> int:
    """Write the catalog of `out` anew; returns the number of packages."""
    path = out / CATALOG
    temporary = out / f".{CATALOG}"
    temporary.unlink(missing_ok=True)
    count = 0
    with closing(sqlite3.connect(temporary)) as db, db:
        db.executescript(_TABLES)
        for _, record in records(out):
            count += 1
            db.execute(f"INSERT INTO assets VALUES ({','.join('?' * 14)})", _row(record))
            db.execute("INSERT INTO facts VALUES (?, ?)", (record.asset_id, facts_of(record).model_dump_json()))
            db.execute("INSERT INTO words VALUES (?, ?, ?, ?, ?)", (record.asset_id, *texts_of(record)))
    temporary.replace(path)
    return count


@dataclass(frozen=True)
class Selection:
    """Which rows of the catalog are wanted: equal values, `role` among others, `license` and `name` as parts."""

    outcome: str | None = None
    category: str | None = None
    role: str | None = None
    format: str | None = None
    license: str | None = None
    name: str | None = None
    limit: int = -1  # all
    offset: int = 0


ALL = Selection()


def listing(out: Path, chosen: Selection = ALL) -> list[dict[str, object]]:
    """Rows of the catalog, by asset id. Raises FileNotFoundError when `out` has no catalog."""
    conditions: list[tuple[str, str]] = [
        (f"{column} = ?", value)
        for column in ("outcome", "category", "format")
        if (value := getattr(chosen, column)) is not None
    ]
    if chosen.role is not None:
        conditions.append(("instr(',' || roles || ',', ?)", f",{chosen.role},"))
    conditions += [
        (f"instr(lower({column}), lower(?))", value)
        for column, value in (("license", chosen.license), ("asset_id", chosen.name))
        if value is not None
    ]
    where = f"WHERE {' AND '.join(sql for sql, _ in conditions)} " if conditions else ""
    order = "ORDER BY asset_id LIMIT ? OFFSET ?"
    values = (*(value for _, value in conditions), chosen.limit, chosen.offset)
    return _query(out, f"SELECT * FROM assets {where}{order}", values)


def counts(out: Path, column: str) -> dict[str, int]:
    """Number of packages by the value of a column, most first; an asset counts in each of its roles."""
    if column != "roles":
        sql = f"SELECT {column} AS value, count(*) AS n FROM assets GROUP BY value ORDER BY n DESC, value"
        return {str(row["value"]): int(str(row["n"])) for row in _query(out, sql, ())}
    tally = Counter(
        role for row in _query(out, "SELECT roles FROM assets", ()) for role in str(row["roles"]).split(",")
    )
    return dict(sorted(tally.items(), key=lambda item: (-item[1], item[0])))


def facts(out: Path) -> list[Facts]:
    """The searchable facts of every package, by asset id. Raises FileNotFoundError when `out` has no catalog,
    InvalidInput when an older version wrote it.
    """
    rows = _query(out, "SELECT facts FROM facts", ())
    try:
        return [Facts.model_validate_json(str(row["facts"])) for row in rows]
    except ValidationError as error:
        raise _unreadable("its facts are of another version") from error


def find_text(out: Path, criterion: Criterion) -> TextHit:
    """The assets whose texts contain one of the words of a criterion, with the column of highest confidence. A word
    also matches the beginning of a longer one, unless the criterion is negated.
    """
    hits: dict[str, tuple[str, float, str]] = {}
    for column, confidence in _TEXT_CONFIDENCE.items():
        for word in criterion.values:
            sql = f"SELECT asset_id, snippet(words, -1, '', '', '...', 8) AS found FROM words WHERE {column} MATCH ?"
            for row in _query(out, sql, (f'"{word}"' + "*" * (not criterion.negated),)):
                hits.setdefault(str(row["asset_id"]), (column, confidence, str(row["found"])))
    return hits


def _query(out: Path, sql: str, parameters: tuple[str | int, ...]) -> list[dict[str, object]]:
    path = out / CATALOG
    if not path.is_file():
        raise FileNotFoundError(path)
    try:
        with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as db:
            db.row_factory = sqlite3.Row
            return [dict(row) for row in db.execute(sql, parameters)]
    except sqlite3.DatabaseError as error:
        raise _unreadable(str(error)) from error


def _unreadable(why: str) -> InvalidInput:
    headline = f"{CATALOG} cannot be read ({why}); `mana assets ingest` writes it anew"
    return InvalidInput(finding("asset/catalog-unreadable", headline))


def _row(record: AssetRecord) -> tuple[object, ...]:
    x, y, z = record.geometry.extent_m.value
    return (
        record.asset_id,
        record.semantics.name,
        record.outcome.value,
        record.semantics.category.value,
        ",".join(r.value for r in record.semantics.roles),
        record.source.license.value,
        record.source.format,
        x,
        y,
        z,
        record.physics.mass_kg.value,
        record.physics.material.value,
        record.physics.collision_method,
        record.geometry.reobserved.triangles,
    )
