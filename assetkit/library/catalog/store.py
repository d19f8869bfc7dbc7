"""`catalog.sqlite`: rows made from the records of a library, kept up to date record by record.

The records are the truth. `update` writes the rows of records that have changed since, and leaves the catalog as
`rebuild` would make it from nothing, but for keys and stamps. SQLite in WAL mode: readers see the state before or after
an update, and one that is cut short leaves the state before.
"""

from __future__ import annotations

import hashlib
import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from assetkit.batch.report_file import REPORT, read_items
from assetkit.library.catalog.migrations import VERSION, migrate, version_of
from assetkit.library.catalog.neighbours import update_neighbours
from assetkit.library.catalog.rows import Row, rows_of
from assetkit.package.record import RECORD, read_record
from jobs.lock import FolderUnusable, exclusive
from schemas.asset import AssetRecord
from schemas.diagnostics import InvalidInput, finding

CATALOG = "catalog.sqlite"
_KEYED_TABLES = ("assets", "traits", "records", "sources", "shapes")
_BUSY_S = 30.0  # A reader waits for a writer at most this long; writers hold the lock of the folder.


def records(out: Path) -> Iterator[tuple[Path, AssetRecord]]:
    """Every package folder in `out` with its record, by name."""
    for path in sorted(out.glob(f"[!.]*/{RECORD}")):
        record = read_record(path.parent)
        if record is not None:
            yield path.parent, record


def update(out: Path) -> int:
    """Bring the catalog of `out` up to date; returns the number of assets whose rows were written or removed.

    The caller holds the lock of the folder. A catalog that cannot be read is made anew. Raises
    sqlite3.OperationalError when the disk is full or read-only.
    """
    path = out / CATALOG
    if not _is_sound(path):
        return rebuild(out)
    with closing(_writable(path)) as db:
        return _update(db, out)


def rebuild(out: Path) -> int:
    """Write the catalog of `out` from nothing and move it into place; returns the number of packages."""
    path, temporary = out / CATALOG, out / f".{CATALOG}"
    _remove(temporary)
    with closing(_writable(temporary)) as db:
        count = _update(db, out)
    _remove(path)
    temporary.replace(path)
    return count


@contextmanager
def reading(out: Path) -> Iterator[sqlite3.Connection]:
    """The catalog of `out`, opened for reading. One of an earlier version is migrated first.

    Raises FileNotFoundError when there is none, InvalidInput (`asset/catalog-unreadable`) when it cannot be read.
    """
    path = out / CATALOG
    if not path.is_file():
        raise FileNotFoundError(path)
    try:
        db = _readable(path)
        if version_of(db) < VERSION:
            db.close()
            _migrate_under_lock(out)
            db = _readable(path)
        with closing(db):
            if version_of(db) > VERSION:
                raise unreadable("a newer version of Mana wrote it")
            db.row_factory = sqlite3.Row
            yield db
    except sqlite3.DatabaseError as error:
        raise unreadable(str(error)) from error


def writable(out: Path) -> sqlite3.Connection:
    """The catalog of `out`, which `update` has made, opened for writing; each statement is a transaction."""
    return _writable(out / CATALOG)


def fingerprints(out: Path) -> dict[str, str]:
    """The SHA-256 of the record of each asset, as it was when its rows were written. Raises as `reading`."""
    with reading(out) as db:
        sql = "SELECT asset_id, sha256 FROM assets JOIN records USING (key)"
        return {row["asset_id"]: row["sha256"] for row in db.execute(sql)}


def _readable(path: Path) -> sqlite3.Connection:
    """An open catalog that takes no statement that writes.

    A reader of a WAL database makes files beside it, which only a connection that may write removes at its end. In a
    folder that is read-only there can be none, and nobody writes either.
    """
    address = path.resolve().as_uri()
    db = sqlite3.connect(f"{address}?mode=rw", uri=True, timeout=_BUSY_S, isolation_level=None)
    try:
        version_of(db)
    except sqlite3.OperationalError:
        db.close()
        db = sqlite3.connect(f"{address}?immutable=1", uri=True, isolation_level=None)
    db.execute("PRAGMA query_only = 1")
    return db


def _writable(path: Path) -> sqlite3.Connection:
    """An open catalog of this version; the connection has no implicit transactions."""
    db = sqlite3.connect(path, timeout=_BUSY_S, isolation_level=None)
    db.execute("PRAGMA journal_mode = WAL")
    db.execute("PRAGMA synchronous = NORMAL")
    migrate(db)
    return db


def _migrate_under_lock(out: Path) -> None:
    try:
        with exclusive(out):
            update(out)
    except FolderUnusable as error:
        raise unreadable(f"an earlier version wrote it, and {error}") from error
    except sqlite3.OperationalError as error:
        raise unreadable(f"an earlier version wrote it, and it cannot be migrated: {error}") from error


def _is_sound(path: Path) -> bool:
    """Whether the file at `path` is a catalog of this version or an earlier one; also False when there is none."""
    if not path.is_file():
        return False
    try:
        with closing(sqlite3.connect(path, timeout=_BUSY_S, isolation_level=None)) as db:
            if not 0 < version_of(db) <= VERSION:
                return False
            if version_of(db) < VERSION:
                migrate(db)
            return _tables(db) == _tables_of_version() and db.execute("PRAGMA quick_check(1)").fetchone()[0] == "ok"
    except sqlite3.OperationalError as error:
        if "no such" in str(error) or "already exists" in str(error):  # The tables of something else.
            return False
        raise
    except sqlite3.DatabaseError:
        return False


def _tables(db: sqlite3.Connection) -> set[tuple[str, str]]:
    return set(db.execute("SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL"))


def _tables_of_version() -> set[tuple[str, str]]:
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as db:
        migrate(db)
        return _tables(db)


def _remove(path: Path) -> None:
    for suffix in ("", "-wal", "-shm", "-journal"):
        path.with_name(path.name + suffix).unlink(missing_ok=True)


def _update(db: sqlite3.Connection, out: Path) -> int:
    """Write what has changed, in one transaction; the number of assets."""
    db.execute("BEGIN IMMEDIATE")
    try:
        db.execute("CREATE TEMP TABLE present (path TEXT PRIMARY KEY, stamp TEXT) WITHOUT ROWID")
        db.executemany("INSERT INTO present VALUES (?, ?)", _stamps(out))
        digests: set[str] = set()
        gone = "SELECT path FROM stamps WHERE path NOT IN (SELECT path FROM present) ORDER BY path"
        count = 0
        for (name,) in db.execute(gone).fetchall():
            count += _remove_rows(db, name, digests)
            db.execute("DELETE FROM stamps WHERE path = ?", (name,))
        changed = (
            "SELECT path, present.stamp FROM present LEFT JOIN stamps USING (path) "
            "WHERE stamps.stamp IS NOT present.stamp ORDER BY path"
        )
        for name, stamp in db.execute(changed).fetchall():
            count += _read_outcomes(db, out) if name == REPORT else _write_rows(db, out, name, digests)
            db.execute("INSERT OR REPLACE INTO stamps VALUES (?, ?)", (name, stamp))
        if not (out / REPORT).is_file():
            db.execute("DELETE FROM outcomes")
        update_neighbours(db, digests)
        db.execute("COMMIT")
    except BaseException:
        db.execute("ROLLBACK")
        raise
    db.execute("DROP TABLE present")
    return count


def _stamps(out: Path) -> Iterator[tuple[str, str]]:
    """Each package folder, and the report, with the state of its file: another inode, size or time is another file."""
    with os.scandir(out) as entries:
        for entry in entries:
            is_report = entry.name == REPORT
            if entry.name.startswith(".") or not (is_report or entry.is_dir()):
                continue
            try:
                state = os.stat(entry.path if is_report else os.path.join(entry.path, RECORD))
            except OSError:
                continue
            yield entry.name, f"{state.st_ino} {state.st_size} {state.st_mtime_ns}"


def _write_rows(db: sqlite3.Connection, out: Path, name: str, digests: set[str]) -> int:
    """Replace the rows of one asset by those of its record; 0 when the record is as it was or there is none."""
    data = _bytes(out / name / RECORD)
    sha256 = hashlib.sha256(data).hexdigest()
    row = db.execute("SELECT key, sha256 FROM assets JOIN records USING (key) WHERE asset_id = ?", (name,)).fetchone()
    if row is not None and row[1] == sha256:
        return 0
    removed = _remove_rows(db, name, digests)
    record = read_record(out / name)
    if record is None:
        return removed
    insert_record(db, record, sha256, digests, None if row is None else row[0])
    return 1


def insert_record(
    db: sqlite3.Connection, record: AssetRecord, sha256: str, digests: set[str], key: int | None = None
) -> None:
    """Insert the rows of a record that has none, under `key` or the next one; `sha256` is that of its file.

    The digest of its descriptor is added to `digests`, for `update_neighbours`.
    """
    if key is None:
        key = int(db.execute("SELECT coalesce(max(key), 0) + 1 FROM assets").fetchone()[0])
    rows = rows_of(record, sha256)
    for table in _KEYED_TABLES:
        for values in rows[table]:
            if table == "shapes":
                _insert_shape(db, key, values, digests)
            else:
                _insert(db, table, (key, *values))
    columns = "rowid, names, source_texts, aliases, others"
    db.executemany(f"INSERT INTO words ({columns}) VALUES (?, ?, ?, ?, ?)", [(key, *row) for row in rows["words"]])


def _insert(db: sqlite3.Connection, table: str, values: Row) -> None:
    db.execute(f"INSERT INTO {table} VALUES ({','.join('?' * len(values))})", values)


def _insert_shape(db: sqlite3.Connection, key: int, values: Row, digests: set[str]) -> None:
    digest, scale_m, geometry, vector = values
    _insert(db, "shapes", (key, digest, scale_m, geometry))
    db.execute("INSERT OR IGNORE INTO descriptors (digest, vector) VALUES (?, ?)", (digest, vector))
    digests.add(str(digest))


def _remove_rows(db: sqlite3.Connection, name: str, digests: set[str]) -> int:
    """Remove the rows of one asset; the number of assets, 0 or 1."""
    row = db.execute("SELECT key FROM assets WHERE asset_id = ?", (name,)).fetchone()
    if row is None:
        return 0
    digests.update(digest for (digest,) in db.execute("SELECT digest FROM shapes WHERE key = ?", row))
    for table in _KEYED_TABLES:
        db.execute(f"DELETE FROM {table} WHERE key = ?", row)
    db.execute("DELETE FROM words WHERE rowid = ?", row)
    return 1


def _read_outcomes(db: sqlite3.Connection, out: Path) -> int:
    """Take the sources of the last report over: only rows that differ are written. Never counts as an asset."""
    db.execute("CREATE TEMP TABLE IF NOT EXISTS reported (source TEXT PRIMARY KEY, outcome, codes, packages)")
    db.execute("DELETE FROM reported")
    try:
        for item in read_items(out):
            values = (item.source, item.outcome.value, ",".join(item.codes), ",".join(item.packages))
            db.execute("INSERT OR REPLACE INTO reported VALUES (?, ?, ?, ?)", values)
    except InvalidInput:  # Of an earlier version, or damaged: the next batch writes it anew.
        db.execute("DELETE FROM reported")
    db.execute("INSERT OR REPLACE INTO outcomes SELECT * FROM (SELECT * FROM reported EXCEPT SELECT * FROM outcomes)")
    db.execute("DELETE FROM outcomes WHERE source NOT IN (SELECT source FROM reported)")
    return 0


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""


def unreadable(why: str) -> InvalidInput:
    """The finding about a catalog that cannot be read, and the reason."""
    headline = f"{CATALOG} cannot be read ({why}); `mana assets ingest` writes it anew"
    return InvalidInput(finding("asset/catalog-unreadable", headline))
