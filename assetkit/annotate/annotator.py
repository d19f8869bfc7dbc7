"""The interface between evidence and meaning: what an annotator is shown and what it answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from schemas.asset import EndpointAnswer
from schemas.diagnostics import Diagnostic
from schemas.outcome import EndpointUse

UNKNOWN = "unknown"
# A category is said from this chance on, when no other comes near it.
STANDS = 0.5
RIVAL = 0.75


@dataclass(frozen=True)
class Shape:
    """What the geometry says about the kind of thing, whatever way it lies.

    extents_m  edges of the smallest bounding box, shortest first.
    fill       share of that box that the convex hull takes: box 1, cylinder 0.79, ball 0.52; None without volume.
    hollow     share of the convex hull that is no material; None where nobody knows (a hull stands in).
    metric     whether the edges are known in metres; else only their proportions are.
    """

    extents_m: tuple[float, float, float]
    fill: float | None
    hollow: float | None
    metric: bool = True


@dataclass(frozen=True)
class Observation:
    """All evidence about one object.

    file       stem of the source file.             folders  names of the folders it stands in, nearest first.
    nodes      names of nodes and meshes.           materials  names of render materials.
    titles     what the file calls itself.         shared     whether the file holds other objects as well.
    views      PNG pictures by name, in the order to be shown; only for an annotator that looks at them.
    """

    file: str
    folders: tuple[str, ...]
    nodes: tuple[str, ...]
    materials: tuple[str, ...]
    titles: tuple[str, ...]
    shape: Shape
    shared: bool = False
    views: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class Hypothesis:
    """One category with the chance that it is right, and the clues for and against it in words."""

    category: str
    score: float
    clues: tuple[str, ...]


@dataclass(frozen=True)
class Asked:
    """How a question to an endpoint went: its answer, or None and a finding that says why there is none."""

    answer: EndpointAnswer | None
    use: EndpointUse
    findings: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class Annotation:
    """Ranked hypotheses, best first; `category` is `unknown` unless the first one stands; `reason` says why.

    method          by which the first hypothesis was found.
    contradictions  where names or pictures speak of a category that shape or each other contradict, in words.
    disputed        whether pictures are contradicted, so that a person must decide.
    asked           None when no endpoint was asked.
    """

    category: str
    hypotheses: tuple[Hypothesis, ...]
    reason: str
    method: str
    contradictions: tuple[str, ...] = ()
    disputed: bool = False
    asked: Asked | None = None

    @property
    def score(self) -> float:
        """Of the category, 0 while it is unknown."""
        return 0.0 if self.category == UNKNOWN else self.hypotheses[0].score


class Annotator(Protocol):
    """Anything that tells what an object is: the embedded one needs names, a multimodal one pictures."""

    def annotate(self, observation: Observation) -> Annotation:
        """The annotation; deterministic, never raises for what the evidence holds or an endpoint answers."""
        ...


def decided(hypotheses: Sequence[Hypothesis], method: str, contradictions: tuple[str, ...] = ()) -> Annotation:
    """The annotation of these hypotheses: ranked, and the first one stands when it is likely and has no rival.

    `method` and `contradictions` become those of the annotation.
    """
    ranked = tuple(sorted(hypotheses, key=lambda h: (-h.score, h.category)))
    best, others = ranked[0], ranked[1:]
    if others and others[0].score >= RIVAL * best.score:
        return Annotation(UNKNOWN, ranked, f"{best.category} or {others[0].category}", method, contradictions)
    if best.score <= STANDS:
        reason = f"perhaps {best.category}, on thin evidence"
        return Annotation(UNKNOWN, ranked, reason, method, contradictions)
    return Annotation(best.category, ranked, "; ".join(best.clues), method, contradictions)
