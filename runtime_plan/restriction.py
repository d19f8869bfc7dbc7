"""Restrict a plan for a task: filter its alternatives, or replace lightings, which change no geometry.

Cases stay as they are, so the samples of the restricted plan are as valid as those of the plan.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from runtime_plan.plan import Plan, prepare
from schemas.diagnostics import InvalidInput, finding
from schemas.scene.program import Lighting
from schemas.scene.runtime_plan import PlanCombination, PlanThing, RuntimePlan


@dataclass(frozen=True)
class Restriction:
    """`split` keeps assets that are not named for the other side of the split. `choices` maps a key of the plan's
    combinations (`variants.backgrounds`, `objects.mug`) to the values that stay, `assets` a thing to its asset ids.
    `materials` and `lighting` name what stays (None: all); a whole `Lighting` there replaces those of the plan.
    """

    split: Literal["train", "eval"] | None = None
    choices: Mapping[str, Sequence[str]] = field(default_factory=dict[str, Sequence[str]])
    assets: Mapping[str, Sequence[str]] = field(default_factory=dict[str, Sequence[str]])
    materials: Sequence[str] | None = None
    lighting: Sequence[str | Lighting] | None = None


def restrict(plan: Plan, restriction: Restriction) -> Plan:
    """The restricted plan, ready to be sampled; its provenance names the plan it is taken from.

    Raises InvalidInput: `plan/unknown-choice` for a name that the plan does not have, `plan/nothing-left` when no
    combination stays.
    """
    document = plan.document
    _known(document, restriction)
    held_out = _held_out_assets(document, restriction.split)
    restricted = [_restricted(document, combination, restriction, held_out) for combination in document.combinations]
    combinations = tuple(combination for combination in restricted if combination is not None)
    if not combinations:
        raise InvalidInput(finding("plan/nothing-left", "the restriction leaves no combination of the plan"))
    lighting = _lighting(document, restriction)
    return prepare(
        document.model_copy(
            update={
                "combinations": tuple(
                    _with_lighting(combination, restriction, lighting) for combination in combinations
                ),
                "lighting": lighting,
                "provenance": document.provenance.model_copy(update={"restricted_from": plan.sha256}),
            }
        )
    )


def _held_out_assets(plan: RuntimePlan, split: str | None) -> frozenset[str]:
    """Asset ids of the other side of the split."""
    return frozenset(plan.split.get("eval" if split == "train" else "train", ())) if split else frozenset()


def _restricted(
    plan: RuntimePlan, combination: PlanCombination, restriction: Restriction, held_out: frozenset[str]
) -> PlanCombination | None:
    if any(combination.combination.get(key) not in values for key, values in restriction.choices.items()):
        return None
    if combination.background is not None and plan.bodies[combination.background].asset_id in held_out:
        return None
    things = tuple(
        _with_allowed_bodies(plan, thing, restriction.assets.get(thing.id), held_out) for thing in combination.things
    )
    if not all(thing.bodies for thing in things):
        return None
    stay = combination.materials if restriction.materials is None else restriction.materials
    materials = tuple(name for name in combination.materials if name in stay)
    return combination.model_copy(update={"things": things, "materials": materials})


def _with_allowed_bodies(
    plan: RuntimePlan, thing: PlanThing, allowed: Sequence[str] | None, held_out: frozenset[str]
) -> PlanThing:
    ids = {body: plan.bodies[body].asset_id for body in thing.bodies}
    stay = (body for body in thing.bodies if ids[body] not in held_out and (allowed is None or ids[body] in allowed))
    return thing.model_copy(update={"bodies": tuple(stay)})


def _lighting(plan: RuntimePlan, restriction: Restriction) -> tuple[Lighting, ...]:
    new = tuple(light for light in restriction.lighting or () if isinstance(light, Lighting))
    taken = {light.id for light in new}
    return (*(light for light in plan.lighting if light.id not in taken), *new)


def _with_lighting(
    combination: PlanCombination, restriction: Restriction, lighting: Sequence[Lighting]
) -> PlanCombination:
    if restriction.lighting is None:
        return combination
    new = {light.id for light in restriction.lighting if isinstance(light, Lighting)}
    known = {name for name in restriction.lighting if isinstance(name, str)} & set(combination.lighting)
    return combination.model_copy(update={"lighting": tuple(light.id for light in lighting if light.id in new | known)})


def _known(plan: RuntimePlan, restriction: Restriction) -> None:
    """Raise unless the plan has every name: a misspelt one would silently leave all or nothing."""
    values: dict[str, set[str]] = {}
    assets: dict[str, set[str]] = {}
    for combination in plan.combinations:
        for key, value in combination.combination.items():
            values.setdefault(key, set()).add(value)
        for thing in combination.things:
            assets.setdefault(thing.id, set()).update(plan.bodies[body].asset_id for body in thing.bodies)
    _all_in("choice", restriction.choices, values)
    _all_in("thing", restriction.assets, assets)
    _each_in("material", restriction.materials or (), {material.id for material in plan.materials})
    named = [light for light in restriction.lighting or () if isinstance(light, str)]
    _each_in("lighting", named, {light.id for light in plan.lighting})
    if restriction.split is not None and not plan.split:
        raise InvalidInput(finding("plan/unknown-choice", "the plan has no split of its assets"))


def _all_in(kind: str, requested: Mapping[str, Sequence[str]], known: Mapping[str, set[str]]) -> None:
    _each_in(kind, tuple(requested), set(known))
    for key, names in requested.items():
        _each_in(f"value of {key}", names, known[key])


def _each_in(kind: str, requested: Sequence[str], known: set[str]) -> None:
    for name in requested:
        if name not in known:
            has = ", ".join(f"`{choice}`" for choice in sorted(known)) or "none"
            raise InvalidInput(finding("plan/unknown-choice", f"the plan has no {kind} `{name}`; it has {has}"))
