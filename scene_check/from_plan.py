"""Rules for the independent judge from one combination of a plan document, not from the tables of the sampler."""

from __future__ import annotations

import numpy as np
from shapely import Polygon

from geom.planar import front_of
from scene_check import CheckPlace, CheckPrism, CheckReach
from scene_check.batch import WORLD, KeepOutRule, PlaceRule, RelationRule, SceneRules, StanceGeometry, ThingRule
from schemas.scene.compiled import Prism
from schemas.scene.program import BACKGROUND
from schemas.scene.runtime_plan import PlanBody, PlanCombination, PlanPlace, PlanPolygon, PlanThing, RuntimePlan


def scene_rules(plan: RuntimePlan, combination: PlanCombination) -> SceneRules:
    """The rules of every sample of a combination. The forms of an object are all stances of all its bodies."""
    number = {thing.id: i for i, thing in enumerate(combination.things)} | {BACKGROUND: WORLD}
    X_WB = np.array(combination.X_WB)
    reach = combination.reach
    return SceneRules(
        things=tuple(_thing(plan, thing) for thing in combination.things),
        places=tuple(PlaceRule(number[owner], _place(owner, place)) for owner, place in combination.places),
        origin_m=X_WB[:3, 3],
        yaw_rad=float(np.arctan2(X_WB[1, 0], X_WB[0, 0])),
        clearance_m=plan.clearance_m,
        relations=tuple(
            RelationRule(
                rule.kind,
                tuple(number[name] for name in rule.things),
                np.array(rule.direction),
                number[rule.frame],
                rule.gap_m,
                rule.tolerance,
                rule.word or rule.kind,
            )
            for rule in combination.relations
        ),
        keep_outs=tuple(
            KeepOutRule(rule.place, _polygon(rule.polygon), rule.height_m) for rule in combination.keep_outs
        ),
        reach=None
        if reach is None
        else CheckReach(np.array(reach.base_m), reach.least_m, reach.most_m, tuple(reach.members)),
    )


def _thing(plan: RuntimePlan, thing: PlanThing) -> ThingRule:
    everywhere, all_around = (-np.inf, np.inf), (-np.pi, np.pi)
    return ThingRule(
        name=thing.id,
        forms=tuple(form for body in thing.bodies for form in _forms(plan.bodies[body])),
        place=thing.place,
        x_m=thing.x_m or everywhere,
        y_m=thing.y_m or everywhere,
        yaw_rad=thing.yaw_rad or all_around,
        fixed_poses=tuple((*spot.position_m, spot.yaw_rad, spot.stance) for spot in thing.spots),
        stances=thing.stances,
    )


def _forms(body: PlanBody) -> tuple[StanceGeometry, ...]:
    forms: list[StanceGeometry] = []
    for number, stance in enumerate(body.stances):
        prisms, front = tuple(map(_prism, stance.prisms)), front_of(stance.quat_wxyz)
        forms.append(StanceGeometry(prisms, front, stance.origin_height_m, number))
    return tuple(forms)


def _place(owner: str, place: PlanPlace) -> CheckPlace:
    return CheckPlace(
        owner=owner,
        name=place.name,
        origin_m=np.array(place.origin_m),
        yaw_rad=0.0,
        polygon=None if place.polygon is None else _polygon(place.polygon),
        layers=tuple((layer.low_m, layer.high_m, _polygon(layer.polygon)) for layer in place.layers),
        height_m=np.inf if place.height_m is None else place.height_m,
        above=tuple(map(_prism, place.above)),
    )


def _prism(prism: Prism) -> CheckPrism:
    return CheckPrism(np.array(prism.outline_m), prism.low_m, prism.high_m)


def _polygon(polygon: PlanPolygon) -> Polygon:
    return Polygon(polygon.outline_m, polygon.holes_m)
