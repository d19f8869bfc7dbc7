"""Cases of one pool: random layouts first, structured families where too few are found, solved layouts in any case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from scenec.ir.problem import Placement
from scenec.plan.cases.cells import cases_of
from scenec.plan.cases.free_rectangle import free_rectangle
from scenec.plan.cases.grid import grid
from scenec.plan.cases.guillotine import guillotine
from scenec.plan.cases.pool_model import GRAIN_M, Layouts, Member, PoolModel, around, joined, pool_model_of
from scenec.plan.cases.quality import quality
from scenec.plan.cases.rejection import CANDIDATE_TRIES, rejection_layouts
from scenec.plan.cases.select import FEW, selected
from scenec.plan.cases.shelf import shelf
from scenec.plan.cases.signature import distinct
from scenec.plan.cases.slots import layouts_in_slots, slot_options_of
from scenec.plan.cases.strip import strips
from scenec.solve.model import SolverModel
from scenec.solve.streams import stream
from schemas.arrays import FloatArray
from schemas.scene.geometry import BACKGROUND, ReachRing
from schemas.scene.runtime_plan import PlanCase

FAMILIES = (("grid", grid), ("guillotine", guillotine), ("free_rectangle", free_rectangle), ("shelf", shelf))
MISSES = 24  # partitions that may fail before a family is given up
STRUCTURED = 0.2  # share of the layouts missing after plain rejection
SURPLUS_OF_FEW, SURPLUS = 3.0, 1.3  # layouts made per requested case


@dataclass(frozen=True)
class PoolRequest:
    """Input of a pool: its things, frozen poses, the solved assignment, number of cases, seed."""

    names: tuple[str, ...]
    frozen: Mapping[str, Placement]
    solved: Mapping[str, Placement]
    count: int
    seed: int


def pool_cases(model: SolverModel, request: PoolRequest) -> list[PlanCase]:
    """Cases for the things of a pool in the order of their names; at least the solved layout."""
    pool = pool_model_of(model, request.names, request.frozen, request.solved)
    reach, base = reach_P(model, pool)
    rng = stream(request.seed, "cases", *request.names)
    if len(pool.members) == 1 and not pool.members[0].pinned:
        alone = _alone(pool, request, reach, base)
        if alone:
            return [case.model_copy(update={"quality": quality(pool, case)}) for case in alone]
    surplus = int((SURPLUS_OF_FEW if len(pool.members) <= FEW else SURPLUS) * request.count)
    parts = [solved_layout(pool, request.solved)]
    parts.append(rejection_layouts(pool, surplus - 1, rng, 1))
    if (missing := surplus - sum(map(len, parts))) > 0:
        # Crowded or with relations: no exact distribution to preserve, and structure adds variety.
        orderly = structured(pool, round(STRUCTURED * missing), rng) if len(pool.members) > 2 else []
        parts.append(rejection_layouts(pool, missing - sum(map(len, orderly)), rng, CANDIDATE_TRIES))
        missing = surplus - sum(map(len, [*parts, *orderly]))
        parts += orderly if missing <= 0 else [*orderly, *structured(pool, missing, rng)]
    cases = cases_of(pool, joined(parts), rng, reach, base, sure=1)
    judged = [case.model_copy(update={"quality": quality(pool, case)}) for case in distinct(request.names, cases)]
    return selected(pool, judged, request.count)


def structured(pool: PoolModel, layout_count: int, rng: Generator) -> list[Layouts]:
    """Layouts of the four structured families on the place that all members share, `layout_count` or fewer in all."""
    box, slot_options = _shared_box(pool), slot_options_of(pool)
    if box is None:
        return []
    layouts: list[Layouts] = []
    for number, (name, family) in enumerate(FAMILIES):
        share = -(-(layout_count - sum(map(len, layouts))) // (len(FAMILIES) - number))
        slots, misses = [], 0
        while len(slots) < share and misses < MISSES + 4 * len(slots):
            cut = family(box, slot_options, pool.clearance_m + 2 * GRAIN_M, rng)
            misses += cut is None
            slots += [] if cut is None else [cut]
        if slots:
            layouts.append(layouts_in_slots(pool, slot_options, np.array(slots), name, rng))
    return layouts


def _shared_box(pool: PoolModel) -> FloatArray | None:
    # The box of the one place on which all free members are; None where they are on several.
    boxes = [room.box_m for m in pool.members if not m.pinned for room in m.room.values()]
    same = boxes and all(np.array_equal(box, boxes[0]) for box in boxes)
    return boxes[0] + GRAIN_M * np.array([1.0, -1.0, 1.0, -1.0]) if same else None


def _alone(pool: PoolModel, request: PoolRequest, reach: ReachRing | None, base_P_m: np.ndarray) -> list[PlanCase]:
    # A single cell for a plain rectangle, else strips.
    (member,) = pool.members
    plain = not any(len(room.ends_m) or room.blocks for room in member.room.values())
    if not plain or (reach is not None and member.name in reach.members):
        return strips(pool, reach, base_P_m)
    rng = stream(request.seed, "alone", member.name)
    layouts = rejection_layouts(pool, 64, rng, CANDIDATE_TRIES)
    member_stance = member.stance[layouts.option[:, 0]]
    first = [int(np.flatnonzero(member_stance == s)[0]) for s in sorted(set(member_stance.tolist()))]
    return cases_of(pool, layouts.take(first), rng) if first else []


def solved_layout(pool: PoolModel, solved: Mapping[str, Placement]) -> Layouts:
    """The solver's assignment as the only layout; the option of a free member follows its grid."""
    n = len(pool.members)
    option, origin, rect = np.zeros((1, n), dtype=np.int64), np.zeros((1, n, 2)), np.zeros((1, n, 4))
    for i, member in enumerate(pool.members):
        placement = solved[member.name]
        shift = np.asarray(member.thing.place.origin_P_m[:2], dtype=np.float64)
        origin[0, i] = placement.x_m + shift[0], placement.y_m + shift[1]
        option[0, i] = _nearest(member, placement) if member.pinned else member.grid
        rect[:, i] = around(member, option[:, i], origin[:, i])
    return Layouts(option, origin, rect, ["seeded"])


def _nearest(member: Member, placement: Placement) -> int:
    shift = np.asarray(member.thing.place.origin_P_m[:2], dtype=np.float64)
    off = np.hypot(*(member.at_m - shift - (placement.x_m, placement.y_m)).T) + np.abs(member.base_m - placement.base_m)
    off += np.abs((member.yaw_rad - placement.yaw_rad + np.pi) % (2 * np.pi) - np.pi) + (
        member.stance != placement.stance
    )
    return int(off.argmin())


def reach_P(model: SolverModel, pool: PoolModel) -> tuple[ReachRing | None, np.ndarray]:
    """The reach and its base in the background's frame; None for things on movable owners, which are frozen."""
    reach = model.problem.reach
    if reach is None or pool.members[0].thing.parent != BACKGROUND:
        return None, np.zeros(2)
    return reach, (np.linalg.inv(model.problem.X_WB) @ (*reach.base_m, 1.0))[:2]
