"""The interface between evidence and meaning: what an annotator is shown and what it answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

UNKNOWN = "unknown"


@dataclass(frozen=True)
class Shape:
    """What the geometry says about the kind of thing, whatever way it lies.

    extents_m  edges of the smallest bounding box, shortest first.
    fill       share of that box that the convex hull takes: box 1, cylinder 0.79, ball 0.52; None without volume.
    hollow     share of the convex hull that is no material; None where nobody knows (a hull stands in).
    """

    extents_m: tuple[float, float, float]
    fill: float | None
    hollow: float | None


@dataclass(frozen=True)
class Observation:
    """All evidence about one object.

    file       stem of the source file.             folders  names of the folders it stands in, nearest first.
    nodes      names of nodes and meshes.           materials  names of render materials.
    titles     what the file calls itself.         shared     whether the file holds other objects as well.
    """

    file: str
    folders: tuple[str, ...]
    nodes: tuple[str, ...]
    materials: tuple[str, ...]
    titles: tuple[str, ...]
    shape: Shape
    shared: bool = False


@dataclass(frozen=True)
class Hypothesis:
    """One category with the chance that it is right, and the clues for and against it in words."""

    category: str
    score: float
    clues: tuple[str, ...]


@dataclass(frozen=True)
class Annotation:
    """Ranked hypotheses, best first; `category` is `unknown` unless the first one stands; `reason` says why.

    contradictions  where names speak of a category that shape or other names contradict, in words.
    """

    category: str
    hypotheses: tuple[Hypothesis, ...]
    reason: str
    contradictions: tuple[str, ...] = ()

    @property
    def score(self) -> float:
        """Of the category, 0 while it is unknown."""
        return 0.0 if self.category == UNKNOWN else self.hypotheses[0].score


class Annotator(Protocol):
    """Anything that tells what an object is: the embedded one needs names, a multimodal one pictures."""

    method: str

    def annotate(self, observation: Observation) -> Annotation:
        """The annotation; deterministic, never raises for what the evidence holds."""
        ...
