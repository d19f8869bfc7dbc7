"""What may be put into recordings: the things of a plan, or packages and their stable poses."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from replay.insertion.candidates import VariantChoices, from_bodies, from_plan
from runtime_plan import load
from scenec.bind.asset_library import AssetLibrary
from scenec.plan.document import PlanBodies
from schemas.diagnostics import InvalidInput, finding
from schemas.scene.program import FixedAsset

Draw = Callable[[int, int], VariantChoices]


def candidates(plan: Path | None, assets: Path | None) -> tuple[Draw, list[str]]:
    """What variant `number` of `seed` tries, and which packages are left out and why.

    Raises InvalidInput: `replay/no-candidates`, or as `runtime_plan.read_plan`.
    """
    if plan is not None:
        return partial(from_plan, load(plan, assets)), []
    library, bodies = AssetLibrary(assets), PlanBodies(assets)
    refused: list[str] = []
    for name in library.names:
        try:
            bodies.number(library.body(FixedAsset(type="fixed", id=name), orientation="stable"))
        except InvalidInput as error:
            refused.append(error.diagnostic.headline)
    if not bodies.plan_bodies:
        said = refused[0] if refused else "no --plan, and no package below --assets"
        raise InvalidInput(finding("replay/no-candidates", said))
    return partial(from_bodies, bodies.plan_bodies), refused
