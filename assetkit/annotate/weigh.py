"""Combines the categories that a model gives for pictures with those of names and shape.

The model gets names and size beside the pictures, so what agrees with it confirms nothing: names and model together
are as sure as the surer of them. When they differ, each is doubted by as much as the other leads; a shape that
contradicts either is measured, and decides.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from assetkit.annotate.annotator import (
    MIN_SCORE,
    UNKNOWN,
    Annotation,
    CategoryScore,
    EndpointResult,
    ObjectShape,
    ranked_annotation,
)
from assetkit.annotate.shape_check import compare
from assetkit.taxonomy.tables import categories
from schemas.asset import EndpointAnswer

# Factor on a model's own confidence: models are overconfident. A judgement, measured against no endpoint.
MODEL_TRUST = 0.8


def weigh(embedded: Annotation, endpoint_result: EndpointResult, shape: ObjectShape) -> Annotation:
    """The annotation from both; the embedded one with `endpoint_result` in it where the model gave no category."""
    answer = endpoint_result.answer
    if answer is None or not answer.categories:
        return replace(embedded, endpoint_result=endpoint_result)
    seen = {name: _seen(name, chance, answer.method, shape) for name, chance in answer.categories.items()}
    named = {h.category: h for h in embedded.hypotheses}
    lead_seen = max(h.score for h in seen.values())
    lead_named = max((h.score for h in named.values()), default=0.0)
    hypotheses = []
    for name in dict.fromkeys((*seen, *named)):
        sides = [side[name] for side in (seen, named) if name in side]
        own_seen, own_named = _score(seen, name), _score(named, name)
        doubt = (1.0 - (lead_seen - own_seen)) * (1.0 - (lead_named - own_named))
        clues = tuple(dict.fromkeys(clue for side in sides for clue in side.clues))
        hypotheses.append(CategoryScore(name, round(max(own_seen, own_named) * doubt, 3), clues))
    against = _contradictions(embedded, answer, shape)
    result = ranked_annotation(hypotheses, embedded.method, (*embedded.contradictions, *against))
    best = result.hypotheses[0].category
    method = answer.method if _score(seen, best) > _score(named, best) else embedded.method
    return replace(result, method=method, disputed=bool(against), endpoint_result=endpoint_result)


def _score(side: Mapping[str, CategoryScore], category: str) -> float:
    return side[category].score if category in side else 0.0


def _seen(category: str, chance: float, method: str, shape: ObjectShape) -> CategoryScore:
    findings = compare(categories()[category], shape)
    score = MODEL_TRUST * chance * math.prod(f.remaining_chance for f in findings)
    against = (f"against it: {f.text}" for f in findings if f.remaining_chance < 1.0)
    return CategoryScore(category, round(score, 3), (f"{method}, sees a {category} ({chance:.2f})", *against))


def _contradictions(embedded: Annotation, answer: EndpointAnswer, shape: ObjectShape) -> tuple[str, ...]:
    """Contradictions by names and shape of a category that pictures alone would make accepted, in words."""
    best, chance = next(iter(answer.categories.items()))
    if MODEL_TRUST * chance <= MIN_SCORE:
        return ()
    texts = [f"seen as {best}, but {f.text}" for f in compare(categories()[best], shape) if f.remaining_chance < 1.0]
    if embedded.category not in (UNKNOWN, best):
        texts.append(f"seen as {best}, but {embedded.hypotheses[0].clues[0]}")
    return tuple(texts)
