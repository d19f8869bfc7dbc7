"""The verifiers between the phases: complete problems pass, each defect is named at its phase."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import Polygon

from scenec.check import between_phases
from scenec.emit.scene import compiled_scene
from scenec.ir.problem import Problem
from schemas.scene.geometry import ReachRing, ScenePlace, SceneRelation
from tests.support.scene.problems import table_setting

PROBLEM, PLACEMENTS = table_setting()
FIRST, *OTHERS = PROBLEM.things


def first(**changes) -> Problem:
    return replace(PROBLEM, things=(replace(FIRST, **changes), *OTHERS))


def of_body(**changes) -> Problem:
    stance = replace(FIRST.body.resting_orientations[0], **changes)
    return first(body=replace(FIRST.body, resting_orientations=(stance,)))


def test_a_whole_problem_passes_all():
    between_phases.after_binding(PROBLEM)
    between_phases.after_analysis(PROBLEM, [[thing.name] for thing in PROBLEM.things])
    between_phases.after_solving(PROBLEM, PLACEMENTS)
    between_phases.after_emission(PROBLEM, compiled_scene(PROBLEM, PLACEMENTS, 0))


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        (replace(PROBLEM, things=(*PROBLEM.things, FIRST)), "2 things are called"),
        (first(parent="nobody"), "the owner nobody"),
        (first(domain=replace(FIRST.domain, orientation_indices=(7,))), "no stance 7"),
        (first(domain=replace(FIRST.domain, orientation_indices=())), "no way to stand"),
        (first(domain=replace(FIRST.domain, x_m=(0.2, 0.1))), "x of .* is reversed"),
        (first(domain=replace(FIRST.domain, y_m=(np.nan, 0.1))), "y of .* is reversed"),
        (of_body(prisms=()), "no collision geometry"),
        (of_body(quat_wxyz=(2.0, 0.0, 0.0, 0.0)), "no unit length"),
        (first(place=ScenePlace("flat", Polygon(), np.zeros(3))), "flat is no area"),
        (replace(PROBLEM, relations=(SceneRelation("near", (FIRST.name, "nobody")),)), "near speaks of nobody"),
        (replace(PROBLEM, relations=(SceneRelation("before", (FIRST.name,), (0.0, 0.0)),)), "no unit length"),
        (replace(PROBLEM, reach=ReachRing(np.zeros(3), 0.1, 0.5, ("nobody",), ())), "the reach names nobody"),
    ],
)
def test_faults_of_binding_are_named(broken: Problem, said: str):
    with pytest.raises(RuntimeError, match=f"after binding: .*{said}"):
        between_phases.after_binding(broken)


def test_faults_of_later_phases_are_named():
    names = [thing.name for thing in PROBLEM.things]
    with pytest.raises(RuntimeError, match=f"after analysis: {FIRST.name} is in 0 components"):
        between_phases.after_analysis(PROBLEM, [names[1:]])
    with pytest.raises(RuntimeError, match=r"after analysis: .* is in 2 components"):
        between_phases.after_analysis(PROBLEM, [names, names[:1]])
    scene = compiled_scene(PROBLEM, PLACEMENTS, 0)
    with pytest.raises(RuntimeError, match=r"after emission: .* is written 0 times"):
        between_phases.after_emission(PROBLEM, scene.model_copy(update={"objects": scene.objects[1:]}))
    lost = scene.objects[0].model_copy(update={"position_m": (np.nan, 0.0, 0.0)})
    with pytest.raises(RuntimeError, match=r"after emission: .* has no pose"):
        between_phases.after_emission(PROBLEM, scene.model_copy(update={"objects": (lost, *scene.objects[1:])}))
