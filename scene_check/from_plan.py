"""Rules for the independent judge from one combination of a plan document, not from the tables of the sampler."""

from __future__ import annotations

import numpy as np

from scene_check.batch import GridRule, SceneRules, ThingRule
from schemas.scene.geometry import Domain, ScenePlace
from schemas.scene.plan_geometry import (
    domain_of,
    keep_clear_of,
    keep_out_of,
    place_of,
    reach_of,
    relation_of,
    stance_of,
)
from schemas.scene.runtime_plan import PlanCombination, PlanThing, RuntimePlan


def scene_rules(plan: RuntimePlan, combination: PlanCombination) -> SceneRules:
    """The rules of every sample of a combination, of its objects. The forms of an object are all stances of all its
    bodies. A member of a grid stands where its grid does, and is bound by the grid alone."""
    forms = [tuple(enumerate(map(stance_of, body.stances))) for body in plan.bodies]
    places = [(owner, place_of(place)) for owner, place in combination.places]
    frames = {thing.id: thing for thing in combination.things if thing.is_frame}
    X_WB = np.array(combination.X_WB)
    return SceneRules(
        things=tuple(
            ThingRule(
                thing.id,
                tuple(form for body in thing.bodies for form in forms[body]),
                *places[combination.standing_on(thing)[1]],
                Domain() if thing.parent in frames else domain_of(thing),
            )
            for thing in combination.objects
        ),
        origin_m=X_WB[:3, 3],
        yaw_rad=float(np.arctan2(X_WB[1, 0], X_WB[0, 0])),
        clearance_m=plan.clearance_m,
        relations=tuple(map(relation_of, combination.relations)),
        keep_outs=tuple(keep_out_of(rule, *places[rule.place]) for rule in combination.keep_outs),
        keep_clear=tuple(map(keep_clear_of, combination.keep_clear)),
        reach=None if combination.reach is None else reach_of(combination.reach),
        stacks=combination.stacks,
        grids=tuple(_grid(combination, frame, *places[frame.place]) for frame in frames.values()),
    )


def _grid(combination: PlanCombination, frame: PlanThing, owner: str, place: ScenePlace) -> GridRule:
    members = [thing for thing in combination.things if thing.parent == frame.id]
    offsets = np.array([spot.position_m[:2] for thing in members for spot in thing.spots])
    return GridRule(frame.id, tuple(thing.id for thing in members), offsets, owner, place, domain_of(frame))
