"""The tables of the catalog by version: each script takes a catalog of the version before it to its own.

The records beside the catalog are the truth, so a migration may drop rows: `update` reads those records again.
"""

from __future__ import annotations

import sqlite3

_VERSION_1 = """
CREATE TABLE IF NOT EXISTS assets (
  asset_id TEXT PRIMARY KEY, name TEXT, outcome TEXT, category TEXT, roles TEXT, license TEXT, format TEXT,
  size_x_m REAL, size_y_m REAL, size_z_m REAL, mass_kg REAL, material TEXT, collider TEXT, triangles INTEGER);
CREATE TABLE IF NOT EXISTS facts (asset_id TEXT PRIMARY KEY, facts TEXT);
CREATE VIRTUAL TABLE IF NOT EXISTS words USING fts5 (asset_id UNINDEXED, names, source_texts, aliases, others);
"""
# One integer key per asset joins all tables. `traits` holds every searchable value with its confidence; `outcomes` the
# sources of the last report; `stamps` the state (inode, size, time) of each file that was read; `shapes` and the tables
# below it what near-duplicates are found by (`neighbours`, `near_duplicates`).
_VERSION_2 = """
DROP TABLE assets;
DROP TABLE facts;
DROP TABLE words;
CREATE TABLE assets (
  key INTEGER PRIMARY KEY, asset_id TEXT UNIQUE NOT NULL, name TEXT, outcome TEXT, category TEXT, family TEXT,
  interaction_group TEXT, roles TEXT, license TEXT, license_source TEXT, license_method TEXT, author TEXT,
  generator TEXT, format TEXT, size_x_m REAL, size_y_m REAL, size_z_m REAL, longest_m REAL, mass_kg REAL,
  material TEXT, collider TEXT, triangles INTEGER, joints INTEGER, surfaces INTEGER, volumes INTEGER,
  capacity_m3 REAL, extent_confidence REAL, mass_confidence REAL);
CREATE INDEX assets_by_longest ON assets (longest_m, extent_confidence);
CREATE INDEX assets_by_height ON assets (size_z_m, extent_confidence);
CREATE INDEX assets_by_mass ON assets (mass_kg, mass_confidence);
CREATE TABLE traits (
  key INTEGER, field TEXT, value TEXT, confidence REAL, PRIMARY KEY (key, field, value)) WITHOUT ROWID;
CREATE INDEX traits_by_value ON traits (field, value, key, confidence);
CREATE TABLE records (key INTEGER PRIMARY KEY, sha256 TEXT, schema_version TEXT, facts TEXT);
CREATE TABLE sources (
  key INTEGER, position INTEGER, path TEXT, sha256 TEXT, bytes INTEGER, PRIMARY KEY (key, position)) WITHOUT ROWID;
CREATE INDEX sources_by_sha256 ON sources (sha256);
CREATE TABLE outcomes (source TEXT PRIMARY KEY, outcome TEXT, codes TEXT, packages TEXT);
CREATE VIRTUAL TABLE words USING fts5 (names, source_texts, aliases, others);
CREATE TABLE stamps (path TEXT PRIMARY KEY, stamp TEXT) WITHOUT ROWID;
CREATE TABLE shapes (key INTEGER PRIMARY KEY, digest TEXT, scale_m REAL, geometry TEXT);
CREATE INDEX shapes_by_digest ON shapes (digest, key);
CREATE TABLE descriptors (number INTEGER PRIMARY KEY, digest TEXT UNIQUE, vector BLOB);
CREATE VIRTUAL TABLE descriptor_boxes USING rtree (
  number, low_1, high_1, low_2, high_2, low_3, high_3, low_4, high_4, low_5, high_5);
CREATE TABLE neighbours (digest TEXT, other TEXT, distance REAL, PRIMARY KEY (digest, other)) WITHOUT ROWID;
CREATE INDEX neighbours_by_other ON neighbours (other);
CREATE TABLE comparisons (
  asset_id TEXT, other_id TEXT, geometry TEXT, other_geometry TEXT, scale_ratio REAL, mean_share REAL, p95_share REAL,
  max_share REAL, failure TEXT, PRIMARY KEY (asset_id, other_id)) WITHOUT ROWID;
"""
MIGRATIONS = (_VERSION_1, _VERSION_2)
VERSION = len(MIGRATIONS)


def version_of(db: sqlite3.Connection) -> int:
    """The version of an open catalog; one of before versions were counted is the first, an empty file is 0."""
    stated = int(db.execute("PRAGMA user_version").fetchone()[0])
    return stated or int(db.execute("SELECT count(*) FROM sqlite_master WHERE name = 'assets'").fetchone()[0])


def migrate(db: sqlite3.Connection) -> None:
    """Take an open catalog to `VERSION`, script by script, each in a transaction of its own.

    Raises sqlite3.DatabaseError where its tables are not those of the version that it states.
    """
    for version in range(version_of(db) + 1, VERSION + 1):
        db.executescript(f"BEGIN IMMEDIATE; {MIGRATIONS[version - 1]} PRAGMA user_version = {version}; COMMIT;")
