"""Part of acceptance: what the released body offers.

Grasps are proposed on its colliders in its stable poses and tried; regions come from the solid, the anchors that hold
and the named parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.affordances.grasp_trials import TRIED, try_grasps
from assetkit.affordances.grasps import propose_grasps
from assetkit.affordances.named_regions import part_at
from assetkit.affordances.regions import find_regions, keep_upright
from assetkit.stage import Draft, need
from schemas.affordances import AffordanceEvidence, Grasp, Region
from schemas.anchors import Anchor
from schemas.asset import StablePose
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence
from schemas.physics import RigidBody
from sim.port import Simulator

# A grasp takes a rim or a bar when its middle lies this near to the line of it, and it is about as wide.
ON_RIM_M, NEAR = 0.02, 1.5


@dataclass(frozen=True)
class Offered:
    """Grasps, the best first, then regions; and what is to be told."""

    affordances: tuple[AffordanceEvidence, ...]
    diagnostics: tuple[Diagnostic, ...] = ()


def find_affordances(
    draft: Draft,
    body: RigidBody,
    poses: Sequence[StablePose],
    anchors: Sequence[Evidence[Anchor]],
    simulator: Simulator,
    *,
    sound: bool = True,
    tried: int = TRIED,
) -> Offered:
    """What the object of a draft offers with the `body` of its package, its stable `poses` and the `anchors` that hold.

    No grasp of a body that is not `sound` in simulation: it would be held by what is not there.
    """
    canonical, interaction = need(draft.canonicalize, "canonicalize"), need(draft.interaction, "interaction")
    regions = find_regions(canonical.solid, anchors, interaction.parts)
    if not sound:
        return Offered(regions)
    if (fixed := _fixed(draft)) is not None:
        return Offered(regions, (finding("asset/no-grasp", fixed),))
    proposed = propose_grasps(body, poses)
    if not proposed.grasps:
        return Offered(regions, (finding("asset/no-grasp", proposed.reason),))
    upright = keep_upright(anchors)
    grasps = [
        g.model_copy(update={"orientation": upright, "part": part_at(interaction.parts, g.contacts_m)})
        for g in proposed.grasps
    ]
    known = try_grasps(grasps, body, poses, simulator, most=tried)
    return Offered((*known, *(taken_by(e, known) for e in regions)), told(known))


def taken_by(region: Evidence[Region], grasps: Sequence[Evidence[Grasp]]) -> Evidence[Region]:
    """A rim or handle with the grasps, not refuted ones, whose pads close on it."""
    if region.value.kind not in ("rim", "handle"):
        return region
    line = np.array(region.value.outline_m)
    near = [
        g.value.affordance_id
        for g in grasps
        if g.value.trial != "not_held"
        and g.value.width_m <= NEAR * max(region.value.size_m, ON_RIM_M)
        and float(np.linalg.norm(line - np.mean(g.value.contacts_m, axis=0), axis=1).min()) <= ON_RIM_M
    ]
    return region.model_copy(update={"value": region.value.model_copy(update={"held_by": tuple(near)})})


def _fixed(draft: Draft) -> str | None:
    """Why a thing is not to be picked up, in words: its usual role is to stay where it is."""
    roles = need(draft.semantics, "semantics").section.roles
    if roles and roles[0].value == "fixture" and roles[0].confidence > 0.5:
        return "a fixture stays where it is"
    return None


def told(tried: Sequence[Evidence[Grasp]]) -> tuple[Diagnostic, ...]:
    """What is to be said of grasps that were tried."""
    refuted = [e.value.affordance_id for e in tried if e.value.trial == "not_held"]
    held = sum(e.value.trial == "held" for e in tried)
    if not refuted:
        return ()
    headline = f"{', '.join(refuted)} not held in simulation, {held} held"
    return (finding("asset/grasp-not-held", headline, value=len(refuted), bound=0, unit="grasps"),)
