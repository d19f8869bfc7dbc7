"""`catalog.sqlite`: one row per package, for listing and searching; rebuilt from the records, which stay the truth."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from assetkit.record import RECORD, read_record
from schemas.asset import AssetRecord

CATALOG = "catalog.sqlite"
_TABLES = """
CREATE TABLE assets (
  asset_id TEXT PRIMARY KEY, name TEXT, outcome TEXT, category TEXT, roles TEXT, license TEXT, format TEXT,
  size_x_m REAL, size_y_m REAL, size_z_m REAL, mass_kg REAL, material TEXT, collider TEXT, triangles INTEGER);
CREATE VIRTUAL TABLE words USING fts5 (asset_id UNINDEXED, text);
"""


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
            db.execute("INSERT INTO words VALUES (?, ?)", (record.asset_id, _text(record)))
    temporary.replace(path)
    return count


def listing(out: Path) -> list[dict[str, object]]:
    """All rows of the catalog, by asset id. Raises FileNotFoundError when `out` has no catalog."""
    return _query(out, "SELECT * FROM assets ORDER BY asset_id", ())


def search(out: Path, words: str) -> list[dict[str, object]]:
    """Rows whose name, category, material or part names contain all words (prefixes count), best first."""
    terms = " ".join(f'"{w}"*' for w in words.replace('"', " ").split())
    if not terms:
        return listing(out)
    return _query(
        out,
        "SELECT assets.*, words.text AS matched FROM words JOIN assets USING (asset_id) WHERE words MATCH ? "
        "ORDER BY rank, asset_id",
        (terms,),
    )


def _query(out: Path, sql: str, parameters: tuple[str, ...]) -> list[dict[str, object]]:
    path = out / CATALOG
    if not path.is_file():
        raise FileNotFoundError(path)
    with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as db:
        db.row_factory = sqlite3.Row
        return [dict(row) for row in db.execute(sql, parameters)]


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


def _text(record: AssetRecord) -> str:
    names = [record.asset_id, record.semantics.name, record.semantics.category.value, record.physics.material.value]
    names += [record.semantics.family.value, *record.semantics.source_texts]
    names += [r.value for r in record.semantics.roles]
    names += record.appearance.materials
    names += [str(p.value["name"]) for p in record.parts]
    return " ".join(n.replace("_", " ") for n in names)
