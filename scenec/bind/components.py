"""Binds a program to geometry, component by component: each has combinations and problems of its own."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice

from scenec.bind.asset_library import AssetLibrary
from scenec.bind.bind_combination import Lowering
from scenec.bind.check_assets import check_assets
from scenec.bind.check_joints import check_joints
from scenec.bind.check_materials import check_materials
from scenec.bind.independent_components import independent_components
from scenec.bind.variants import MAX_COMBINATIONS, Combination, VariantSpace
from scenec.ir.derivation_cache import DerivationCache
from scenec.ir.names import Names
from scenec.ir.problem import Problem
from schemas.diagnostics import Diagnostic, InvalidInput, any_error, finding
from schemas.scene.program import SceneProgram
from source.tree import Spans

MAX_PROBES = 64  # lowerings that determine which things may meet; with more, all is one component


@dataclass(frozen=True)
class IndependentComponent:
    """Things that share nothing with others, and a problem of these things for each combination of the keys that affect
    them. `union` are objects that stand for all their candidates at once, because single ones would be too many."""

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
        """Number of its combination that is part of a combination of all keys."""
        return self._index[frozenset((key, value) for key, value in whole.items() if key in self.keys)]


class Binder:
    """Makes problems of combinations; findings are collected in `diagnostics`."""

    def __init__(
        self, names: Names, variants: VariantSpace, library: AssetLibrary, spans: Spans, derivations: DerivationCache
    ) -> None:
        self.names, self.variants, self.library, self.spans, self.derivations = (
            names,
            variants,
            library,
            spans,
            derivations,
        )
        self.diagnostics: list[Diagnostic] = []

    def problem(self, combination: Combination, nodes: Collection[str] | None = None) -> Problem:
        """The problem of a combination, of some nodes or of all. A missing key has its first value."""
        choice = self.variants.choice(combination)
        lowering = Lowering(self.names, choice, self.library, self.spans, self.derivations, nodes)
        problem = lowering.problem()
        self.diagnostics += [diagnostic for diagnostic in lowering.diagnostics if diagnostic not in self.diagnostics]
        return problem


@dataclass(frozen=True)
class Lowered:
    """The components of a program, none when a diagnostic is an error; each thing is in exactly one."""

    components: tuple[IndependentComponent, ...]
    diagnostics: tuple[Diagnostic, ...]
    binder: Binder

    @property
    def problems(self) -> tuple[Problem, ...]:
        """The problems of all components."""
        return tuple(problem for component in self.components for problem in component.problems)

    @cached_property
    def keys(self) -> frozenset[str]:
        """All keys that affect any thing."""
        return frozenset().union(*(component.keys for component in self.components))

    @property
    def reached_by(self) -> dict[str, frozenset[str]]:
        """The keys that affect a thing, by its name."""
        return {thing: component.keys for component in self.components for thing in component.things}

    @property
    def count(self) -> int:
        """How many combinations of all keys there are."""
        return self.binder.variants.count(self.keys)

    def whole(self, combination: Combination) -> Problem:
        """The problem of all components in a combination of all keys."""
        if len(self.components) == 1 and combination in self.components[0].combinations:
            return self.components[0].problems[self.components[0].index(combination)]
        return self.binder.problem(combination)


def lower(
    program: SceneProgram, library: AssetLibrary, spans: Spans, derivations: DerivationCache | None = None
) -> Lowered:
    """The problems of a program with the assets of a library, at most `MAX_COMBINATIONS` per component.

    Where there are more, pools of upright things that carry nothing stand for all their candidates at once (info
    `scene/union-footprints`); where there are still too many, that is an error (`scene/too-many`). Things and relations
    in `derivations` are the same Python objects as before.
    """
    names = Names(program)
    variants = VariantSpace(names)
    binder = Binder(names, variants, library, spans, derivations or DerivationCache())
    binder.diagnostics += check_assets(program, library, spans)
    binder.diagnostics += check_materials(program, library, spans)
    if any_error(binder.diagnostics):
        return Lowered((), tuple(binder.diagnostics), binder)
    binder.diagnostics += check_joints(names, library, spans)
    if any_error(binder.diagnostics):
        return Lowered((), tuple(binder.diagnostics), binder)
    if not variants.is_open:
        things, nodes = _all_things(names), frozenset(names.copies)
        component = IndependentComponent(things, nodes, frozenset(), (), ({},), (binder.problem({}),))
        return Lowered(() if any_error(binder.diagnostics) else (component,), tuple(binder.diagnostics), binder)
    component_things = _independent_components(binder)
    if any_error(binder.diagnostics):
        return Lowered((), tuple(binder.diagnostics), binder)
    try:
        binder.diagnostics += _limited(component_things, variants, spans)
    except InvalidInput as error:
        return Lowered((), (*binder.diagnostics, error.diagnostic), binder)
    components = tuple(_component(things, binder) for things in _grouped(component_things, variants))
    return Lowered(() if any_error(binder.diagnostics) else components, tuple(binder.diagnostics), binder)


def _independent_components(binder: Binder) -> tuple[tuple[str, ...], ...]:
    variants, layout = binder.variants, binder.names.program.layout
    everything = (_all_things(binder.names),)
    if not any(variants.keys_of(node) for node in layout.nodes):
        return everything
    probes = list(islice(variants.probes(), MAX_PROBES + 1))
    if len(probes) > MAX_PROBES:
        return everything
    problems = [binder.problem(probe) for probe in probes]
    return everything if any_error(binder.diagnostics) else independent_components(problems)


def _all_things(names: Names) -> tuple[str, ...]:
    """All placed things, and the frames of grids."""
    return (*(thing for copies in names.copies.values() for thing in copies), *names.grids)


def _nodes(names: Names, things: Collection[str]) -> frozenset[str]:
    inside = set(things)
    return frozenset(node for node, copies in names.copies.items() if not inside.isdisjoint(copies))


def _keys(variants: VariantSpace, things: Collection[str]) -> frozenset[str]:
    node_keys = (variants.keys_of(node) for node in _nodes(variants.names, things))
    return variants.background_keys().union(*node_keys)


def _limited(component_things: Sequence[tuple[str, ...]], variants: VariantSpace, spans: Spans) -> Iterator[Diagnostic]:
    """Unites the candidates of pools in components with too many combinations; a finding for each. Raises
    InvalidInput."""
    layout, separate = variants.names.program.layout, variants.must_be_separate()
    many = [(things, variants.count(_keys(variants, things))) for things in component_things]
    many = [(things, count) for things, count in many if count > MAX_COMBINATIONS]
    reached = {key for things, _ in many for key in _keys(variants, things)}
    variants.united |= frozenset(name for name in variants.as_authored if f"objects.{name}" in reached) - separate
    for things, count in many:
        left = variants.count(_keys(variants, things))
        at = spans.place(("layout", "nodes", min(_nodes(variants.names, things), key=[*layout.nodes].index)))
        some = ", ".join(f"`{name}`" for name in things[:3]) + (f" and {len(things) - 3} more" if things[3:] else "")
        if left > MAX_COMBINATIONS:
            headline = f"the variants that reach {some} have {left} combinations that must be solved one by one"
            bound = {"value": left, "bound": MAX_COMBINATIONS, "unit": "combinations"}
            raise InvalidInput(finding("scene/too-many", headline, where=at, **bound))
        headline = f"{count} combinations of {some} are covered by {left}, with the union of their footprints"
        bound = {"value": count, "bound": MAX_COMBINATIONS, "unit": "combinations"}
        yield finding("scene/union-footprints", headline, where=at, **bound)


def _grouped(component_things: Sequence[tuple[str, ...]], variants: VariantSpace) -> list[tuple[str, ...]]:
    """The components; those affected by background keys alone are joined into one."""
    everywhere = variants.background_keys()
    with_own_keys = [things for things in component_things if _keys(variants, things) != everywhere]
    rest = tuple(thing for things in component_things if things not in with_own_keys for thing in things)
    return [*([rest] if rest or not with_own_keys else []), *with_own_keys]


def _component(things: tuple[str, ...], binder: Binder) -> IndependentComponent:
    variants, nodes = binder.variants, _nodes(binder.names, things)
    keys = _keys(variants, things)
    combinations = tuple(variants.combinations(keys))
    layout = binder.names.program.layout
    union = tuple(sorted(variants.united & {layout.nodes[node].object for node in nodes}))
    only = None if len(nodes) == len(layout.nodes) else nodes
    return IndependentComponent(
        things, nodes, keys, union, combinations, tuple(binder.problem(one, only) for one in combinations)
    )
