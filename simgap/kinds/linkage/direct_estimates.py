"""Direct estimates for a linkage without an engine, mostly from momenta of its free flights.

Joints act inside: they move neither the mass centre of the whole nor its angular momentum, whatever their friction.
What they transmit is the change of momentum of the links beyond them, about the joint (Newton, Euler).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place
from simgap.kinds.free_body.direct_estimates import ESTIMATORS, Estimator, Routes
from simgap.kinds.free_body.normal_equations import NormalEquations, of_rows, of_values
from simgap.kinds.free_body.toss import Toss
from simgap.kinds.linkage.toss import LinkageToss
from simgap.problem import Candidate

LinkedEstimator = Callable[[Toss, Place], NormalEquations | None]
# Shares of the fall time, and the fewest rows: of a window over which accelerations are read, of a flight for momenta.
_EFFORT_WINDOW, _MOMENTA_FLIGHT = (0.67, 11), (0.53, 9)
_STILL = 0.05  # rad per fall time (sizes of the linkage): a joint that moves slower has no sure direction


# By what they read, at which place; `TossCandidacy.linked_direct` of an effect names them.
LINKED_ESTIMATORS: Mapping[str, LinkedEstimator] = {
    "rates_behind_common_path": lambda toss, where: velocity_age(toss),
    "mass_of_link": lambda toss, where: mass(_linkage(toss), _link(toss, where.body)),
    "wobble_of_link": lambda toss, where: com_offset(_linkage(toss), _link(toss, where.body)),
    "spin_of_link": lambda toss, where: inertia(_linkage(toss), _link(toss, where.body)),
    "viscous_effort": lambda toss, where: _joint(toss, where.joint, _viscous),
    "dry_effort": lambda toss, where: _joint(toss, where.joint, _dry),
}


def routes_to(candidate: Candidate) -> Routes:
    """The estimators for a candidate at its link or joint; those of falls and slides are those of a single body."""
    return tuple(
        ESTIMATORS[name] if name in ESTIMATORS else _at(candidate.where, LINKED_ESTIMATORS[name])
        for name in candidate.effect.free_body.linked_direct
    )


def _at(where: Place, estimator: LinkedEstimator) -> Estimator:
    return lambda toss: estimator(toss, where)


def velocity_age(toss: Toss) -> NormalEquations | None:
    """age_s: how far the reported rates of the mass centre of the whole lag behind its path, in flight."""
    linkage, ages = _linkage(toss), []
    for part in _flights(linkage):
        t = toss.t_s[part] - toss.t_s[part].mean()
        c = np.polynomial.polynomial.polyfit(t, toss.com[part], 2)
        behind = c[1] + 2.0 * t[:, None] * c[2] - reported_velocity(linkage, part)
        acceleration = 2.0 * c[2]
        ages.append(float(behind.mean(axis=0) @ acceleration / (acceleration @ acceleration)))
    return of_values(np.array(ages))


def reported_velocity(toss: LinkageToss, rows: slice) -> FloatArray:
    """(n, 3) of the mass centre of the whole, from the reported rates."""
    columns, model = toss.series.columns, toss.linkage
    v = toss.support_rotation.apply(columns["v_W"][rows])
    spin = np.einsum("nab,nb->na", toss.matrices[rows], columns["w_B"][rows])
    total, mass = np.zeros_like(v), 0.0
    for k, (body, centre) in enumerate(zip(toss.bodies, toss.centres, strict=True)):
        here = v + np.cross(spin, centre[rows] - toss.origin[rows])
        link = k - 1
        while link >= 0:  # every joint between this link and the base
            one = model.joints.tree[link]
            axis = toss.rotations[link + 1][rows] @ one.axis_J
            rate = columns["qd"][rows, link, None]
            arm = centre[rows] - toss.frames[link + 1][rows]
            here = here + rate * (axis if one.prismatic else np.cross(axis, arm))
            link = one.parent
        total, mass = total + body.mass_kg * here, mass + body.mass_kg
    return total / mass


def mass(toss: LinkageToss, k: int) -> NormalEquations | None:
    """mass_kg of link k beside the others: with the right one the mass centre of the whole does not wobble."""
    link_mass_kg = toss.bodies[k].mass_kg
    total = sum(b.mass_kg for b in toss.bodies)
    H, g = 0.0, 0.0
    for part in _flights(toss):
        basis = _quadratic(toss.t_s[part])
        wobble, whole = (_without(basis, v[part]).ravel() for v in (toss.centres[k], total * toss.com))
        H, g = H + float(wobble @ wobble), g - float(wobble @ whole)
    return NormalEquations(np.array([[H]]), np.array([g]), np.array([link_mass_kg])) if H > 0.0 else None


def com_offset(toss: LinkageToss, k: int) -> NormalEquations | None:
    """x_m, y_m, z_m of link k."""
    share = toss.bodies[k].mass_kg / sum(b.mass_kg for b in toss.bodies)
    H, g = np.zeros((3, 3)), np.zeros(3)
    for part in _flights(toss):
        basis = _quadratic(toss.t_s[part])
        axes = -share * toss.rotations[k][part]
        wobble = np.stack([_without(basis, axes[:, :, a]).ravel() for a in range(3)], axis=1)
        H += wobble.T @ wobble
        g += wobble.T @ _without(basis, toss.com[part]).ravel()
    return NormalEquations(H, g, toss.bodies[k].com_B) if H.any() else None


def inertia(toss: LinkageToss, k: int) -> NormalEquations | None:
    """factor of link k: with the right one the angular momentum of the whole stays.

    Rates at a row are read from the rows beside it; the instrument is their mean at the rows beside, which those rows
    do not share: noise does not weigh in the square (instrumental variables, Reiersol 1941).
    """
    H, g = 0.0, 0.0
    for part in _flights(toss):
        own, whole = (v - v.mean(axis=0) for v in _momenta(toss, part, k))
        beside = 0.5 * (own[2:] + own[:-2])
        H, g = H + float((beside * own[1:-1]).sum()), g - float((beside * whole[1:-1]).sum())
    return NormalEquations(np.array([[H]]), np.array([g]), np.ones(1)) if H > 0.0 else None


def _momenta(toss: LinkageToss, part: slice, k: int) -> tuple[FloatArray, FloatArray]:
    """Spin of link k and angular momentum of the whole (n - 2, 3) each, at the inner rows."""
    t, total, link_spin = toss.t_s[part], np.zeros((part.stop - part.start - 2, 3)), np.zeros(0)
    spans = (t[2:] - t[:-2])[:, None]
    for i, (body, w) in enumerate(zip(toss.bodies, toss.turning(part), strict=True)):
        R = toss.rotations[i][part][1:-1]
        spin = np.einsum("nab,bc,ndc,nd->na", R, body.inertia_B, R, w)
        r = (toss.centres[i] - toss.com)[part]
        total += spin + body.mass_kg * np.cross(r[1:-1], (r[2:] - r[:-2]) / spans)
        link_spin = spin if i == k else link_spin
    return link_spin, total


def _joint(toss: Toss, joint: str | None, law: Callable[[FloatArray], FloatArray]) -> NormalEquations | None:
    """How strongly a law (rate -> torque for strength 1) acts at a joint, beside what the model has there."""
    linkage = _linkage(toss)
    model = linkage.linkage.joints
    j = [link.name for link in model.tree].index(joint or "")
    length = toss.rows_of(*_EFFORT_WINDOW)
    rows = [slice(s, s + length) for f in toss.flights for s in range(f.start, f.stop - length + 1, length // 2)]
    still = _STILL / toss.fall_s * (toss.size if model.tree[j].prismatic else 1.0)
    known = model.damping[j] if law is _viscous else model.friction[j]
    seen = []
    for part in rows:
        rate = float(linkage.series.columns["qd"][part, j].mean())
        if abs(rate) > still:
            given = -model.damping[j] * rate - model.friction[j] * np.sign(rate)
            seen.append((rate, joint_effort(linkage, j, part) - given))
    if not seen:
        return None
    rates, left = np.array(seen).T
    return of_rows(law(rates)[:, None], left, np.array([float(known)]))


def _viscous(rate: FloatArray) -> FloatArray:
    return -rate


def _dry(rate: FloatArray) -> FloatArray:
    return -np.sign(rate)


def joint_effort(toss: LinkageToss, j: int, rows: slice) -> float:
    """Torque (N m) or force (N) that joint j gave to the links beyond it, in the middle of `rows` of a flight."""
    tree = toss.linkage.joints.tree
    beyond = {j}
    for i, link in enumerate(tree):
        beyond |= {i} if link.parent in beyond else set()
    t = toss.t_s[rows] - toss.t_s[rows].mean()
    middle = (rows.start + rows.stop) // 2
    axis, pivot = toss.rotations[j + 1][middle] @ tree[j].axis_J, toss.frames[j + 1][middle]
    force, moment = np.zeros(3), np.zeros(3)
    turning = toss.turning(rows)
    for i in beyond:
        body, k = toss.bodies[i + 1], i + 1
        push = body.mass_kg * (2.0 * np.polynomial.polynomial.polyfit(t, toss.centres[k][rows], 2)[2] - toss.gravity)
        R = toss.rotations[k][rows][1:-1]
        spin = np.einsum("nab,bc,ndc,nd->na", R, body.inertia_B, R, turning[k])
        change = np.polynomial.polynomial.polyfit(t[1:-1], spin, 1)[1]
        force += push
        moment += change + np.cross(toss.centres[k][middle] - pivot, push)
    return float(axis @ (force if tree[j].prismatic else moment))


def _flights(toss: LinkageToss) -> list[slice]:
    return [f for f in toss.flights if f.stop - f.start >= toss.rows_of(*_MOMENTA_FLIGHT)]


def _linkage(toss: Toss) -> LinkageToss:
    assert isinstance(toss, LinkageToss)
    return toss


def _link(toss: Toss, name: str | None) -> int:
    return _linkage(toss).linkage.names.index(name or "")


def _quadratic(t_s: FloatArray) -> FloatArray:
    """Orthonormal (n, 3)."""
    t = t_s - t_s.mean()
    return np.linalg.qr(np.stack([np.ones(len(t)), t, t**2], axis=1))[0]


def _without(basis: FloatArray, values: FloatArray) -> FloatArray:
    return values - basis @ (basis.T @ values)
