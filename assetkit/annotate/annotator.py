"""The interface of annotators: the evidence about an object in, the ranked categories with scores and clues out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from schemas.asset import EndpointAnswer
from schemas.diagnostics import Diagnostic
from schemas.outcome import EndpointUse

UNKNOWN = "unknown"
# A category is accepted above this score, when the score of the next is below this share of it.
MIN_SCORE = 0.5
MAX_RUNNER_UP_RATIO = 0.75


@dataclass(frozen=True)
class ObjectShape:
    """Size and form of an object, independent of its pose.

    extents_m  edges of the smallest bounding box, shortest first.
    fill       share of that box that the convex hull takes: box 1, cylinder 0.79, ball 0.52; None without volume.
    hollow     share of the convex hull that is empty; None where unknown (the solid is a hull).
    metric     whether the edges are known in metres; else only their proportions are.
    """

    extents_m: tuple[float, float, float]
    fill: float | None
    hollow: float | None
    metric: bool = True


@dataclass(frozen=True)
class Observation:
    """All evidence about one object.

    file       stem of the source file.             folders  names of its folders, nearest first.
    nodes      names of nodes and meshes.           materials  names of render materials.
    titles     titles stated in the file.          shared     whether the file holds other objects as well.
    views      PNG pictures by name, in the order to be shown; only for an annotator that looks at them.
    articulated  whether its nodes are the links of a mechanism.
    """

    file: str
    folders: tuple[str, ...]
    nodes: tuple[str, ...]
    materials: tuple[str, ...]
    titles: tuple[str, ...]
    shape: ObjectShape
    shared: bool = False
    views: Mapping[str, bytes] = field(default_factory=dict)
    articulated: bool = False


@dataclass(frozen=True)
class CategoryScore:
    """One category with the probability that it is right, and the clues for and against it in words."""

    category: str
    score: float
    clues: tuple[str, ...]


@dataclass(frozen=True)
class EndpointResult:
    """The result of a query to an endpoint: its answer, or None and a finding with the reason."""

    answer: EndpointAnswer | None
    use: EndpointUse
    findings: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class Annotation:
    """Ranked hypotheses, best first; `category` is `unknown` unless the first one is accepted, for `reason`.

    method           by which the first hypothesis was found.
    contradictions   categories of names or pictures that shape or each other contradict, in words.
    disputed         whether pictures are contradicted, so that a person must decide.
    endpoint_result  None when no endpoint was queried.
    """

    category: str
    hypotheses: tuple[CategoryScore, ...]
    reason: str
    method: str
    contradictions: tuple[str, ...] = ()
    disputed: bool = False
    endpoint_result: EndpointResult | None = None

    @property
    def score(self) -> float:
        """Of the category, 0 while it is unknown."""
        return 0.0 if self.category == UNKNOWN else self.hypotheses[0].score


class Annotator(Protocol):
    """Finds the category of an object: the embedded annotator needs names, a multimodal one pictures."""

    def annotate(self, observation: Observation) -> Annotation:
        """The annotation; deterministic, never raises for what the evidence holds or an endpoint answers."""
        ...


def ranked_annotation(
    hypotheses: Sequence[CategoryScore], method: str, contradictions: tuple[str, ...] = ()
) -> Annotation:
    """The annotation of these hypotheses: ranked, and the first one is accepted when it is likely and well ahead.

    `method` and `contradictions` become those of the annotation.
    """
    ranked = tuple(sorted(hypotheses, key=lambda h: (-h.score, h.category)))
    best, others = ranked[0], ranked[1:]
    if others and others[0].score >= MAX_RUNNER_UP_RATIO * best.score:
        return Annotation(UNKNOWN, ranked, f"{best.category} or {others[0].category}", method, contradictions)
    if best.score <= MIN_SCORE:
        reason = f"perhaps {best.category}, on thin evidence"
        return Annotation(UNKNOWN, ranked, reason, method, contradictions)
    return Annotation(best.category, ranked, "; ".join(best.clues), method, contradictions)
