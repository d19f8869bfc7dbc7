"""What earlier compiles found, by content: an edit re-solves the component it touches and no other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import blake2b

import numpy as np
from shapely import Polygon

from scenec.ir.problem import Body, Placement, RelationIR, Surface, Thing, Volume
from scenec.solve.model import Model

Digest = bytes
KEPT = 8  # sets of things known to stand right, for each surroundings


@dataclass(frozen=True)
class Record:
    """Content of a component: `digest` of all that decides it, `surroundings` of what is not a thing (clearance,
    keep-outs, reach), digests of its things with what they carry, and of the rules that each takes part in."""

    digest: Digest
    surroundings: Digest
    things: dict[str, Digest]


@dataclass
class ComponentCache:
    """Placements of components by digest of all that decides them, and digests of bodies and places already seen.

    `right` holds sets of things found valid together, as (name, content, placement): what an edit leaves as it was
    need not be validated against each other again.
    """

    solved: dict[Digest, dict[str, Placement]] = field(default_factory=dict)
    right: dict[Digest, list[dict[str, tuple[Digest, Placement]]]] = field(default_factory=dict)
    _known: dict[int, tuple[object, Digest]] = field(default_factory=dict)

    def digest(self, item: Body | Surface | Volume | Thing) -> Digest:
        """Content of a body, place or thing (without what it carries); the same object is read once."""
        known = self._known.get(id(item))
        if known is None or known[0] is not item:
            known = self._known[id(item)] = (item, self._thing(item) if isinstance(item, Thing) else _digest(item))
        return known[1]

    def record(self, model: Model, names: Sequence[str], seed: int) -> Record:
        """The content of a component as it is now."""
        surroundings = _surroundings(model)
        things = {name: self._loaded(model, name) for name in names}
        return Record(_hash(surroundings, repr((seed, names)).encode(), *things.values()), surroundings, things)

    def keep(self, record: Record, placements: dict[str, Placement]) -> None:
        """Remembers what was found for a component."""
        self.solved[record.digest] = placements
        sets = self.right.setdefault(record.surroundings, [])
        sets.append({name: (content, placements[name]) for name, content in record.things.items()})
        del sets[:-KEPT]

    def suspects(self, record: Record, previous: Mapping[str, Placement]) -> set[str] | None:
        """Things of `previous` not known to stand right with the others; None where nothing is known of any."""
        now = {name: (content, previous.get(name)) for name, content in record.things.items()}
        known = [
            {name for name, state in now.items() if found.get(name) == state}
            for found in self.right.get(record.surroundings, [])
        ]
        best = max(known, key=len, default=set[str]())
        return set(now) - best if best else None

    def _loaded(self, model: Model, name: str) -> Digest:
        own, rules = self.digest(model.things[name]), [_rule(rule) for rule in model.rules_of.get(name, ())]
        if rules or name in model.limits:
            own = _hash(own, repr(model.limits.get(name, ())).encode(), *rules)
        if name not in model.carriers:
            return own
        pieces = [
            _array(p) for shape in model.shapes[name] for p in (*shape.pieces, *(s.outline_m for s in shape.slabs))
        ]
        heights = repr([[(s.low_m, s.high_m) for s in shape.slabs] for shape in model.shapes[name]]).encode()
        return _hash(own, heights, *pieces)

    def _thing(self, thing: Thing) -> Digest:
        domain = thing.domain
        spots = [(s.x_m, s.y_m, s.z_m, s.yaw_rad, s.stance) for s in domain.spots]
        text = repr((thing.parent, domain.x_m, domain.y_m, domain.yaw_rad, domain.stances, spots))
        return _hash(self.digest(thing.body), self.digest(thing.place), text.encode())


def _hash(*parts: bytes) -> Digest:
    state = blake2b(digest_size=16)
    for part in parts:
        state.update(len(part).to_bytes(8, "little"))
        state.update(part)
    return state.digest()


def _digest(item: Body | Surface | Volume) -> Digest:
    if isinstance(item, Body):
        return _hash(
            *(
                part
                for stance in item.stances
                for part in (
                    repr((stance.quat_wxyz, stance.origin_height_m)).encode(),
                    *(_array(s.outline_m) + repr((s.low_m, s.high_m)).encode() for s in stance.slabs),
                )
            )
        )
    if isinstance(item, Surface):
        above = [_array(s.outline_m) + repr((s.low_m, s.high_m)).encode() for s in item.above]
        name = repr((item.name, item.clearance_m)).encode()
        return _hash(name, _polygon(item.polygon), _array(item.origin_P_m), *above)
    layers = [repr((low, high)).encode() + _polygon(polygon) for low, high, polygon in item.layers]
    return _hash(item.name.encode(), _array(item.origin_P_m), *layers)


def _array(values: np.ndarray) -> bytes:
    return np.ascontiguousarray(values, dtype=float).tobytes()


def _polygon(polygon: Polygon) -> bytes:
    return polygon.wkb


def _surroundings(model: Model) -> Digest:
    """What concerns every thing: clearance, keep-outs, reach, where the background stands."""
    problem = model.problem
    keep_outs = [
        repr((k.parent, k.place.name, tuple(k.place.origin_P_m), k.height_m)).encode() + _polygon(k.polygon)
        for k in problem.keep_outs
    ]
    reach = problem.reach
    ring = b"" if reach is None else _array(reach.base_m) + repr((reach.least_m, reach.most_m, reach.members)).encode()
    return _hash(repr(problem.clearance_m).encode(), _array(problem.X_WB), ring, *keep_outs)


def _rule(rule: RelationIR) -> bytes:
    return repr((rule.kind, rule.things, rule.direction, rule.gap_m, rule.tolerance, rule.frame)).encode()
