"""Search: the assets of a library that grant the wishes of a request, best first, each with its reasons."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from assetkit.library.search.facts import Facts
from assetkit.library.search.match import Answer, TextHit, judge
from assetkit.library.search.query import Wish

UNMET_SOFT = 0.3  # What a soft wish costs that is not granted.
MAX_NEAR = 5
FindText = Callable[[Wish], TextHit]


@dataclass(frozen=True)
class Hit:
    """An asset with its answers; `score` in 0..1 ranks it, `lacks` are the answers that say no."""

    asset: Facts
    score: float
    why: tuple[Answer, ...]
    lacks: tuple[Answer, ...]


@dataclass(frozen=True)
class Found:
    """What a search found.

    hits       assets that grant every wish that is not soft, best first.
    near       where these are few: assets that grant what kind of thing is wanted and miss something else.
    unmatched  wishes that no asset at all grants.
    """

    wishes: tuple[Wish, ...]
    hits: tuple[Hit, ...]
    near: tuple[Hit, ...]
    unmatched: tuple[Wish, ...]


def search(assets: Sequence[Facts], wishes: Sequence[Wish], find_text: FindText) -> Found:
    """The assets that grant the wishes. `find_text` looks for the words of one wish in the texts of all assets: full
    text, or anything that answers alike, such as the likeness of meanings.
    """
    texts: Mapping[Wish, TextHit] = {w: find_text(w) for w in wishes if w.field == "text"}
    judged = [_hit(asset, [judge(w, asset, texts) for w in wishes]) for asset in assets]
    judged.sort(key=lambda hit: (-hit.score, hit.asset.asset_id))
    granted = {answer.wish for hit in judged for answer in hit.why}
    hits = tuple(hit for hit in judged if _is_hit(hit))
    missed = [hit for hit in judged if not _is_hit(hit) and _is_near(hit, wishes)]
    near = sorted(missed, key=lambda hit: (len(hit.lacks), -hit.score, hit.asset.asset_id))
    unmatched = tuple(w for w in wishes if w not in granted)
    return Found(tuple(wishes), hits, tuple(near[:MAX_NEAR]) if len(hits) < MAX_NEAR else (), unmatched)


def _hit(asset: Facts, answers: Sequence[Answer]) -> Hit:
    """The score is the geometric mean of the confidences, so that one doubtful answer counts whatever the others."""
    why = tuple(a for a in answers if a.confidence > 0.0)
    lacks = tuple(a for a in answers if a.confidence == 0.0)
    counted = [a.confidence for a in why] + [UNMET_SOFT] * len(lacks)
    score = math.exp(sum(map(math.log, counted)) / len(counted)) if counted else 0.0
    return Hit(asset, round(score, 4), why, lacks)


def _is_hit(hit: Hit) -> bool:
    return all(answer.wish.soft for answer in hit.lacks)


def _is_near(hit: Hit, wishes: Sequence[Wish]) -> bool:
    """Of the kind that is wanted; where no kind is named, granting at least half of the wishes."""
    if any(w.names_thing for w in wishes):
        return not any(a.wish.names_thing for a in hit.lacks)
    return len(hit.why) >= len(hit.lacks)
