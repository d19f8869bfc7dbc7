"""Merges proposals into parts: one per region, none that overlap in part, each with label, parent and order by area."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from assetkit.parts.labels import Vote, votes
from assetkit.parts.proposals import LEAST_SHARE, Proposal
from geom.features.regions import FaceGeometry
from schemas.arrays import BoolArray, FloatArray
from schemas.parts import UNLABELLED, ProposalSource

MIN_IOU = 0.75  # intersection over union of the surface from which two regions are one
CONTAINED_SHARE = 0.9  # of the smaller one inside the other: it is a part of it; less, and they cross
MOST_PARTS = 64
_STRENGTH = {"learned": 0.5, "hierarchy": 0.4, "shape": 0.35, "material": 0.3, "component": 0.2}
# (upper, lower): the first label is above the second in things that have both.
_ABOVE = {("lid", "body"), ("knob", "body"), ("seat", "leg"), ("top", "leg"), ("back", "leg"), ("cap", "base")}
# Categories in which the rest of the object is its body once a part was labelled.
_HAVE_BODY = (
    "mug",
    "cup",
    "pan",
    "pot",
    "pitcher",
    "teapot",
    "bottle",
    "pill_bottle",
    "vase",
    "basket",
    "bin",
    "block",
)


@dataclass(frozen=True)
class PartCandidate:
    """A region that proposals agree on, with its `area` (m2) and `votes` for labels. Where clues contradict each other,
    `may_be` holds the possible labels and `doubt` the reason.
    """

    faces: BoolArray
    area: float
    sources: tuple[ProposalSource, ...]
    names: tuple[str, ...]
    path: str
    votes: tuple[Vote, ...]
    may_be: tuple[str, ...] = ()
    doubt: str = ""

    @property
    def label(self) -> str:
        """The label of all votes; `unlabelled` when there is none or they differ."""
        labels = {v.label for v in self.votes}
        return labels.pop() if len(labels) == 1 else UNLABELLED

    @property
    def confidence(self) -> float:
        """Of the label: clues of different kinds are independent witnesses, those of one kind are not."""
        if self.label == UNLABELLED:
            return 0.0
        kinds: dict[str, float] = {}
        for v in self.votes:
            kinds[v.kind] = max(kinds.get(v.kind, 0.0), v.confidence)
        return 1.0 - float(np.prod([1.0 - c for c in kinds.values()]))


@dataclass(frozen=True)
class Reconciled:
    """Pieces by falling area, and the index of the one that holds each (-1: none)."""

    pieces: tuple[PartCandidate, ...]
    parents: tuple[int, ...]


def reconcile(
    surface: FaceGeometry, proposals: Sequence[Proposal], category: str, vocabulary: Sequence[str]
) -> Reconciled:
    """The parts of an object. `category` is "" and `vocabulary` empty while the category is unknown."""
    pieces = [_piece(surface, p, votes(p, category, vocabulary)) for p in proposals]
    pieces = _without_shared_name(pieces)
    selected: list[PartCandidate] = []
    for piece in sorted(pieces, key=lambda p: (-_priority(p), -p.area, int(np.argmax(p.faces)))):
        selected = _non_maximum_suppression(surface, selected, piece)
    selected = _with_body(surface, _merged(surface, selected[:MOST_PARTS]), category)
    selected = _in_order(surface, selected, vocabulary)
    selected.sort(key=lambda p: (-round(p.area / surface.area.sum(), 6), int(np.argmax(p.faces))))
    return Reconciled(tuple(selected), tuple(_parent(surface, selected, p) for p in selected))


def _piece(surface: FaceGeometry, proposal: Proposal, label_votes: tuple[Vote, ...]) -> PartCandidate:
    area = float(surface.area[proposal.faces].sum())
    return PartCandidate(proposal.faces, area, (proposal.source,), proposal.names, proposal.path, label_votes)


def _priority(piece: PartCandidate) -> float:
    """The order in which pieces are taken: those with a name first, then by who proposed them."""
    return piece.confidence + max(_STRENGTH[s] for s in piece.sources)


def _without_shared_name(pieces: Sequence[PartCandidate]) -> list[PartCandidate]:
    """A label that every node (or every material) bears is the name of the object, not of its parts."""
    result = list(pieces)
    for source in ("hierarchy", "material"):
        members = [i for i, p in enumerate(result) if p.sources == (source,)]
        labels = {result[i].label for i in members}
        if len(members) > 1 and len(labels) == 1 and UNLABELLED not in labels:
            for i in members:
                result[i] = replace(result[i], votes=())
    return result


def _non_maximum_suppression(
    surface: FaceGeometry, selected: list[PartCandidate], piece: PartCandidate
) -> list[PartCandidate]:
    """`kept` with `piece`: merged into the same region, left out when it crosses one, else added."""
    for index, other in enumerate(selected):
        both = float(surface.area[piece.faces & other.faces].sum())
        if both >= MIN_IOU * (piece.area + other.area - both):
            merged = replace(
                other,
                sources=tuple(dict.fromkeys((*other.sources, *piece.sources))),
                names=tuple(dict.fromkeys((*other.names, *piece.names))),
                path=other.path or piece.path,
                votes=(*other.votes, *piece.votes),
            )
            return [*selected[:index], merged, *selected[index + 1 :]]
        if (1.0 - CONTAINED_SHARE) * min(piece.area, other.area) < both < CONTAINED_SHARE * min(piece.area, other.area):
            return selected
    return [*selected, piece]


def _merged(surface: FaceGeometry, pieces: Sequence[PartCandidate]) -> list[PartCandidate]:
    """Pieces of one label whose boxes are mostly the same, such as inside and outside of a body, as one."""
    result: list[PartCandidate] = []
    for piece in pieces:
        twin = next((p for p in result if p.label == piece.label != UNLABELLED and _same_box(surface, p, piece)), None)
        if twin is None:
            result.append(piece)
            continue
        faces = twin.faces | piece.faces
        votes = (*twin.votes, *piece.votes)
        names = tuple(dict.fromkeys((*twin.names, *piece.names)))
        sources = tuple(dict.fromkeys((*twin.sources, *piece.sources)))
        merged = PartCandidate(faces, float(surface.area[faces].sum()), sources, names, "", votes)
        result[[p is twin for p in result].index(True)] = merged
    return result


def _same_box(surface: FaceGeometry, first: PartCandidate, second: PartCandidate) -> bool:
    (low, high), (low_2, high_2) = surface.box(first.faces), surface.box(second.faces)
    slack = 1e-3 * float(surface.extent.max())
    shared = float(np.prod(np.maximum(np.minimum(high, high_2) - np.maximum(low, low_2), 0.0) + slack))
    return shared > 0.5 * float(max(np.prod(high - low + slack), np.prod(high_2 - low_2 + slack)))


def _with_body(surface: FaceGeometry, pieces: list[PartCandidate], category: str) -> list[PartCandidate]:
    """Pieces with the body: what remains of a vessel or block without the parts that were labelled by shape."""
    off = [p for p in pieces if p.label not in (UNLABELLED, "body") and any(v.kind == "shape" for v in p.votes)]
    if category not in _HAVE_BODY or not off or any(p.label == "body" for p in pieces):
        return pieces
    rest = ~np.any([p.faces for p in pieces if p.label != UNLABELLED], axis=0)
    area = float(surface.area[rest].sum())
    if area <= LEAST_SHARE * surface.area.sum():
        return pieces
    sure = min(p.confidence for p in off)
    body = PartCandidate(rest, area, ("shape",), (), "", (Vote("body", sure, "shape", "shape: rest of the object"),))
    return _non_maximum_suppression(surface, [p for p in pieces if p.label != UNLABELLED], body) + [
        p for p in pieces if p.label == UNLABELLED and not _crosses(surface, p, body)
    ]


def _crosses(surface: FaceGeometry, piece: PartCandidate, other: PartCandidate) -> bool:
    both = float(surface.area[piece.faces & other.faces].sum())
    return both > (1.0 - CONTAINED_SHARE) * min(piece.area, other.area)


def _in_order(surface: FaceGeometry, pieces: list[PartCandidate], vocabulary: Sequence[str]) -> list[PartCandidate]:
    """Pieces without the labels whose order in height is wrong, and without those that clues dispute.

    A knob is on top of what has a lid; of other things, such as an oven, it may be on any side.
    """
    ordered = [_disputed(p) for p in pieces]
    height = [_middle(surface, p)[2] for p in pieces]
    for upper, lower in sorted(_ABOVE if "lid" in vocabulary else _ABOVE - {("knob", "body")}):
        above = [i for i, p in enumerate(pieces) if p.label == upper]
        below = [i for i, p in enumerate(pieces) if p.label == lower]
        if above and below and max(height[i] for i in above) < min(height[i] for i in below):
            for i in (*above, *below):
                ordered[i] = replace(
                    ordered[i], votes=(), may_be=(pieces[i].label,), doubt=f"{upper} lies under {lower}"
                )
    return ordered


def _disputed(piece: PartCandidate) -> PartCandidate:
    """The piece with the labels that its clues support, where these differ."""
    labels = tuple(sorted({v.label for v in piece.votes}))
    if len(labels) < 2:
        return piece
    return replace(piece, may_be=labels, doubt="; ".join(v.clue for v in piece.votes))


def _parent(surface: FaceGeometry, pieces: Sequence[PartCandidate], piece: PartCandidate) -> int:
    """The smallest larger piece whose surface holds this one."""
    holds = [
        (p.area, i)
        for i, p in enumerate(pieces)
        if p.area > piece.area and surface.area[p.faces & piece.faces].sum() >= CONTAINED_SHARE * piece.area
    ]
    return min(holds)[1] if holds else -1


def _middle(surface: FaceGeometry, piece: PartCandidate) -> FloatArray:
    return np.average(surface.middle[piece.faces], axis=0, weights=surface.area[piece.faces])
