"""The closed table of repairs: which failure leads to which bounded edit, and from which stage on it is tried.

An edit never loosens a bound; it changes the package, within what its evidence allows. Edits accumulate and are never
taken back, so that no state comes twice. A repair is one row.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from assetkit.acceptance.suites.policy import POLICY
from assetkit.colliders.choose import CUTS_FINE, METHODS
from assetkit.stage import Draft, Edits
from schemas.affordances import Grasp

# Findings that another collider may cure.
COLLIDER_FAILURES = frozenset(
    {
        "asset/render-collision-misaligned",
        "asset/gate-collider-displaced",
        "asset/unstable-settling",
        "asset/slope-astray",
        "asset/handling-pushed",
        "asset/handling-not-released",
    }
)
# Findings that colliders with smaller gaps may cure: things fall between two hulls of a vessel, or hulls fill it.
GAP_FAILURES = frozenset({"asset/receptacle-tunnel", "asset/receptacle-leaves", "asset/receptacle-no-volume"})
# Findings that another place to grasp at may cure.
GRASP_FAILURES = frozenset(
    {"asset/handling-lost", "asset/handling-slip", "asset/handling-landing", "asset/handling-pushed"}
)
# Findings that more friction may cure.
FRICTION_FAILURES = frozenset({"asset/handling-lost", "asset/handling-slip"})
MORE_GRASPS = 8
LEAST_GAIN = 1.05  # times the friction before: less changes nothing


@dataclass(frozen=True)
class RepairRule:
    """One repair: the failures that it answers, the stage to begin with, and the next edit of a draft; None where
    nothing is left to try.
    """

    name: str
    failures: frozenset[str]
    first_stage: str
    edit: Callable[[Draft], Edits | None]


def another_collider(draft: Draft) -> Edits | None:
    """The method that made the colliders is left out; of a mechanism each link has its own."""
    if draft.physics is None or draft.physics.links:
        return None
    failed = draft.physics.section.collision_method
    if failed in draft.edits.excluded_colliders:
        return None
    return replace(draft.edits, excluded_colliders=(*draft.edits.excluded_colliders, failed))


def finer_collider(draft: Draft) -> Edits | None:
    """The finest decomposition, twice as many hulls, in place of what was chosen, once; where the surface has a volume
    to hold things in.
    """
    if draft.physics is None or draft.physics.links or draft.physics.section.collision_method == CUTS_FINE:
        return None
    if draft.interaction is None or all(anchor.kind != "volume" for anchor in draft.interaction.anchors):
        return None
    coarser = tuple(method for method in METHODS if method != CUTS_FINE)
    return None if CUTS_FINE in draft.edits.excluded_colliders else replace(draft.edits, excluded_colliders=coarser)


def more_grasps(draft: Draft) -> Edits | None:
    """More of the proposed grasps are tried, if there are some."""
    if draft.acceptance is None or draft.edits.tried_grasps >= MORE_GRASPS:
        return None
    grasps = [e.value for e in draft.acceptance.affordances if isinstance(e.value, Grasp)]
    untried = sum(grasp.trial == "untried" for grasp in grasps)
    return replace(draft.edits, tried_grasps=MORE_GRASPS) if untried and len(grasps) > POLICY.tries else None


def friction_within_bounds(draft: Draft) -> Edits | None:
    """Friction that was inferred goes half of the way (as a ratio) to its upper bound, once."""
    if draft.physics is None or draft.edits.friction_gain != 1.0:
        return None
    if draft.physics.links or draft.physics.surfaces:  # Several materials have their bounds each.
        return None
    contact = draft.physics.section.contacts[0]
    if contact.source == "declared" or contact.bounds is None or contact.value.dynamic_friction <= 0.0:
        return None
    gain = math.sqrt(contact.bounds[1].dynamic_friction / contact.value.dynamic_friction)
    return replace(draft.edits, friction_gain=gain) if gain >= LEAST_GAIN else None


# In the order in which they are tried.
REPAIRS = (
    RepairRule("another_collider", COLLIDER_FAILURES, "physics", another_collider),
    RepairRule("finer_collider", GAP_FAILURES, "physics", finer_collider),
    RepairRule("more_grasps", GRASP_FAILURES, "acceptance", more_grasps),
    RepairRule("friction_within_bounds", FRICTION_FAILURES, "physics", friction_within_bounds),
)
