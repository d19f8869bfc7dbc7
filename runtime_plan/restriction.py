"""What a task leaves of a plan: alternatives filtered, or replaced where that changes no geometry.

Cases are never touched, so what is left is as valid as what it was taken from.
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
    """`split` keeps assets that are not named for the other side of the split. `choices` says of a key of the plan's
    combinations (`variants.backgrounds`, `objects.mug`) which values stay, `assets` which asset ids a thing may be.
    `materials` and `lighting` name what stays (None: all); a whole `Lighting` there replaces those of the plan.
    """

    split: Literal["train", "eval"] | None = None
    choices: Mapping[str, Sequence[str]] = field(default_factory=dict)
    assets: Mapping[str, Sequence[str]] = field(default_factory=dict)
    materials: Sequence[str] | None = None
    lighting: Sequence[str | Lighting] | None = None


def restrict(plan: Plan, restriction: Restriction) -> Plan:
    """The plan with what `restriction` leaves, ready to be sampled; its provenance names the plan it is taken from.

    Raises InvalidInput: `plan/unknown-choice` for a name that the plan does not have, `plan/nothing-left` when no
    combination stays.
    """
    document = plan.document
    _known(document, restriction)
    hidden = _hidden(document, restriction.split)
    left = [_left(document, one, restriction, hidden) for one in document.combinations]
    combinations = tuple(one for one in left if one is not None)
    if not combinations:
        raise InvalidInput(finding("plan/nothing-left", "the restriction leaves no combination of the plan"))
    lighting = _lighting(document, restriction)
    return prepare(
        document.model_copy(
            update={
                "combinations": tuple(_lit(one, restriction, lighting) for one in combinations),
                "lighting": lighting,
                "provenance": document.provenance.model_copy(update={"restricted_from": plan.sha256}),
            }
        )
    )


def _hidden(plan: RuntimePlan, split: str | None) -> frozenset[str]:
    """Asset ids of the other side."""
    return frozenset(plan.split.get("eval" if split == "train" else "train", ())) if split else frozenset()


def _left(
    plan: RuntimePlan, one: PlanCombination, restriction: Restriction, hidden: frozenset[str]
) -> PlanCombination | None:
    if any(one.combination.get(key) not in values for key, values in restriction.choices.items()):
        return None
    if one.background is not None and plan.bodies[one.background].asset_id in hidden:
        return None
    things = tuple(_bodies_left(plan, thing, restriction.assets.get(thing.id), hidden) for thing in one.things)
    if not all(thing.bodies for thing in things):
        return None
    stay = one.materials if restriction.materials is None else restriction.materials
    materials = tuple(name for name in one.materials if name in stay)
    return one.model_copy(update={"things": things, "materials": materials})


def _bodies_left(
    plan: RuntimePlan, thing: PlanThing, allowed: Sequence[str] | None, hidden: frozenset[str]
) -> PlanThing:
    ids = {body: plan.bodies[body].asset_id for body in thing.bodies}
    stay = (body for body in thing.bodies if ids[body] not in hidden and (allowed is None or ids[body] in allowed))
    return thing.model_copy(update={"bodies": tuple(stay)})


def _lighting(plan: RuntimePlan, restriction: Restriction) -> tuple[Lighting, ...]:
    new = tuple(light for light in restriction.lighting or () if isinstance(light, Lighting))
    taken = {light.id for light in new}
    return (*(light for light in plan.lighting if light.id not in taken), *new)


def _lit(one: PlanCombination, restriction: Restriction, lighting: Sequence[Lighting]) -> PlanCombination:
    if restriction.lighting is None:
        return one
    new = {light.id for light in restriction.lighting if isinstance(light, Lighting)}
    known = {name for name in restriction.lighting if isinstance(name, str)} & set(one.lighting)
    return one.model_copy(update={"lighting": tuple(light.id for light in lighting if light.id in new | known)})


def _known(plan: RuntimePlan, restriction: Restriction) -> None:
    """Raise unless the plan has every name: a misspelt one would silently leave all or nothing."""
    values: dict[str, set[str]] = {}
    assets: dict[str, set[str]] = {}
    for one in plan.combinations:
        for key, value in one.combination.items():
            values.setdefault(key, set()).add(value)
        for thing in one.things:
            assets.setdefault(thing.id, set()).update(plan.bodies[body].asset_id for body in thing.bodies)
    _all_in("choice", restriction.choices, values)
    _all_in("thing", restriction.assets, assets)
    _each_in("material", restriction.materials or (), {material.id for material in plan.materials})
    named = [light for light in restriction.lighting or () if isinstance(light, str)]
    _each_in("lighting", named, {light.id for light in plan.lighting})
    if restriction.split is not None and not plan.split:
        raise InvalidInput(finding("plan/unknown-choice", "the plan has no split of its assets"))


def _all_in(kind: str, asked: Mapping[str, Sequence[str]], known: Mapping[str, set[str]]) -> None:
    _each_in(kind, tuple(asked), set(known))
    for key, names in asked.items():
        _each_in(f"value of {key}", names, known[key])


def _each_in(kind: str, asked: Sequence[str], known: set[str]) -> None:
    for name in asked:
        if name not in known:
            has = ", ".join(f"`{one}`" for one in sorted(known)) or "none"
            raise InvalidInput(finding("plan/unknown-choice", f"the plan has no {kind} `{name}`; it has {has}"))
