"""Near-duplicates of a library: assets with the same surface up to rotation and scale, found and verified.

Candidates come from the shape descriptors in the catalog. Each is compared by the surfaces of both packages as re-read
from disk, after alignment; results stay in the catalog until one of the two packages changes. Both are kept.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from assetkit.batch.item_cells import DEFAULT_LIMITS, ENVIRONMENT
from assetkit.library.catalog.store import reading, writable
from jobs.cell import Limits
from jobs.warm import run_module

# Largest distance of aligned surfaces, as a share of the diagonal. Copies in docs/benchmarks.md stay below 0.8 %, from
# 1.0 % on lie objects that differ: a cube with letters cut into it, wheels of one car, handles of one cabinet.
SAME_SURFACE = 0.01
PAIRS_PER_CELL = 50  # Half a minute of work, a tenth of the limit; after a crash the next cell goes on.
WORKER = "assetkit.library.compare_worker"
# Assets with equal descriptors are compared with the first of them, the first with those of near descriptors.
_PAIRS = """
WITH firsts AS (SELECT digest, min(asset_id) AS asset_id FROM shapes JOIN assets USING (key) GROUP BY digest),
  edges AS (
    SELECT firsts.asset_id AS a, assets.asset_id AS b FROM firsts JOIN shapes USING (digest) JOIN assets USING (key)
    UNION SELECT f.asset_id, g.asset_id FROM neighbours n
      JOIN firsts f ON f.digest = n.digest JOIN firsts g ON g.digest = n.other)
SELECT DISTINCT min(a, b) AS asset_id, max(a, b) AS other_id, s.geometry AS geometry, t.geometry AS other_geometry
FROM edges JOIN assets x ON x.asset_id = min(a, b) JOIN shapes s ON s.key = x.key
  JOIN assets y ON y.asset_id = max(a, b) JOIN shapes t ON t.key = y.key
WHERE a <> b ORDER BY 1, 2"""
Pair = tuple[str, str, str, str]


@dataclass(frozen=True)
class NearDuplicate:
    """Two assets with the same surface; `scale_ratio` is the size of the other over that of the first.

    The distances are those of the aligned surfaces as shares of the diagonal of the first one's bounding box.
    """

    asset_id: str
    other_id: str
    scale_ratio: float
    mean_share: float
    max_share: float


def refresh_near_duplicates(out: Path, limits: Limits = DEFAULT_LIMITS) -> int:
    """Compare the candidates in the catalog of `out` that were not compared yet; returns their number.

    The caller holds the lock of the folder. A pair that takes its cell down is noted as failed and not tried again.
    """
    with closing(writable(out)) as db:
        db.execute("CREATE TEMP TABLE pairs (asset_id, other_id, geometry, other_geometry)")
        db.execute(f"INSERT INTO pairs {_PAIRS}")
        same = "asset_id, other_id, geometry, other_geometry"
        db.execute(f"DELETE FROM comparisons WHERE ({same}) NOT IN (SELECT {same} FROM pairs)")
        pending: list[Pair] = db.execute(
            f"SELECT {same} FROM pairs WHERE (asset_id, other_id) NOT IN (SELECT asset_id, other_id FROM comparisons) "
            "ORDER BY asset_id, other_id"
        ).fetchall()
        left = pending
        while left:
            chunk = left[:PAIRS_PER_CELL]
            rows = _compared(out, chunk, limits)
            if not rows:  # The batch is being stopped; the next one goes on here.
                break
            marks = ",".join("?" * 9)
            db.executemany(f"INSERT INTO comparisons VALUES ({marks})", rows)
            left = left[len(rows) :]
    return len(pending)


def near_duplicates(out: Path) -> list[NearDuplicate]:
    """All pairs of near-duplicates in the catalog of `out`, by ids. Raises as `catalog.reading`."""
    sql = (
        "SELECT asset_id, other_id, scale_ratio, mean_share, max_share FROM comparisons "
        "WHERE failure IS NULL AND max_share <= ? ORDER BY asset_id, other_id"
    )
    with reading(out) as db:
        return [NearDuplicate(*row) for row in db.execute(sql, (SAME_SURFACE,))]


def groups_of(pairs: Sequence[NearDuplicate]) -> list[tuple[str, ...]]:
    """The assets that pairs connect, each group and all groups by id."""
    group: dict[str, set[str]] = {}
    for pair in pairs:
        joined = group.get(pair.asset_id, {pair.asset_id}) | group.get(pair.other_id, {pair.other_id})
        group.update(dict.fromkeys(joined, joined))
    return sorted({tuple(sorted(members)) for members in group.values()})


def _compared(out: Path, pairs: Sequence[Pair], limits: Limits) -> list[tuple[object, ...]]:
    """The rows of the first of the pairs, at least of one: up to the one that took the cell down, if any."""
    with tempfile.TemporaryDirectory(prefix="mana") as folder:
        request, results = Path(folder) / "pairs.json", Path(folder) / "results.jsonl"
        request.write_text(json.dumps([pair[:2] for pair in pairs]))
        arguments = [os.fspath(out.absolute()), os.fspath(request), os.fspath(results)]
        ended = run_module(WORKER, arguments, limits, env=ENVIRONMENT)
        lines = results.read_text().splitlines() if results.is_file() else []
    figures = [_figures(line) for line in lines[: len(pairs)]]
    if len(figures) < len(pairs) and ended.status != "cancelled":
        figures.append((None, None, None, None, ended.status))
    return [(*pair, *row) for pair, row in zip(pairs, figures, strict=False)]


def _figures(line: str) -> tuple[object, ...]:
    row = json.loads(line)
    return tuple(row.get(name) for name in ("scale_ratio", "mean_share", "p95_share", "max_share", "failure"))
