"""What earlier compiles found, by content: an edit re-solves the component it touches and no other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from hashlib import blake2b

import numpy as np
from shapely import Polygon

from scenec.ir import Body, Placement, RelationIR, Surface, Thing, Volume
from scenec.solve.model import Model

Digest = bytes


@dataclass
class ComponentCache:
    """Placements of components by digest of all that decides them, and digests of bodies and places already seen."""

    solved: dict[Digest, dict[str, Placement]] = field(default_factory=dict)
    right: dict[Digest, frozenset[tuple[str, Digest, Placement]]] = field(default_factory=dict)
    _known: dict[int, tuple[object, Digest]] = field(default_factory=dict)

    def digest(self, item: Body | Surface | Volume) -> Digest:
        """Content of a body or place; the same object is read once."""
        known = self._known.get(id(item))
        if known is None or known[0] is not item:
            known = self._known[id(item)] = (item, _digest(item))
        return known[1]

    def thing(self, thing: Thing) -> Digest:
        """Content of a thing: its body, place and domain, not what it carries."""
        domain = thing.domain
        spots = [(s.x_m, s.y_m, s.z_m, s.yaw_rad) for s in domain.spots]
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


def component_digest(
    cache: ComponentCache, model: Model, names: Sequence[str], seed: int
) -> tuple[Digest, dict[str, Digest]]:
    """(digest of all that decides a component, digests by thing with what it carries)."""
    things = {name: _loaded(cache, model, name) for name in names}
    rules = [_rule(rule) for rule in model.rules if any(name in things for name in rule.things)]
    limits = repr([model.limits.get(name, ()) for name in names]).encode()
    return _hash(
        context(model), repr(seed).encode(), *(n.encode() + d for n, d in things.items()), *rules, limits
    ), things


def context(model: Model) -> Digest:
    """What concerns every thing: clearance, keep-outs, reach, where the background stands."""
    problem = model.problem
    keep_outs = [repr((k.parent, k.place, k.height_m)).encode() + _polygon(k.polygon) for k in problem.keep_outs]
    reach = problem.reach
    ring = b"" if reach is None else _array(reach.base_m) + repr((reach.least_m, reach.most_m, reach.members)).encode()
    return _hash(repr(problem.clearance_m).encode(), _array(problem.X_WB), ring, *keep_outs)


def _loaded(cache: ComponentCache, model: Model, name: str) -> Digest:
    own = cache.thing(model.things[name])
    if name not in model.carriers:
        return own
    heights = repr([(shape.height_m, len(shape.slabs)) for shape in model.shapes[name]]).encode()
    return _hash(own, heights, *(_array(p) for shape in model.shapes[name] for p in shape.pieces))


def _rule(rule: RelationIR) -> bytes:
    return repr((rule.kind, rule.things, rule.direction, rule.gap_m, rule.tolerance, rule.frame)).encode()
