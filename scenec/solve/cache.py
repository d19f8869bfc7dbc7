"""Cache of solved components by content digest: an edit solves only the components that it changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import blake2b

import numpy as np
from shapely import Polygon

from scenec.ir.problem import Body, Placement, Thing
from scenec.solve.model import SolverModel
from schemas.scene.geometry import ScenePlace, SceneRelation

Digest = bytes
MOST_VALIDATED_SETS = 8  # sets of things known to be valid together, for each surroundings


@dataclass(frozen=True)
class ComponentDigest:
    """Content of a component: `digest` of all its inputs, `surroundings` of those that are no things (clearance,
    keep-outs, reach), and digests of its things with their load and relations."""

    digest: Digest
    surroundings: Digest
    things: dict[str, Digest]


@dataclass
class ComponentCache:
    """Placements of components by digest of their inputs, and digests of known bodies and places.

    `validated` holds sets of things that were valid together, as {name: (content, placement)}: unchanged things need
    not be validated against each other again.
    """

    solved: dict[Digest, dict[str, Placement]] = field(default_factory=dict)
    validated: dict[Digest, list[dict[str, tuple[Digest, Placement]]]] = field(default_factory=dict)
    _known: dict[int, tuple[object, Digest]] = field(default_factory=dict)

    def digest(self, item: Body | ScenePlace | Thing) -> Digest:
        """Content digest of a body, place or thing (without its load), computed once per object."""
        known = self._known.get(id(item))
        if known is None or known[0] is not item:
            known = self._known[id(item)] = (item, self._thing(item) if isinstance(item, Thing) else _digest(item))
        return known[1]

    def component_digest(self, model: SolverModel, names: Sequence[str], seed: int) -> ComponentDigest:
        """The content of a component in its current state."""
        surroundings = _surroundings(model)
        things = {name: self._digest_with_load(model, name) for name in names}
        return ComponentDigest(
            _hash(surroundings, repr((seed, names)).encode(), *things.values()), surroundings, things
        )

    def store(self, component_digest: ComponentDigest, placements: dict[str, Placement]) -> None:
        """Stores the placements found for a component."""
        self.solved[component_digest.digest] = placements
        sets = self.validated.setdefault(component_digest.surroundings, [])
        sets.append({name: (content, placements[name]) for name, content in component_digest.things.items()})
        del sets[:-MOST_VALIDATED_SETS]

    def suspects(self, component_digest: ComponentDigest, previous: Mapping[str, Placement]) -> set[str] | None:
        """Things of `previous` not known to be valid with the others; None where nothing is known."""
        now = {name: (content, previous.get(name)) for name, content in component_digest.things.items()}
        known = [
            {name for name, state in now.items() if validated_set.get(name) == state}
            for validated_set in self.validated.get(component_digest.surroundings, [])
        ]
        best = max(known, key=len, default=set[str]())
        return set(now) - best if best else None

    def _digest_with_load(self, model: SolverModel, name: str) -> Digest:
        digest, rules = self.digest(model.things[name]), [_rule(rule) for rule in model.rules_of.get(name, ())]
        if rules or name in model.limits:
            digest = _hash(digest, repr(model.limits.get(name, ())).encode(), *rules)
        if name not in model.carriers:
            return digest
        pieces = [
            _array(p) for shape in model.shapes[name] for p in (*shape.pieces, *(s.outline_m for s in shape.prisms))
        ]
        heights = repr([[(s.low_m, s.high_m) for s in shape.prisms] for shape in model.shapes[name]]).encode()
        return _hash(digest, heights, *pieces)

    def _thing(self, thing: Thing) -> Digest:
        domain = thing.domain
        fixed_poses = [(s.x_m, s.y_m, s.z_m, s.yaw_rad, s.stance) for s in domain.fixed_poses]
        text = repr((thing.parent, domain.x_m, domain.y_m, domain.yaw_rad, domain.orientation_indices, fixed_poses))
        return _hash(self.digest(thing.body), self.digest(thing.place), text.encode())


def _hash(*parts: bytes) -> Digest:
    state = blake2b(digest_size=16)
    for part in parts:
        state.update(len(part).to_bytes(8, "little"))
        state.update(part)
    return state.digest()


def _digest(item: Body | ScenePlace) -> Digest:
    if isinstance(item, Body):
        return _hash(
            *(
                part
                for stance in item.resting_orientations
                for part in (
                    repr((stance.quat_wxyz, stance.origin_height_m)).encode(),
                    *(_array(s.outline_m) + repr((s.low_m, s.high_m)).encode() for s in stance.prisms),
                )
            )
        )
    above = [_array(s.outline_m) + repr((s.low_m, s.high_m)).encode() for s in item.above]
    layers = [repr((low, high)).encode() + _polygon(polygon) for low, high, polygon in item.layers]
    name = repr((item.name, item.kind, item.height_m, len(above), item.link)).encode()
    return _hash(name, _polygon(item.polygon), _array(item.origin_P_m), *above, *layers)


def _array(values: np.ndarray) -> bytes:
    return np.ascontiguousarray(values, dtype=float).tobytes()


def _polygon(polygon: Polygon) -> bytes:
    return polygon.wkb


def _surroundings(model: SolverModel) -> Digest:
    """Digest of the inputs common to all things: clearance, keep-outs, reach, pose of the background."""
    problem = model.problem
    keep_outs = [
        repr((k.parent, k.place.name, tuple(k.place.origin_P_m), k.height_m)).encode() + _polygon(k.polygon)
        for k in problem.keep_outs
    ]
    reach = problem.reach
    ring = b"" if reach is None else _array(reach.base_m) + repr((reach.least_m, reach.most_m, reach.members)).encode()
    spaces = [
        repr((space.owner, space.joint, space.links)).encode()
        + b"".join(repr((low, high)).encode() + _polygon(area) for low, high, area in space.layers)
        for space in problem.keep_clear
    ]
    return _hash(repr(problem.clearance_m).encode(), _array(problem.X_WB), ring, *keep_outs, *spaces)


def _rule(rule: SceneRelation) -> bytes:
    numbers = (rule.direction, rule.gap_m, rule.tolerance, rule.angle_rad)
    return repr((rule.kind, rule.things, rule.frame, numbers)).encode()
