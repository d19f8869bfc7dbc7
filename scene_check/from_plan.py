"""Rules for the independent judge from one combination of a plan document, not from the tables of the sampler."""

from __future__ import annotations

import numpy as np

from scene_check.batch import SceneRules, ThingRule
from schemas.scene.plan_geometry import (
    domain_of,
    keep_clear_of,
    keep_out_of,
    place_of,
    reach_of,
    relation_of,
    stance_of,
)
from schemas.scene.runtime_plan import PlanCombination, RuntimePlan


def scene_rules(plan: RuntimePlan, combination: PlanCombination) -> SceneRules:
    """The rules of every sample of a combination. The forms of an object are all stances of all its bodies."""
    forms = [tuple(enumerate(map(stance_of, body.stances))) for body in plan.bodies]
    places = [(owner, place_of(place)) for owner, place in combination.places]
    X_WB = np.array(combination.X_WB)
    return SceneRules(
        things=tuple(
            ThingRule(
                thing.id,
                tuple(form for body in thing.bodies for form in forms[body]),
                *places[thing.place],
                domain_of(thing),
            )
            for thing in combination.things
        ),
        origin_m=X_WB[:3, 3],
        yaw_rad=float(np.arctan2(X_WB[1, 0], X_WB[0, 0])),
        clearance_m=plan.clearance_m,
        relations=tuple(map(relation_of, combination.relations)),
        keep_outs=tuple(keep_out_of(rule, *places[rule.place]) for rule in combination.keep_outs),
        keep_clear=tuple(map(keep_clear_of, combination.keep_clear)),
        reach=None if combination.reach is None else reach_of(combination.reach),
        stacks=combination.stacks,
    )
