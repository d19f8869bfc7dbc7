"""Search in a catalog: the same hits, scores and reasons as `search` over all facts, by look-ups in its indexes.

Each criterion becomes a query for the assets that match it, with their confidences; the sets are joined and ranked, and
only the facts of those shown are read.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Collection, Iterable, Mapping, Sequence
from heapq import nsmallest
from pathlib import Path

from pydantic import ValidationError

from assetkit.library.catalog.criterion_sql import TEXT_CONFIDENCE, criterion_sql, match_expression
from assetkit.library.catalog.store import reading, unreadable
from assetkit.library.search.facts import Facts
from assetkit.library.search.match import TextHit
from assetkit.library.search.query import Criterion
from assetkit.library.search.search import (
    MAX_NEAR,
    UNMET_OPTIONAL_SCORE,
    Hit,
    SearchResult,
    hit_of,
    is_near_miss,
    score_of,
)

# A set this many times larger than the one at hand is not read but looked up asset by asset.
LARGER = 20
_AMONG = "(SELECT value FROM json_each(?))"
Confidences = dict[int, float]  # by key of the asset, above 0


def search_catalog(out: Path, criteria: Sequence[Criterion], limit: int) -> SearchResult:
    """The best `limit` assets that match the criteria, as `search` ranks them. Raises as `reading`."""
    with reading(out) as db:
        required = [c for c in criteria if not c.optional]
        sets = _required_sets(db, required)
        keys = _common([sets[c] for c in required]) if required else _all_keys(db)
        optional = {c: _confidences(db, c, keys) for c in criteria if c.optional}
        sets_of_hits = {**sets, **optional}
        best = _ranked(db, {key: _score(key, criteria, sets_of_hits) for key in keys}, limit)
        near = _near_misses(db, criteria, keys) if len(keys) < MAX_NEAR else []
        hits, near_misses = (tuple(_hits(db, chosen, criteria)) for chosen in (best, near))
        unmatched = tuple(c for c in criteria if not (sets_of_hits[c] or _matches_any(db, c)))
        return SearchResult(tuple(criteria), hits, near_misses, unmatched, len(keys))


def facts(out: Path) -> list[Facts]:
    """The searchable facts of every asset, by asset id. Raises as `reading`."""
    with reading(out) as db:
        rows = db.execute("SELECT facts FROM assets JOIN records USING (key) ORDER BY asset_id")
        return [_facts(row["facts"]) for row in rows]


def find_text(out: Path, criterion: Criterion) -> TextHit:
    """The assets whose texts contain one of the words of a criterion, with the column of highest confidence. A word
    also matches the beginning of a longer one, unless the criterion is negated.
    """
    with reading(out) as db:
        return _text_hits(db, criterion, None)


def _required_sets(db: sqlite3.Connection, required: Sequence[Criterion]) -> dict[Criterion, Confidences]:
    """The assets that match each criterion; of a large set only those that match the smaller ones."""
    sizes = {c: _count(db, c) for c in required}
    sets: dict[Criterion, Confidences] = {}
    keys: Collection[int] | None = None
    for c in sorted(required, key=lambda c: sizes[c]):
        looked_up = keys is not None and len(keys) * LARGER < sizes[c]
        sets[c] = _confidences(db, c, keys if looked_up else None)
        keys = sets[c].keys() if keys is None else keys & sets[c].keys()
    return sets


def _common(sets: Sequence[Confidences]) -> list[int]:
    smallest, *others = sorted(sets, key=len)
    return [key for key in smallest if all(key in other for other in others)]


def _all_keys(db: sqlite3.Connection) -> list[int]:
    return [row[0] for row in db.execute("SELECT key FROM assets")]


def _score(key: int, criteria: Sequence[Criterion], sets: Mapping[Criterion, Confidences]) -> float:
    return score_of([sets[c].get(key, UNMET_OPTIONAL_SCORE) for c in criteria])


def _ranked(db: sqlite3.Connection, scores: Mapping[int, float], limit: int) -> list[int]:
    """The first `limit` keys by score, highest first, then by asset id; only ids that may be shown are read."""
    last = nsmallest(limit, (-score for score in scores.values()))
    if not last:
        return []
    shown = [key for key, score in scores.items() if -score <= last[-1]]
    ids = _ids(db, shown)
    return sorted(shown, key=lambda key: (-scores[key], ids[key]))[:limit]


def _ids(db: sqlite3.Connection, keys: Iterable[int]) -> dict[int, str]:
    return {key: db.execute("SELECT asset_id FROM assets WHERE key = ?", (key,)).fetchone()[0] for key in keys}


def _near_misses(db: sqlite3.Connection, criteria: Sequence[Criterion], hits: Collection[int]) -> list[int]:
    """Keys of the assets of the right kind that lack least, best first."""
    kinds = [c for c in criteria if c.is_kind]
    within: Collection[int] | None = _common([_confidences(db, c, None) for c in kinds]) if kinds else None
    sets = {c: _confidences(db, c, within) for c in criteria}
    missed = set().union(*sets.values()) - set(hits)
    matched = {key: [c for c in criteria if key in sets[c]] for key in missed}
    near = {key: cs for key, cs in matched.items() if is_near_miss(cs, criteria)}
    fewest = sorted({len(criteria) - len(cs) for cs in near.values()})
    listed: list[int] = []
    for lacking in fewest:
        scores = {k: _score(k, criteria, sets) for k, cs in near.items() if len(criteria) - len(cs) == lacking}
        listed += _ranked(db, scores, MAX_NEAR)
        if len(listed) >= MAX_NEAR:
            break
    return listed[:MAX_NEAR]


def _hits(db: sqlite3.Connection, keys: Sequence[int], criteria: Sequence[Criterion]) -> Iterable[Hit]:
    """The facts of assets with their reasons, in the order of `keys`."""
    texts = {c: _text_hits(db, c, keys) for c in criteria if c.field == "text"}
    for key in keys:
        row = db.execute("SELECT facts FROM records WHERE key = ?", (key,)).fetchone()
        yield hit_of(_facts(row[0]), criteria, texts)


def _facts(text: str) -> Facts:
    try:
        return Facts.model_validate_json(text)
    except ValidationError as error:
        raise unreadable("its facts are of another version") from error


def _matches_any(db: sqlite3.Connection, criterion: Criterion) -> bool:
    sql, values = criterion_sql(db, criterion)
    return db.execute(f"SELECT 1 FROM ({sql}) LIMIT 1", values).fetchone() is not None


def _count(db: sqlite3.Connection, criterion: Criterion) -> int:
    sql, values = criterion_sql(db, criterion)
    return int(db.execute(f"SELECT count(*) FROM ({sql})", values).fetchone()[0])


def _confidences(db: sqlite3.Connection, criterion: Criterion, keys: Collection[int] | None) -> Confidences:
    """Key and confidence of the assets that match a criterion: of all, or of those among `keys`."""
    sql, values = criterion_sql(db, criterion)
    if keys is not None:
        sql, values = f"SELECT * FROM ({sql}) WHERE key IN {_AMONG}", [*values, _listed(keys)]
    best: Confidences = {}
    for key, confidence in db.execute(sql, values):
        if confidence > best.get(key, 0.0):
            best[key] = confidence
    return best


def _text_hits(db: sqlite3.Connection, criterion: Criterion, keys: Collection[int] | None) -> TextHit:
    """Column, confidence and matched words by asset id: of all assets, or of those among `keys`."""
    within = "" if keys is None else f" AND words.rowid IN {_AMONG}"
    among = () if keys is None else (_listed(keys),)
    sql = (
        "SELECT asset_id, snippet(words, -1, '', '', '...', 8) AS matched "
        f"FROM words JOIN assets ON assets.key = words.rowid WHERE words MATCH ?{within}"
    )
    hits: dict[str, tuple[str, float, str]] = {}
    for column, confidence in TEXT_CONFIDENCE.items():
        for word in criterion.values:
            for row in db.execute(sql, (match_expression(column, (word,), criterion), *among)):
                hits.setdefault(row["asset_id"], (column, confidence, row["matched"]))
    return hits


def _listed(keys: Iterable[int]) -> str:
    """Keys as one value of a statement, which takes any number of them."""
    return json.dumps(list(keys))
