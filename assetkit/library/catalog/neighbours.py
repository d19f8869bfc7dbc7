"""Candidates for near-duplicates: for each shape descriptor the nearest others, looked up in an R*-tree of boxes.

Works on digests of descriptors rather than on assets, so that a thousand equal boxes are one entry.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable

import numpy as np

from geom.features.shape_descriptor import MOMENTS, descriptor_distances
from schemas.arrays import FloatArray

# Copies that were turned, scaled, exported anew or lightly decimated are nearer (docs/benchmarks.md, near-duplicates).
NEAR_DESCRIPTOR = 0.03
# Neighbours of one descriptor that are compared: the number of comparisons grows with the number of assets alone.
MOST_NEIGHBOURS = 8


def update_neighbours(db: sqlite3.Connection, digests: Iterable[str]) -> None:
    """Bring boxes and neighbours up to date after assets with these digests came or went."""
    affected: set[str] = set()
    for digest in sorted(digests):
        number, vector, is_used = _state(db, digest)
        if number is None or vector is None:
            continue
        boxed = db.execute("SELECT 1 FROM descriptor_boxes WHERE number = ?", (number,)).fetchone() is not None
        if is_used == boxed:
            if not is_used:  # It came and went within one update.
                db.execute("DELETE FROM descriptors WHERE number = ?", (number,))
            continue
        affected.update(other for other, _ in _near(db, vector))
        if is_used:
            box = [bound for value in _coordinates(vector) for bound in (value, value)]
            db.execute(f"INSERT INTO descriptor_boxes VALUES ({','.join('?' * 11)})", (number, *box))
            affected.add(digest)
        else:
            affected.discard(digest)
            db.execute("DELETE FROM descriptor_boxes WHERE number = ?", (number,))
            db.execute("DELETE FROM descriptors WHERE number = ?", (number,))
            db.execute("DELETE FROM neighbours WHERE digest = ? OR other = ?", (digest, digest))
    for digest in sorted(affected):
        _, vector, _ = _state(db, digest)
        db.execute("DELETE FROM neighbours WHERE digest = ?", (digest,))
        if vector is None:
            continue
        nearest = sorted(((d, other) for other, d in _near(db, vector) if other != digest))[:MOST_NEIGHBOURS]
        db.executemany("INSERT INTO neighbours VALUES (?, ?, ?)", [(digest, other, d) for d, other in nearest])


def _state(db: sqlite3.Connection, digest: str) -> tuple[int | None, FloatArray | None, bool]:
    """Number and vector of a digest, and whether an asset has it."""
    row = db.execute("SELECT number, vector FROM descriptors WHERE digest = ?", (digest,)).fetchone()
    used = db.execute("SELECT 1 FROM shapes WHERE digest = ? LIMIT 1", (digest,)).fetchone() is not None
    return (None, None, used) if row is None else (row[0], np.frombuffer(row[1]), used)


def _near(db: sqlite3.Connection, vector: FloatArray) -> list[tuple[str, float]]:
    """The digests in the tree within `NEAR_DESCRIPTOR` of a vector, with their distances."""
    limits = [limit for c in _coordinates(vector) for limit in (c + NEAR_DESCRIPTOR, c - NEAR_DESCRIPTOR)]
    inside = " AND ".join(f"low_{k} <= ? AND high_{k} >= ?" for k in range(1, 6))
    sql = f"SELECT digest, vector FROM descriptor_boxes JOIN descriptors USING (number) WHERE {inside}"
    rows = db.execute(sql, limits).fetchall()
    if not rows:
        return []
    vectors = np.frombuffer(b"".join(row[1] for row in rows)).reshape(len(rows), -1)
    distances = descriptor_distances(vector, vectors)
    return [(row[0], float(d)) for row, d in zip(rows, distances, strict=True) if d <= NEAR_DESCRIPTOR]


def _coordinates(vector: FloatArray) -> list[float]:
    """Five figures that differ by at most the distance of two vectors: moments (without the last second moment, which
    follows from the others) and the mean of the quantiles.
    """
    return [*(float(vector[k]) for k in (0, 1, 3, 4)), float(vector[MOMENTS:].mean())]
