"""What a model saw, weighed against what names and shape say.

The model is shown names and size beside the pictures, so what agrees with it confirms nothing: names and model together
are as sure as the surer of them. When they differ, each is doubted by as much as the other leads; a shape that speaks
against either is measured, and believed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from assetkit.annotate.annotator import STANDS, UNKNOWN, Annotation, Asked, Hypothesis, Shape, decided
from assetkit.annotate.shape_check import compare
from assetkit.taxonomy.tables import categories
from schemas.asset import EndpointAnswer

# How far a model's own confidence is believed: models are surer than right. A judgement, measured against no endpoint.
SEEN = 0.8


def weigh(embedded: Annotation, asked: Asked, shape: Shape) -> Annotation:
    """The annotation from both; the embedded one with `asked` in it where the model gave no category."""
    answer = asked.answer
    if answer is None or not answer.categories:
        return replace(embedded, asked=asked)
    seen = {name: _seen(name, chance, answer.method, shape) for name, chance in answer.categories.items()}
    named = {h.category: h for h in embedded.hypotheses}
    lead_seen = max(h.score for h in seen.values())
    lead_named = max((h.score for h in named.values()), default=0.0)
    found = []
    for name in dict.fromkeys((*seen, *named)):
        sides = [side[name] for side in (seen, named) if name in side]
        own_seen, own_named = _score(seen, name), _score(named, name)
        doubt = (1.0 - (lead_seen - own_seen)) * (1.0 - (lead_named - own_named))
        clues = tuple(dict.fromkeys(clue for side in sides for clue in side.clues))
        found.append(Hypothesis(name, round(max(own_seen, own_named) * doubt, 3), clues))
    against = _contradictions(embedded, answer, shape)
    result = decided(found, embedded.method, (*embedded.contradictions, *against))
    best = result.hypotheses[0].category
    method = answer.method if _score(seen, best) > _score(named, best) else embedded.method
    return replace(result, method=method, disputed=bool(against), asked=asked)


def _score(side: Mapping[str, Hypothesis], category: str) -> float:
    return side[category].score if category in side else 0.0


def _seen(category: str, chance: float, method: str, shape: Shape) -> Hypothesis:
    findings = compare(categories()[category], shape)
    score = SEEN * chance * math.prod(f.leaves for f in findings)
    against = (f"against it: {f.text}" for f in findings if f.leaves < 1.0)
    return Hypothesis(category, round(score, 3), (f"{method}, sees a {category} ({chance:.2f})", *against))


def _contradictions(embedded: Annotation, answer: EndpointAnswer, shape: Shape) -> tuple[str, ...]:
    """What names and shape say against a category that pictures alone would have made stand, in words."""
    best, chance = next(iter(answer.categories.items()))
    if SEEN * chance <= STANDS:
        return ()
    said = [f"seen as {best}, but {f.text}" for f in compare(categories()[best], shape) if f.leaves < 1.0]
    if embedded.category not in (UNKNOWN, best):
        said.append(f"seen as {best}, but {embedded.hypotheses[0].clues[0]}")
    return tuple(said)
