"""Candidates for insertion: bodies in stances, in an order that depends on seed and number of the variant alone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from runtime_plan import Plan, sample
from runtime_plan.samples_file import sampled_lighting
from schemas.scene.program import PairedMaterial
from schemas.scene.runtime_plan import PlanBody, PlanStance

DRAWS = 64  # samples of a plan that one variant may use up
MOST = 1024  # candidates of a library that one variant may use up


@dataclass(frozen=True)
class InsertionCandidate:
    """A body in one of its stances; `material` is the one drawn with it, empty where it keeps its own.

    `place` is its place in the plan, empty where it comes from no plan.
    """

    body: PlanBody
    stance: PlanStance
    material: str = ""
    place: str = ""


@dataclass(frozen=True)
class VariantChoices:
    """Candidates of one variant in the order in which they are tried, its lighting with the channels drawn, and the
    materials that candidates name.
    """

    candidates: Sequence[InsertionCandidate]
    lights: dict[str, float | str] = field(default_factory=dict)
    materials: Mapping[str, PairedMaterial] = field(default_factory=dict)


def from_plan(plan: Plan, seed: int, number: int) -> VariantChoices:
    """The objects of samples of a plan: assets, stances, materials and lighting that go together, places left out.

    Samples `number * DRAWS` and those after it, so that no two variants share one.
    """
    drawn = sample(plan, DRAWS, seed, start=number * DRAWS)
    bodies, materials = plan.document.bodies, plan.document.materials
    candidates = []
    for k in range(DRAWS):
        combination = plan.document.combinations[int(drawn.combination[k])]
        places = {thing.id: combination.places[thing.place][1].name for thing in combination.things}
        for column in np.flatnonzero(drawn.present[k]).tolist():
            body = bodies[int(drawn.asset_index[k, column])]
            material_index = int(drawn.material[k, column])
            stance = body.stances[int(drawn.stance[k, column])]
            material = "" if material_index < 0 else materials[material_index].id
            candidates.append(InsertionCandidate(body, stance, material, places[drawn.names[column]]))
    light = sampled_lighting(plan, drawn, 0)
    lights = {} if light is None else light.model_dump(exclude_none=True)
    return VariantChoices(candidates, lights, {material.id: material for material in materials})


def from_bodies(bodies: Sequence[PlanBody], seed: int, number: int) -> VariantChoices:
    """Bodies drawn evenly, each time in any of its stances."""
    rng = np.random.default_rng([seed, number, 0])
    drawn = [bodies[k] for k in rng.integers(len(bodies), size=MOST).tolist()]
    shares = rng.random(MOST).tolist()
    return VariantChoices(
        [InsertionCandidate(b, b.stances[int(share * len(b.stances))]) for b, share in zip(drawn, shares, strict=True)]
    )


def outlines(stance: PlanStance) -> Iterator[np.ndarray]:
    """Outlines (n, 2) of the pieces of a stance."""
    return (prism.outline_m for prism in stance.prisms)
