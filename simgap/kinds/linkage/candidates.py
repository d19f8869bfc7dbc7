"""Candidate effects of a tossed linkage by link and joint, with bounds from its motion and direct estimates; SI."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import Series
from sim.dynamics.linkage_rollout import LinkageModel, link_body
from sim.effects.effect import Effect
from sim.effects.library import EFFECTS
from sim.effects.ranges import SUPPORT_PAIR, DeclaredJoint, LinkageJoint, TossRanges
from simgap.kinds.free_body.candidates import screened, toss_candidate, typical_speed
from simgap.kinds.free_body.toss import corners
from simgap.kinds.free_body.tossed_body import DirectEstimator
from simgap.kinds.linkage.apply_model import WHOLE
from simgap.problem import Candidate

_BY_FAMILY = {"contact": "pair", "body": "link", "joint": "joint"}
_SLIDE_M = 0.05  # half of the travel of a sliding joint


def candidates_of(
    model: LinkageModel, series: Sequence[Series], estimate_directly: DirectEstimator
) -> tuple[Candidate, ...]:
    """Every effect of the library that poses and joints of a linkage can reveal, in library order.

    As for single bodies, an effect whose direct estimate is clearly zero is left out.
    """
    speed = typical_speed(series, size_m_of(model), model.base.gravity_W)
    return tuple(
        candidate
        for each in EFFECTS
        if "free_body" in each.kinds
        for where, ranges in _places(each, model, speed)
        if each.free_body.observable(ranges)
        for candidate in screened(toss_candidate(each, where, ranges), estimate_directly)
    )


def size_m_of(model: LinkageModel) -> float:
    """Greatest extent of the shapes of any link."""
    return max(float(np.ptp(corners(s), axis=0).max()) for s in (model.base.shapes, *model.shapes) if s)


def _places(each: Effect, model: LinkageModel, speed: float) -> Iterator[tuple[Place, TossRanges]]:
    """Where the effect may act, and what is declared there."""
    whole = TossRanges(replace(model.base, mass_kg=model.mass_kg), speed, linked=True)
    acts_on = each.free_body.acts_on or _BY_FAMILY.get(each.family, "log")
    if acts_on == "link":
        for k, name in enumerate(model.names):
            yield Place(body=name), replace(whole, body=link_body(model, name), base=k == 0)
    elif acts_on == "joint":
        for j, link in enumerate(model.joints.tree):
            yield Place(joint=link.name), replace(whole, joint=_joint(model, j, whole.weight_N))
    else:
        yield {"pair": Place(pair=SUPPORT_PAIR), "linkage": Place(body=WHOLE)}.get(acts_on, Place()), whole


def _joint(model: LinkageModel, j: int, weight_N: float) -> LinkageJoint:
    link = model.joints.tree[j]
    reach = 1.0 if link.prismatic else float(np.linalg.norm(link.X_PJ[:3, 3]) + np.linalg.norm(link.com_J))
    declared = DeclaredJoint(model.joints, j, row_s=0.0)
    return LinkageJoint(declared, weight_N, reach, _SLIDE_M if link.prismatic else np.pi)
