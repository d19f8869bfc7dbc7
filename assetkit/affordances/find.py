"""Affordances of the released body: grasps, proposed on its colliders and tried in its stable poses, and regions.

Regions come from the solid, the verified anchors and the named parts. It runs as a part of acceptance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from assetkit.affordances.grasp_trials import TRIED, try_grasps
from assetkit.affordances.grasps import propose_grasps
from assetkit.affordances.joint_regions import joint_regions
from assetkit.affordances.named_regions import part_at
from assetkit.affordances.region_grasps import takes
from assetkit.affordances.regions import find_regions, upright_requirement
from assetkit.stage import Canonical, Draft, Interaction, Semantics
from schemas.acceptance import StablePose
from schemas.affordances import AffordanceEvidence, Grasp, Region
from schemas.anchors import Anchor
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence
from schemas.physics import RigidBody
from sim.port import Simulator


@dataclass(frozen=True)
class AffordanceResult:
    """Grasps, the best first, then regions; and findings."""

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
) -> AffordanceResult:
    """The affordances of a draft, from the `body` of its package, its stable `poses` and its verified `anchors`.

    No grasp is tried on a body that is not `sound` in simulation, because its colliders do not match its surface.
    """
    canonical, interaction = draft[Canonical], draft[Interaction]
    # The handles and rims of a mechanism serve its joints; it is not carried by them, nor poured from.
    regions = (
        joint_regions(interaction.joint_uses)
        if canonical.mechanism is not None
        else find_regions(canonical.solid, anchors, interaction.parts)
    )
    if not sound:
        return AffordanceResult(regions)
    if (fixed := _fixed(draft)) is not None:
        return AffordanceResult(regions, (finding("asset/no-grasp", fixed),))
    proposed = propose_grasps(body, poses)
    if not proposed.grasps:
        return AffordanceResult(regions, (finding("asset/no-grasp", proposed.reason),))
    upright = upright_requirement(anchors)
    grasps = [
        g.model_copy(update={"orientation": upright, "part": part_at(interaction.parts, g.contacts_m)})
        for g in proposed.grasps
    ]
    known = try_grasps(grasps, body, poses, simulator, most=tried)
    return AffordanceResult((*known, *(with_grasps(e, known) for e in regions)), refuted_grasp_findings(known))


def with_grasps(region: Evidence[Region], grasps: Sequence[Evidence[Grasp]]) -> Evidence[Region]:
    """A rim or handle with the grasps, not refuted ones, whose pads close on it."""
    if region.value.kind not in ("rim", "handle"):
        return region
    near = [g.value.affordance_id for g in grasps if g.value.trial != "not_held" and takes(g.value, region.value)]
    return region.model_copy(update={"value": region.value.model_copy(update={"held_by": tuple(near)})})


def _fixed(draft: Draft) -> str | None:
    """The reason why an object is not to be picked up, in words: its usual role is that of a fixture."""
    roles = draft[Semantics].section.roles
    if roles and roles[0].value == "fixture" and roles[0].confidence > 0.5:
        return "a fixture stays where it is"
    return None


def refuted_grasp_findings(tried: Sequence[Evidence[Grasp]]) -> tuple[Diagnostic, ...]:
    """A finding on the tried grasps that were not held in simulation; () when all were held."""
    refuted = [e.value.affordance_id for e in tried if e.value.trial == "not_held"]
    held = sum(e.value.trial == "held" for e in tried)
    if not refuted:
        return ()
    headline = f"{', '.join(refuted)} not held in simulation, {held} held"
    return (finding("asset/grasp-not-held", headline, value=len(refuted), bound=0, unit="grasps"),)
