"""Check a runtime plan beyond its schema: every name and index in it refers to something that exists."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, finding
from schemas.scene.geometry import BACKGROUND
from schemas.scene.runtime_plan import PlanCase, PlanCombination, PlanPool, PlanThing, RuntimePlan

ROUNDING_M = 1e-9  # documents hold whole nanometres (`schemas.scene.geometry.rounded_value`)


def find_inconsistencies(plan: RuntimePlan) -> tuple[Diagnostic, ...]:
    """One `plan/inconsistent` diagnostic per inconsistency; none for plans that the compiler writes."""
    return tuple(finding("plan/inconsistent", text) for text in _inconsistencies(plan))


def _inconsistencies(plan: RuntimePlan) -> Iterator[str]:
    if not plan.combinations:
        yield "the plan has no combination"
    if any(not body.stances for body in plan.bodies):
        yield "a body has no stance"
    if any(not stance.prisms for body in plan.bodies for stance in body.stances):
        yield "a stance has no outline"
    prisms = (prism for body in plan.bodies for stance in body.stances for prism in stance.prisms)
    if any(body.package is not None and not _is_folder_name(body.package) for body in plan.bodies):
        yield "a body names a package by a path"
    if not all(_is_convex(prism.outline_m) for prism in prisms):
        yield "an outline of a stance is not convex or not counter-clockwise"
    materials, lighting = {item.id for item in plan.materials}, {item.id for item in plan.lighting}
    for index, combination in enumerate(plan.combinations):
        path = f"combinations[{index}]"
        yield from (f"{path}: {text}" for text in _combination(plan, combination))
        yield from (f"{path}: there is no material `{name}`" for name in combination.materials if name not in materials)
        yield from (f"{path}: there is no lighting `{name}`" for name in combination.lighting if name not in lighting)
    if not all(0.0 < combination.weight < np.inf for combination in plan.combinations):
        yield "a combination has no share of the draws"


def _is_folder_name(name: str) -> bool:
    """Whether `name` can only be a folder directly below another one."""
    return bool(name) and name not in (".", "..") and not set(name) & set("/\\\0")


def _is_convex(outline_m: FloatArray) -> bool:
    """Whether an outline (n, 2) turns left once around, up to the rounding of its corners."""
    corners = outline_m.reshape(-1, 2)
    edges = np.roll(corners, -1, axis=0) - corners
    edges = edges[np.hypot(edges[:, 0], edges[:, 1]) > 0.0]
    if len(edges) < 3:
        return False
    (x, y), (next_x, next_y) = edges.T, np.roll(edges, -1, axis=0).T
    cross, dot = x * next_y - y * next_x, x * next_x + y * next_y
    turns_right = cross < -ROUNDING_M * np.abs(edges).sum()
    return not turns_right.any() and round(float(np.arctan2(cross, dot).sum()) / (2.0 * np.pi)) == 1


def _combination(plan: RuntimePlan, combination: PlanCombination) -> Iterator[str]:
    X_WB = np.array(combination.X_WB)
    level = X_WB.shape == (4, 4) and np.allclose(X_WB[[0, 1, 2, 2, 2], [2, 2, 2, 0, 1]], [0, 0, 1, 0, 0], atol=1e-9)
    if not level or not np.isclose(np.hypot(X_WB[0, 0], X_WB[1, 0]), 1.0, atol=1e-9):
        yield "the pose of the background is not level"
    if combination.background is not None and not 0 <= combination.background < len(plan.bodies):
        yield f"there is no body {combination.background} for the background"
    things: dict[str, PlanThing] = {}
    for thing in combination.things:
        yield from (f"{thing.id}: {text}" for text in _thing(plan, combination, thing, things))
        things[thing.id] = thing
    if len(things) < len(combination.things):
        yield "two things have one id"
    shared = Counter(name for pool in combination.pools for name in pool.things)
    for name in sorted(set(shared) | set(things)):
        if shared[name] != 1 or name not in things:
            yield f"{name}: in {shared[name]} pools, {'a thing' if name in things else 'no thing'}"
    for number, pool in enumerate(combination.pools):
        if all(name in things for name in pool.things):
            yield from (f"pools[{number}]: {text}" for text in _pool(plan, pool, things))
    named = {name for relation in combination.relations for name in (*relation.things, relation.frame)}
    named |= set(combination.reach.members if combination.reach else ())
    named |= {space.owner for space in combination.keep_clear} | {n for stack in combination.stacks for n in stack}
    named |= {name for entry in combination.distractors for name in entry.things}
    yield from (f"there is no thing `{name}`" for name in sorted(named - set(things) - {BACKGROUND}))
    if any(not 0 <= rule.place < len(combination.places) for rule in combination.keep_outs):
        yield "a keep-out has no place"


def _thing(
    plan: RuntimePlan, combination: PlanCombination, thing: PlanThing, known: dict[str, PlanThing]
) -> Iterator[str]:
    if not thing.bodies or not all(0 <= body < len(plan.bodies) for body in thing.bodies):
        yield "its bodies are not in the plan"
    if not thing.stances:
        yield "it has no stance"
    if thing.parent != BACKGROUND and thing.parent not in known:
        yield f"its owner `{thing.parent}` does not stand before it"
    if not 0 <= thing.place < len(combination.places):
        yield f"there is no place {thing.place}"
    elif combination.places[thing.place][0] != thing.parent:
        yield f"its place belongs to `{combination.places[thing.place][0]}`, not to its owner `{thing.parent}`"


def _pool(plan: RuntimePlan, pool: PlanPool, things: dict[str, PlanThing]) -> Iterator[str]:
    if not pool.cases:
        yield "no case"
    for index, case in enumerate(pool.cases):
        lists = (case.cells_um, case.origins_um, case.yaws_urad, case.stances, case.base_um)
        if any(len(row) != len(pool.things) for row in lists):
            yield f"cases[{index}] does not have one entry a thing"
        else:
            bodies = [tuple(b for b in things[name].bodies if 0 <= b < len(plan.bodies)) for name in pool.things]
            yield from (f"cases[{index}]: {text}" for text in _case(plan, case, bodies))


def _case(plan: RuntimePlan, case: PlanCase, bodies: list[tuple[int, ...]]) -> Iterator[str]:
    if not 0.0 < case.weight < np.inf:
        yield "no share of the draws"
    for box in (*case.cells_um, *(box for box in case.origins_um if box is not None)):
        if box[0] > box[1] or box[2] > box[3]:
            yield f"{box} ends before it begins"
    for turns in case.yaws_urad:
        ends = [end for interval in turns for end in interval]
        if not ends or ends != sorted(ends):
            yield f"the yaws {turns} are not in order"
    for stance, possible in zip(case.stances, bodies, strict=True):
        if any(not 0 <= stance < len(plan.bodies[body].stances) for body in possible):
            yield f"a body has no stance {stance}"
