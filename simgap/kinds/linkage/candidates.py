"""Candidate effects of a tossed linkage by link and joint, with bounds from its motion and direct estimates; SI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.gap import Place
from schemas.physical_constants import GRAVITY_MPS2
from sim.dynamics.hooks import Effect, Series
from sim.dynamics.linkage_rollout import LinkageModel, link_body
from sim.dynamics.tree import mass_matrix
from sim.effects.library import EFFECTS
from simgap.kinds.free_body.candidates import (
    CONTACT_STEP,
    DIRECTLY_MEASURED,
    absent,
    bounds_of,
    declared_of,
    with_direct_bounds,
)
from simgap.kinds.free_body.tossed_body import DirectEstimator
from simgap.kinds.linkage.apply_model import WHOLE
from simgap.problem import Candidate

_FASTEST_S = 0.02  # joint damping may stop a joint within this
_STIFFEST_RADPS = 60.0
# Friction along an axis of which link? A single body answers that, a linkage does not.
_NOT_HERE = ("contact.anisotropic_friction", "sensor.frame_rotation")


def candidates_of(
    model: LinkageModel, series: Sequence[Series], estimate_directly: DirectEstimator
) -> tuple[Candidate, ...]:
    """Every effect of the library that poses and joints of a linkage can reveal, in library order.

    As for single bodies, an effect whose direct estimate is clearly zero is left out.
    """
    out = []
    for each in EFFECTS:
        if "free_body" not in each.kinds or each.name in _NOT_HERE:
            continue
        for where in _places(each, model):
            wide = _candidate(each, where, model, series)
            direct = estimate_directly(wide)
            if direct is None:
                out.append(wide)
            elif not absent(wide, direct):
                out.append(with_direct_bounds(wide, direct) if each.name in DIRECTLY_MEASURED else wide)
    return tuple(out)


def _places(each: Effect, model: LinkageModel) -> list[Place]:
    if each.family == "contact":
        return [Place(pair="body-support")] if model.base.has_support else []
    if each.name == "body.size":
        return [Place(body=WHOLE)] if model.base.has_support else []
    if each.family == "body":
        # The scale of all masses does not show: that of the base is believed.
        return [Place(body=name) for name in model.names[each.name == "body.mass" :]]
    if each.family == "joint" or each.name == "sensor.bias":
        return [Place(joint=link.name) for link in model.joints.tree]
    return [Place()]


def _candidate(each: Effect, where: Place, model: LinkageModel, series: Sequence[Series]) -> Candidate:
    whole = replace(model.base, mass_kg=model.mass_kg)
    body = link_body(model, where.body) if where.body in model.names else whole
    null = each.null() | declared_of(each.name, body)
    table = bounds_of(body, series) | _joint_bounds(model, where)
    if each.name == "body.mass":
        null = {"mass_kg": body.mass_kg}
        table[each.name, "mass_kg"] = (0.2 * body.mass_kg, 5.0 * body.mass_kg)
    if each.family == "joint" and where.joint is not None:
        j = [link.name for link in model.joints.tree].index(where.joint)
        joints = model.joints
        declared = {"joint.coulomb_friction": joints.friction[j], "joint.viscous_friction": joints.damping[j]}
        null |= {each.parameters[0].name: float(declared[each.name])} if each.name in declared else {}
    bounds = {p.name: table.get((each.name, p.name), (p.low, p.high)) for p in each.parameters}
    start = {n: float(np.clip(v, *bounds[n])) for n, v in null.items()}
    shapes = ("rest_rad",) if each.name == "joint.spring" else ()
    return Candidate(each, where, null, start, bounds, shapes=shapes, step=CONTACT_STEP)


def _joint_bounds(model: LinkageModel, where: Place) -> dict[tuple[str, str], tuple[float, float]]:
    """Torques up to the weight at the reach of the links; damping that stops a joint within a few milliseconds."""
    if where.joint is None:
        return {}
    tree = model.joints.tree
    j = [link.name for link in tree].index(where.joint)
    inertia = float(mass_matrix(tree, np.zeros((1, len(tree))))[0, j, j])
    weight = model.mass_kg * (float(np.linalg.norm(model.base.gravity_W)) or GRAVITY_MPS2)
    reach = 1.0 if tree[j].prismatic else float(np.linalg.norm(tree[j].X_PJ[:3, 3]) + np.linalg.norm(tree[j].com_J))
    turn = 0.05 if tree[j].prismatic else np.pi
    return {
        ("joint.coulomb_friction", "torque_Nm"): (0.0, 0.3 * weight * reach),
        ("joint.viscous_friction", "damping_Nms_per_rad"): (0.0, inertia / _FASTEST_S),
        ("joint.spring", "stiffness_Nm_per_rad"): (0.0, inertia * _STIFFEST_RADPS**2),
        ("joint.spring", "rest_rad"): (-turn, turn),
        ("sensor.bias", "offset_rad"): (-0.2 * turn, 0.2 * turn),
    }
