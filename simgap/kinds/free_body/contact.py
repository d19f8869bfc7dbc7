"""Direct estimates from contact: impulses of impacts, forces while sliding, height at rest.

The force on the body is its mass times what gravity does not explain; mass cancels everywhere.
"""

from __future__ import annotations

import numpy as np

from geom.convex.support_function import support
from simgap.kinds.free_body.normal_equations import NormalEquations, of_rows, of_values
from simgap.kinds.free_body.toss import Impact, Toss, resting_facet

_CONSISTENT = 0.25  # share of an impulse's moment that may not turn the body the way it should
_KEEPS = 0.25  # share of the slip that is left after an impact in which friction was at its limit
_HARD = 0.3  # share of sqrt(g * length) at which an impact is worth reading


def friction(toss: Toss) -> NormalEquations | None:
    """mu: tangential over normal force while sliding, and over impacts through which the corner kept slipping."""
    slides = [s.ratio for s in toss.slides]
    ratios = [r for i in _corners(toss) if (r := _slip_ratio(toss, i)) is not None]
    return of_values(np.array(slides if len(slides) >= 4 else [*slides, *ratios]))


def anisotropy(toss: Toss) -> NormalEquations | None:
    """ratio of friction along the body's x axis, with the friction along the others left open.

    For each slide the force against the slip is mu (1 + (ratio - 1) x^2), x the slip's share along that axis.
    """
    if len(toss.slides) < 2 or toss.body.friction <= 0.0:
        return None
    mu = toss.body.friction
    x2 = np.array([s.direction_B[0] ** 2 for s in toss.slides])
    seen = np.array([s.ratio for s in toss.slides]) / mu
    return of_rows(np.stack([x2, np.ones(len(x2))], axis=1), seen - 1.0, np.array([1.0, 1.0]))


def restitution(toss: Toss) -> NormalEquations | None:
    """The corner's speed away from the support over its speed towards it."""
    bounces = []
    for i in _corners(toss):
        towards = -(i.before.v + np.cross(i.before.w, i.lever))[2]
        away = (i.after.v + np.cross(i.after.w, i.lever))[2]
        if towards > _hard(toss):
            bounces.append(away / towards)
    return of_values(np.clip(np.array(bounces), -0.5, 1.5))


def inertia(toss: Toss) -> NormalEquations | None:
    """factor: an impulse's moment about the mass centre over the change of angular momentum that it made.

    Where along an edge an impulse acts is not known: there the moment about the edge counts alone.
    """
    H, g = 0.0, 0.0
    for i in toss.impacts:
        impulse = i.after.v - i.before.v
        moment = toss.body.mass_kg * np.cross(i.lever, impulse)
        inertia_before, inertia_after = (m.R @ toss.body.inertia_B @ m.R.T for m in (i.before, i.after))
        turned = inertia_after @ i.after.w - inertia_before @ i.before.w
        if i.edge is not None:
            moment, turned = i.edge * float(i.edge @ moment), i.edge * float(i.edge @ turned)
        share = float(moment @ turned) / max(float(turned @ turned), 1e-300)
        off = np.linalg.norm(moment - share * turned) / max(float(np.linalg.norm(moment)), 1e-300)
        if i.clear and impulse[2] > _hard(toss) and off < _CONSISTENT:
            size = float(turned @ turned)
            H, g = H + size, g + size * (share - 1.0)
    return NormalEquations(np.array([[H]]), np.array([g]), np.ones(1)) if H > 0.0 else None


def size(toss: Toss) -> NormalEquations | None:
    """factor: height of the origin at rest over the distance of the facet it rests on."""
    facet = resting_facet(toss)
    if facet is None or toss.rest is None:
        return None
    reach = float(support(toss.body.shapes, facet[None])[0])
    return of_values(toss.origin[toss.rest, 2] / reach, 1.0) if reach > 0.1 * toss.size else None


def _corners(toss: Toss) -> list[Impact]:
    return [i for i in toss.impacts if i.edge is None]


def _slip_ratio(toss: Toss, i: Impact) -> float | None:
    impulse = i.after.v - i.before.v
    before, after = ((m.v + np.cross(m.w, i.lever))[:2] for m in (i.before, i.after))
    speed = float(np.linalg.norm(before))
    direction_kept = float(before @ after) / max(speed, 1e-300) > _KEEPS * speed and speed > _hard(toss)
    return float(np.linalg.norm(impulse[:2]) / impulse[2]) if direction_kept and impulse[2] > _hard(toss) else None


def _hard(toss: Toss) -> float:
    return _HARD * float(np.sqrt(np.linalg.norm(toss.gravity) * toss.size))
