"""What is in a plan, in numbers: its choices, pools with their cases, and how freely each thing moves."""

from __future__ import annotations

from collections import Counter
from statistics import median
from typing import Any

from runtime_plan.tables import MICRO
from schemas.scene.runtime_plan import PlanPool, RuntimePlan


def choices(plan: RuntimePlan) -> dict[str, object]:
    """What `mana plan restrict` can choose from."""
    keys = dict.fromkeys(key for one in plan.combinations for key in one.combination)
    assets: dict[str, list[str]] = {}
    for one in plan.combinations:
        for thing in one.objects:
            ids = (plan.bodies[body].asset_id for body in thing.bodies)
            assets[thing.id] = list(dict.fromkeys((*assets.get(thing.id, ()), *ids)))
    return {
        "choice": {key: list(dict.fromkeys(one.combination[key] for one in plan.combinations)) for key in keys},
        "asset": assets,
        "material": [material.id for material in plan.materials],
        "lighting": [light.id for light in plan.lighting],
        "split": {side: list(ids) for side, ids in plan.split.items()},
    }


def pools(plan: RuntimePlan) -> list[dict[str, Any]]:
    """One row a pool: index of its combination, names, number of cases, their least, median and greatest quality, and
    how many are of each family."""
    return [_pool(index, pool) for index, one in enumerate(plan.combinations) for pool in one.pools]


def _pool(combination: int, pool: PlanPool) -> dict[str, Any]:
    quality = [case.quality for case in pool.cases]
    return {
        "combination": combination,
        "things": list(pool.things),
        "cases": len(pool.cases),
        "quality": {"least": min(quality), "median": median(quality), "most": max(quality)},
        "families": dict(Counter(case.family for case in pool.cases).most_common()),
    }


def things(plan: RuntimePlan) -> list[dict[str, Any]]:
    """One row a thing of each combination: tags, medians over its cases of width and depth of its cell (m) and of its
    freedom of yaw (rad), and the number of stances that it takes."""
    rows: list[dict[str, Any]] = []
    for index, one in enumerate(plan.combinations):
        tags = {thing.id: list(thing.semantic_tags) for thing in one.objects}
        for pool in one.pools:
            for k, name in enumerate(pool.things):
                if name not in tags:
                    continue
                cells = [case.cells_um[k] for case in pool.cases]
                rows.append(
                    {
                        "combination": index,
                        "thing": name,
                        "tags": tags[name],
                        "cell_m": [MICRO * median(cell[a + 1] - cell[a] for cell in cells) for a in (0, 2)],
                        "yaw_rad": MICRO * median(sum(b - a for a, b in case.yaws_urad[k]) for case in pool.cases),
                        "stances": len({case.stances[k] for case in pool.cases}),
                    }
                )
    return rows
