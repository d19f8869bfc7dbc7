"""Poses drawn from the cases of a plan as its schema says, written anew for the tests."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.random import Generator

from scenec.ir.problem import Placement, Problem, Solved
from scenec.plan.document import plan_text, runtime_plan
from schemas.scene.program import SceneProgram
from schemas.scene.runtime_plan import PlanCombination, RuntimePlan


def plan_of(problem: Problem, solved: Solved, *, seed: int = 0, diversity: float = 0.2) -> RuntimePlan:
    """The plan of a problem that has no program."""
    program = SceneProgram(scene=problem.scene, clearance=problem.clearance_m)
    plan = runtime_plan(program, [problem], [solved], seed=seed, diversity=diversity)
    return RuntimePlan.model_validate_json(plan_text(plan))


def draws(
    plan: RuntimePlan, combination: PlanCombination, rng: Generator, count: int
) -> Iterator[dict[str, Placement]]:
    """Placements of whole scenes, corners of cells as often as their insides."""
    things = {thing.id: thing for thing in combination.things}
    for _ in range(count):
        placements = {}
        for pool in combination.pools:
            weights = np.array([case.weight for case in pool.cases])
            case = pool.cases[int(rng.choice(len(weights), p=weights / weights.sum()))]
            for i, name in enumerate(pool.things):
                low, high = np.array(case.yaws_urad[i])[int(rng.integers(len(case.yaws_urad[i])))] * 1e-6
                yaw = float(low + _share(rng) * (high - low))
                body = plan.bodies[things[name].bodies[0]].stances[case.stances[i]]
                x, y = np.concatenate([prism.outline_m for prism in body.prisms]).T
                px, py = np.cos(yaw) * x - np.sin(yaw) * y, np.sin(yaw) * x + np.cos(yaw) * y
                x0, x1, y0, y1 = np.array(case.cells_um[i]) * 1e-6
                low_m, high_m = np.array([x0 - px.min(), y0 - py.min()]), np.array([x1 - px.max(), y1 - py.max()])
                if (bounds := case.origins_um[i]) is not None:
                    low_m = np.maximum(low_m, np.array(bounds[::2]) * 1e-6)
                    high_m = np.minimum(high_m, np.array(bounds[1::2]) * 1e-6)
                assert (low_m <= high_m + 1e-6).all(), (name, case.family, low_m - high_m)
                at = low_m + np.array([_share(rng), _share(rng)]) * (high_m - low_m)
                placements[name] = Placement(float(at[0]), float(at[1]), yaw, case.stances[i], case.base_um[i] * 1e-6)
        yield placements


def _share(rng: Generator) -> float:
    return float(rng.choice([0.0, 1.0, rng.random(), rng.random()]))
