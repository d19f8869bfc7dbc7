"""From proposals to parts: one of each, none that cross, each with its label, parent and order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from assetkit.parts.labels import Vote, votes
from assetkit.parts.proposals import LEAST_SHARE, Proposal
from geom.features.regions import Faces
from schemas.model import FloatArray, IntArray
from schemas.parts import UNLABELLED, ProposalSource

SAME = 0.75  # intersection over union of the surface from which two regions are one
WITHIN = 0.9  # of the smaller one inside the other: it is a part of it; less, and they cross
MOST_PARTS = 64
_STRENGTH = {"learned": 0.5, "hierarchy": 0.4, "shape": 0.35, "material": 0.3, "component": 0.2}
# What stands lower in the things that have both.
_OVER = {("lid", "body"), ("knob", "body"), ("seat", "leg"), ("top", "leg"), ("back", "leg"), ("cap", "base")}
# Categories in which the rest of the object is its body once something was taken off it.
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
class Piece:
    """A region that proposals agree on. `area` of its surface, `votes` for labels; labels that it `may_be` in `doubt`,
    which says what contradicts them.
    """

    faces: IntArray
    area: float
    sources: tuple[ProposalSource, ...]
    names: tuple[str, ...]
    path: str
    votes: tuple[Vote, ...]
    may_be: tuple[str, ...] = ()
    doubt: str = ""

    @property
    def label(self) -> str:
        """What all votes say; `unlabelled` when there is none or they differ."""
        said = {v.label for v in self.votes}
        return said.pop() if len(said) == 1 else UNLABELLED

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

    pieces: tuple[Piece, ...]
    parents: tuple[int, ...]


def reconcile(surface: Faces, proposals: Sequence[Proposal], category: str, vocabulary: Sequence[str]) -> Reconciled:
    """The parts of an object. `category` is "" and `vocabulary` empty while nobody knows what it is."""
    pieces = [_piece(surface, p, votes(p, category, vocabulary)) for p in proposals]
    pieces = _without_shared_name(pieces)
    kept: list[Piece] = []
    for piece in sorted(pieces, key=lambda p: (-_standing(p), -p.area, int(np.argmax(p.faces)))):
        kept = _suppressed(surface, kept, piece)
    kept = _with_body(surface, _merged(surface, kept[:MOST_PARTS]), category)
    kept = _in_order(surface, kept)
    kept.sort(key=lambda p: (-round(p.area / surface.area.sum(), 6), int(np.argmax(p.faces))))
    return Reconciled(tuple(kept), tuple(_parent(surface, kept, p) for p in kept))


def _piece(surface: Faces, proposal: Proposal, said: tuple[Vote, ...]) -> Piece:
    area = float(surface.area[proposal.faces].sum())
    return Piece(proposal.faces, area, (proposal.source,), proposal.names, proposal.path, said)


def _standing(piece: Piece) -> float:
    """The order in which pieces are taken: those with a name first, then by who proposed them."""
    return piece.confidence + max(_STRENGTH[s] for s in piece.sources)


def _without_shared_name(pieces: Sequence[Piece]) -> list[Piece]:
    """A label that every node (or every material) bears is the name of the object, not of its parts."""
    result = list(pieces)
    for source in ("hierarchy", "material"):
        own = [i for i, p in enumerate(result) if p.sources == (source,)]
        labels = {result[i].label for i in own}
        if len(own) > 1 and len(labels) == 1 and UNLABELLED not in labels:
            for i in own:
                result[i] = replace(result[i], votes=())
    return result


def _suppressed(surface: Faces, kept: list[Piece], piece: Piece) -> list[Piece]:
    """`kept` with `piece`: merged into the same region, left out when it crosses one, else added."""
    for index, other in enumerate(kept):
        both = float(surface.area[piece.faces & other.faces].sum())
        if both >= SAME * (piece.area + other.area - both):
            merged = replace(
                other,
                sources=tuple(dict.fromkeys((*other.sources, *piece.sources))),
                names=tuple(dict.fromkeys((*other.names, *piece.names))),
                path=other.path or piece.path,
                votes=(*other.votes, *piece.votes),
            )
            return [*kept[:index], merged, *kept[index + 1 :]]
        if (1.0 - WITHIN) * min(piece.area, other.area) < both < WITHIN * min(piece.area, other.area):
            return kept
    return [*kept, piece]


def _merged(surface: Faces, pieces: Sequence[Piece]) -> list[Piece]:
    """Pieces of one label whose boxes are mostly the same, such as inside and outside of a body, as one."""
    result: list[Piece] = []
    for piece in pieces:
        twin = next((p for p in result if p.label == piece.label != UNLABELLED and _alike(surface, p, piece)), None)
        if twin is None:
            result.append(piece)
            continue
        faces = twin.faces | piece.faces
        votes = (*twin.votes, *piece.votes)
        names = tuple(dict.fromkeys((*twin.names, *piece.names)))
        sources = tuple(dict.fromkeys((*twin.sources, *piece.sources)))
        merged = Piece(faces, float(surface.area[faces].sum()), sources, names, "", votes)
        result[[p is twin for p in result].index(True)] = merged
    return result


def _alike(surface: Faces, one: Piece, two: Piece) -> bool:
    (low, high), (low_2, high_2) = surface.box(one.faces), surface.box(two.faces)
    slack = 1e-3 * float(surface.extent.max())
    shared = float(np.prod(np.maximum(np.minimum(high, high_2) - np.maximum(low, low_2), 0.0) + slack))
    return shared > 0.5 * float(max(np.prod(high - low + slack), np.prod(high_2 - low_2 + slack)))


def _with_body(surface: Faces, pieces: list[Piece], category: str) -> list[Piece]:
    """What is left of a vessel or block without the parts that were told by shape is its body."""
    off = [p for p in pieces if p.label not in (UNLABELLED, "body") and any(v.kind == "shape" for v in p.votes)]
    if category not in _HAVE_BODY or not off or any(p.label == "body" for p in pieces):
        return pieces
    rest = ~np.any([p.faces for p in pieces if p.label != UNLABELLED], axis=0)
    area = float(surface.area[rest].sum())
    if area <= LEAST_SHARE * surface.area.sum():
        return pieces
    sure = min(p.confidence for p in off)
    body = Piece(rest, area, ("shape",), (), "", (Vote("body", sure, "shape", "shape: rest of the object"),))
    return _suppressed(surface, [p for p in pieces if p.label != UNLABELLED], body) + [
        p for p in pieces if p.label == UNLABELLED and not _crosses(surface, p, body)
    ]


def _crosses(surface: Faces, piece: Piece, other: Piece) -> bool:
    both = float(surface.area[piece.faces & other.faces].sum())
    return both > (1.0 - WITHIN) * min(piece.area, other.area)


def _in_order(surface: Faces, pieces: list[Piece]) -> list[Piece]:
    """Labels that stand the wrong way round in height are taken back; so are those that clues dispute."""
    made = [_disputed(p) for p in pieces]
    height = [_middle(surface, p)[2] for p in pieces]
    for upper, lower in sorted(_OVER):
        above = [i for i, p in enumerate(pieces) if p.label == upper]
        below = [i for i, p in enumerate(pieces) if p.label == lower]
        if above and below and max(height[i] for i in above) < min(height[i] for i in below):
            for i in (*above, *below):
                made[i] = replace(made[i], votes=(), may_be=(pieces[i].label,), doubt=f"{upper} lies under {lower}")
    return made


def _disputed(piece: Piece) -> Piece:
    """A piece that knows which labels its clues speak for, where these differ."""
    said = tuple(sorted({v.label for v in piece.votes}))
    if len(said) < 2:
        return piece
    return replace(piece, may_be=said, doubt="; ".join(v.clue for v in piece.votes))


def _parent(surface: Faces, pieces: Sequence[Piece], piece: Piece) -> int:
    """The smallest larger piece whose surface holds this one."""
    holds = [
        (p.area, i)
        for i, p in enumerate(pieces)
        if p.area > piece.area and surface.area[p.faces & piece.faces].sum() >= WITHIN * piece.area
    ]
    return min(holds)[1] if holds else -1


def _middle(surface: Faces, piece: Piece) -> FloatArray:
    return np.average(surface.middle[piece.faces], axis=0, weights=surface.area[piece.faces])
