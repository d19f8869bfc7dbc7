"""Judges a plan with the independent judge: every case at extreme poses, as scenes in the world frame."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from scene_check.batch import BatchPoses, SceneRules
from scene_check.check_batch import check_batch
from scene_check.from_plan import scene_rules
from schemas.arrays import FloatArray
from schemas.scene.geometry import BACKGROUND, Stance
from schemas.scene.plan_geometry import stance_of
from schemas.scene.runtime_plan import PlanCombination, PlanPool, RuntimePlan

Forms = Mapping[str, tuple[tuple[int, Stance], ...]]
EACH = 4  # scenes in which a case appears at least
JUDGED_AT_ONCE = 2_000  # scenes judged at once
EMPTY_M = 2e-6  # by which a cell may be too small for its footprint, from rounding


def judge(plan: RuntimePlan) -> None:
    """Raises RuntimeError when the judge refuses a scene, or a cell is empty: a defect of ours, not of the program."""
    for combination in plan.combinations:
        rules, forms = scene_rules(plan, combination), forms_of(plan, combination)
        count = EACH * max((len(pool.cases) for pool in combination.pools), default=0)
        for begin in range(0, count, JUDGED_AT_ONCE):
            scenes = np.arange(begin, min(begin + JUDGED_AT_ONCE, count))
            for k, violations in check_batch(rules, extremes(rules, combination, scenes, forms)):
                cases = {pool.things[0]: int(scenes[k]) % len(pool.cases) for pool in combination.pools}
                raise RuntimeError(f"{plan.scene}: the checker refuses cases {cases}: {violations[0]}")


def extremes(
    rules: SceneRules, combination: PlanCombination, scenes: np.ndarray, forms: Forms | None = None
) -> BatchPoses:
    """The given scenes (n,) by number: each case in turn, its things at ends of yaw intervals and corners of cells."""
    count, names = len(scenes), [thing.id for thing in combination.things]
    origin, yaw = np.zeros((count, len(names), 3)), np.zeros((count, len(names)))
    form = np.zeros((count, len(names)), dtype=np.int64)
    home = {name: (pool, k) for pool in combination.pools for k, name in enumerate(pool.things)}
    number = {name: i for i, name in enumerate(names)}
    forms = forms or {thing.name: thing.forms for thing in rules.things}
    for i, thing in enumerate(combination.things):
        at, turn, form[:, i] = _in_place(forms[thing.id], *home[thing.id], scenes, i)
        at += np.array(combination.places[thing.place][1].origin_m)
        if thing.parent == BACKGROUND:
            base, heading = np.broadcast_to(rules.origin_m, (count, 3)), np.full(count, rules.yaw_rad)
        else:
            base, heading = origin[:, number[thing.parent]], yaw[:, number[thing.parent]]
        c, s = np.cos(heading), np.sin(heading)
        origin[:, i] = base + np.stack([c * at[:, 0] - s * at[:, 1], s * at[:, 0] + c * at[:, 1], at[:, 2]], axis=1)
        yaw[:, i] = heading + turn
    objects = [i for i, thing in enumerate(combination.things) if not thing.is_frame]
    origin, yaw, form = origin[:, objects], yaw[:, objects], form[:, objects]
    return BatchPoses(origin, yaw, form, np.ones(form.shape, dtype=bool))


def forms_of(plan: RuntimePlan, combination: PlanCombination) -> Forms:
    """Number and geometry of every stance of every body that a thing may have, by its name."""
    stances = [tuple(enumerate(map(stance_of, body.stances))) for body in plan.bodies]
    return {thing.id: tuple(form for body in thing.bodies for form in stances[body]) for thing in combination.things}


def _in_place(
    forms: tuple[tuple[int, Stance], ...], pool: PlanPool, k: int, scenes: np.ndarray, number: int
) -> tuple[FloatArray, FloatArray, np.ndarray]:
    # Origins (n, 3) in A, yaws (n,) and forms (n,) of thing k of a pool.
    chosen = scenes % len(pool.cases)
    corner = scenes // len(pool.cases) + 3 * chosen + number
    cell = np.array([case.cells_um[k] for case in pool.cases])[chosen] * 1e-6
    wide = (-(10**9), 10**9) * 2
    bound = np.array([case.origins_um[k] or wide for case in pool.cases])[chosen] * 1e-6
    ends = [[end for run in case.yaws_urad[k] for end in run] for case in pool.cases]
    yaw = np.array([ends[c][(n // 4) % len(ends[c])] for c, n in zip(chosen, corner, strict=True)]) * 1e-6
    stance = np.array([case.stances[k] for case in pool.cases])[chosen]
    at, form = np.zeros((len(scenes), 3)), np.zeros(len(scenes), dtype=np.int64)
    for s in set(stance.tolist()):
        bodies = [f for f, (number_of_stance, _) in enumerate(forms) if number_of_stance == s]
        for b, f in enumerate(bodies):
            rows = np.flatnonzero((stance == s) & (corner % len(bodies) == b))
            form[rows] = f
            x, y = np.concatenate([prism.outline_m for prism in forms[f][1].prisms]).T
            c, n = np.cos(yaw[rows])[:, None], np.sin(yaw[rows])[:, None]
            px, py = c * x - n * y, n * x + c * y
            low = np.stack([cell[rows, 0] - px.min(axis=1), cell[rows, 2] - py.min(axis=1)], axis=1)
            high = np.stack([cell[rows, 1] - px.max(axis=1), cell[rows, 3] - py.max(axis=1)], axis=1)
            low, high = np.maximum(low, bound[rows][:, [0, 2]]), np.minimum(high, bound[rows][:, [1, 3]])
            if len(rows) and float((low - high).max()) > EMPTY_M:
                raise RuntimeError(f"{pool.things[k]}: a cell is empty at an end of its yaws")
            upper = np.stack([corner[rows] % 2, (corner[rows] // 2) % 2], axis=1)
            at[rows, :2] = np.where(low <= high, np.where(upper == 1, high, low), (low + high) / 2.0)
            at[rows, 2] = forms[f][1].origin_height_m
    at[:, 2] += np.array([case.base_um[k] for case in pool.cases])[chosen] * 1e-6
    return at, yaw, form
