"""A program bound to geometry, part by part: things that share nothing have combinations and verdicts of their own."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice

from scenec.bind.asset_library import AssetLibrary
from scenec.bind.bind_combination import Lowering
from scenec.bind.check_assets import check_assets
from scenec.bind.independent_components import islands
from scenec.bind.variants import MAX_COMBINATIONS, Combination, Variety
from scenec.ir.derivation_cache import Memo
from scenec.ir.names import Names
from scenec.ir.problem import Problem
from scenec.source.tree import Spans
from schemas.diagnostics import Diagnostic, InvalidInput, any_error, finding
from schemas.scene.program import SceneProgram

MAX_PROBES = 64  # lowerings to learn what may meet; beyond that all is one part


@dataclass(frozen=True)
class Part:
    """Things and the combinations of only those keys that reach them, each as a problem of these things alone.

    `union` are objects that have all their candidates at once, because single ones would be too many.
    """

    things: tuple[str, ...]
    nodes: frozenset[str]
    keys: frozenset[str]
    union: tuple[str, ...]
    combinations: tuple[Combination, ...]
    problems: tuple[Problem, ...]

    @cached_property
    def _index(self) -> dict[frozenset[tuple[str, str]], int]:
        return {frozenset(one.items()): k for k, one in enumerate(self.combinations)}

    def index(self, whole: Mapping[str, str]) -> int:
        """The number of its combination within a combination of all keys."""
        return self._index[frozenset((key, value) for key, value in whole.items() if key in self.keys)]


class Binder:
    """Makes problems of combinations; findings gather in `found`."""

    def __init__(self, names: Names, variety: Variety, library: AssetLibrary, spans: Spans, memo: Memo) -> None:
        self.names, self.variety, self.library, self.spans, self.memo = names, variety, library, spans, memo
        self.found: list[Diagnostic] = []

    def problem(self, combination: Combination, nodes: Collection[str] | None = None) -> Problem:
        """The problem of a combination, of some nodes alone or of all. A key left out has its first value."""
        choice = self.variety.choice(combination)
        lowering = Lowering(self.names, choice, self.library, self.spans, self.memo, nodes)
        made = lowering.problem()
        self.found += [diagnostic for diagnostic in lowering.found if diagnostic not in self.found]
        return made


@dataclass(frozen=True)
class Lowered:
    """The parts of a program, none when a diagnostic is an error; together they have every thing once."""

    parts: tuple[Part, ...]
    diagnostics: tuple[Diagnostic, ...]
    binder: Binder

    @property
    def problems(self) -> tuple[Problem, ...]:
        """The problems of all parts."""
        return tuple(problem for part in self.parts for problem in part.problems)

    @cached_property
    def keys(self) -> frozenset[str]:
        """All keys that reach anything."""
        return frozenset().union(*(part.keys for part in self.parts))

    @property
    def reached_by(self) -> dict[str, frozenset[str]]:
        """The keys that decide anything of a thing, by its name."""
        return {thing: part.keys for part in self.parts for thing in part.things}

    @property
    def count(self) -> int:
        """How many combinations of all keys there are."""
        return self.binder.variety.count(self.keys)

    def whole(self, combination: Combination) -> Problem:
        """The problem of all parts in a combination of all keys."""
        if len(self.parts) == 1 and combination in self.parts[0].combinations:
            return self.parts[0].problems[self.parts[0].index(combination)]
        return self.binder.problem(combination)


def lower(program: SceneProgram, library: AssetLibrary, spans: Spans, memo: Memo | None = None) -> Lowered:
    """The problems that a program poses with the assets of a library, `MAX_COMBINATIONS` a part at most.

    Where there were more, pools of upright things that carry nothing keep all their candidates at once (info
    `scene/union-footprints`); where there are still too many, that is an error (`scene/too-many`). Things and
    relations that `memo` knows are the same objects as before.
    """
    names = Names(program)
    variety = Variety(names)
    binder = Binder(names, variety, library, spans, memo or Memo())
    binder.found += check_assets(program, library, spans)
    if any_error(binder.found):
        return Lowered((), tuple(binder.found), binder)
    if not variety.is_open:
        things, nodes = tuple(t for copies in names.copies.values() for t in copies), frozenset(names.copies)
        part = Part(things, nodes, frozenset(), (), ({},), (binder.problem({}),))
        return Lowered(() if any_error(binder.found) else (part,), tuple(binder.found), binder)
    found = _islands(binder)
    if any_error(binder.found):
        return Lowered((), tuple(binder.found), binder)
    try:
        binder.found += _limited(found, variety, spans)
    except InvalidInput as error:
        return Lowered((), (*binder.found, error.diagnostic), binder)
    parts = tuple(_part(things, binder) for things in _grouped(found, variety))
    return Lowered(() if any_error(binder.found) else parts, tuple(binder.found), binder)


def _islands(binder: Binder) -> tuple[tuple[str, ...], ...]:
    variety, layout = binder.variety, binder.names.program.layout
    everything = (tuple(thing for node in layout.nodes for thing in binder.names.copies[node]),)
    if not any(variety.keys_of(node) for node in layout.nodes):
        return everything
    probes = list(islice(variety.probes(), MAX_PROBES + 1))
    if len(probes) > MAX_PROBES:
        return everything
    problems = [binder.problem(probe) for probe in probes]
    return everything if any_error(binder.found) else islands(problems)


def _nodes(names: Names, things: Collection[str]) -> frozenset[str]:
    inside = set(things)
    return frozenset(node for node, copies in names.copies.items() if not inside.isdisjoint(copies))


def _keys(variety: Variety, things: Collection[str]) -> frozenset[str]:
    own = (variety.keys_of(node) for node in _nodes(variety.names, things))
    return variety.background_keys().union(*own)


def _limited(found: Sequence[tuple[str, ...]], variety: Variety, spans: Spans) -> Iterator[Diagnostic]:
    """Takes pools of islands with too many combinations together, and says so. Raises InvalidInput."""
    layout, apart = variety.names.program.layout, variety.apart()
    many = [(things, variety.count(_keys(variety, things))) for things in found]
    many = [(things, count) for things, count in many if count > MAX_COMBINATIONS]
    reached = {key for things, _ in many for key in _keys(variety, things)}
    variety.together = frozenset(name for name in variety.written if f"objects.{name}" in reached) - apart
    for things, count in many:
        left = variety.count(_keys(variety, things))
        at = spans.place(("layout", "nodes", min(_nodes(variety.names, things), key=[*layout.nodes].index)))
        some = ", ".join(f"`{name}`" for name in things[:3]) + (f" and {len(things) - 3} more" if things[3:] else "")
        if left > MAX_COMBINATIONS:
            headline = f"the variants that reach {some} have {left} combinations that must be solved one by one"
            bound = {"value": left, "bound": MAX_COMBINATIONS, "unit": "combinations"}
            raise InvalidInput(finding("scene/too-many", headline, where=at, **bound))
        headline = f"{count} combinations of {some} are covered by {left}, with the union of their footprints"
        bound = {"value": count, "bound": MAX_COMBINATIONS, "unit": "combinations"}
        yield finding("scene/union-footprints", headline, where=at, **bound)


def _grouped(found: Sequence[tuple[str, ...]], variety: Variety) -> list[tuple[str, ...]]:
    """The islands, those that nothing but the background reaches as one."""
    everywhere = variety.background_keys()
    own = [things for things in found if _keys(variety, things) != everywhere]
    rest = tuple(thing for things in found if things not in own for thing in things)
    return [*([rest] if rest or not own else []), *own]


def _part(things: tuple[str, ...], binder: Binder) -> Part:
    variety, nodes = binder.variety, _nodes(binder.names, things)
    keys = _keys(variety, things)
    combinations = tuple(variety.combinations(keys))
    layout = binder.names.program.layout
    union = tuple(sorted(variety.together & {layout.nodes[node].object for node in nodes}))
    only = None if len(nodes) == len(layout.nodes) else nodes
    return Part(things, nodes, keys, union, combinations, tuple(binder.problem(one, only) for one in combinations))
