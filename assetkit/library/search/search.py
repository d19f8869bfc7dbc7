"""Ranks the assets of a library by how well they match the criteria of a request; each hit has its reasons."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from assetkit.library.search.facts import Facts
from assetkit.library.search.match import Match, TextHit, match_criterion
from assetkit.library.search.query import Criterion

UNMET_OPTIONAL_SCORE = 0.3  # Factor in the score for an optional criterion without a match.
MAX_NEAR = 5
FindText = Callable[[Criterion], TextHit]


@dataclass(frozen=True)
class Hit:
    """An asset with the criteria that it matches and those that it misses; `score` in 0..1 ranks it."""

    asset: Facts
    score: float
    matches: tuple[Match, ...]
    misses: tuple[Match, ...]


@dataclass(frozen=True)
class SearchResult:
    """Outcome of a search.

    hits         assets that match every criterion that is not optional, best first; the first of `total` of them.
    near_misses  where these are few: assets of the right kind that miss another criterion.
    unmatched    criteria that no asset matches.
    """

    criteria: tuple[Criterion, ...]
    hits: tuple[Hit, ...]
    near_misses: tuple[Hit, ...]
    unmatched: tuple[Criterion, ...]
    total: int


def search(assets: Sequence[Facts], criteria: Sequence[Criterion], find_text: FindText) -> SearchResult:
    """The assets that match the criteria. `find_text` looks for the words of one criterion in the texts of all assets:
    by full text, or by any other measure, such as similarity of meaning.
    """
    texts: Mapping[Criterion, TextHit] = {c: find_text(c) for c in criteria if c.field == "text"}
    scored = [hit_of(asset, criteria, texts) for asset in assets]
    scored.sort(key=lambda hit: (-hit.score, hit.asset.asset_id))
    matched = {result.criterion for hit in scored for result in hit.matches}
    hits = tuple(hit for hit in scored if _is_hit(hit))
    missed = [hit for hit in scored if not _is_hit(hit) and is_near_miss([r.criterion for r in hit.matches], criteria)]
    near = sorted(missed, key=lambda hit: (len(hit.misses), -hit.score, hit.asset.asset_id))
    unmatched = tuple(c for c in criteria if c not in matched)
    near_misses = tuple(near[:MAX_NEAR]) if len(hits) < MAX_NEAR else ()
    return SearchResult(tuple(criteria), hits, near_misses, unmatched, len(hits))


def hit_of(asset: Facts, criteria: Sequence[Criterion], texts: Mapping[Criterion, TextHit]) -> Hit:
    """The reasons for and against one asset; `texts` as in `match_criterion`."""
    return _score(asset, [match_criterion(c, asset, texts) for c in criteria])


def score_of(factors: Sequence[float]) -> float:
    """The geometric mean of the confidences of all criteria, so that one doubtful match counts whatever the others."""
    return round(math.exp(sum(map(math.log, factors)) / len(factors)), 4) if factors else 0.0


def is_near_miss(matched: Sequence[Criterion], criteria: Sequence[Criterion]) -> bool:
    """Whether an asset that matches some of the criteria is of the right kind; where no kind is named, whether it
    matches half of them or more.
    """
    if any(c.is_kind for c in criteria):
        return all(c in matched for c in criteria if c.is_kind)
    return 2 * len(matched) >= len(criteria)


def _score(asset: Facts, results: Sequence[Match]) -> Hit:
    matches = tuple(r for r in results if r.confidence > 0.0)
    misses = tuple(r for r in results if r.confidence == 0.0)
    factors = [r.confidence or UNMET_OPTIONAL_SCORE for r in results]
    return Hit(asset, score_of(factors), matches, misses)


def _is_hit(hit: Hit) -> bool:
    return all(result.criterion.optional for result in hit.misses)
