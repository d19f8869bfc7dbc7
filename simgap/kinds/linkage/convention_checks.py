"""Convention checks of an engine with jointed bodies: conserved momentum and energy, joint inertia and damping.

The declared masses, centres and tensors give mass centre, angular momentum and energy of the simulated motion. An
engine that holds other numbers, brakes joints or has other frames does not keep them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.report import ConventionCheck
from sim.dynamics.hooks import Series
from simgap.kinds.linkage.apply_model import AppliedLinkage
from simgap.kinds.linkage.toss import LinkageToss
from simgap.kinds.linkage.tossed_body import LinkageSimulator
from simgap.sanity.convention_checks import held

_STAMPS, _ROLLOUT_S = 201, 0.2


def linkage_engine_checks(simulator: LinkageSimulator) -> tuple[ConventionCheck, ...]:
    """A flight without gravity or joint friction, every joint turning: what should stay and how much it changes."""
    declared, joints = simulator.declared, len(simulator.declared.joints.tree)
    free = replace(declared.joints, friction=np.zeros(joints), damping=np.zeros(joints), limits=None)
    base = replace(declared.base, gravity_W=np.zeros(3), has_support=False)
    bare = replace(declared, base=base, joints=free)
    applied = AppliedLinkage(replace(base, mass_kg=declared.mass_kg), (), (), bare, ())
    t_s = np.linspace(0.0, _ROLLOUT_S, _STAMPS)
    start = {
        "p": np.zeros((1, 3)),
        "quat_wxyz": np.array([[1.0, 0.0, 0.0, 0.0]]),
        "v_W": np.zeros((1, 3)),
        "w_B": np.array([[2.0, -3.0, 1.0]]),
        "q": np.zeros((1, joints)),
        "qd": np.full((1, joints), 3.0),
    }
    motion = simulator.rollout(applied, t_s[None], start, 1.0)
    toss = LinkageToss(applied, Series(t_s, {name: values[0] for name, values in motion.items()}))
    drift, spin, energy = _kept(toss)
    return (
        held("linkage_masses_held", drift, "wander of the mass centre over the links' own moves"),
        held("linkage_inertia_held", spin, "change of the angular momentum of a free flight"),
        held("joint_motor_and_damping_off", energy, "energy that free joints lose or gain in 0.2 s"),
    )


def _kept(toss: LinkageToss) -> tuple[float, float, float]:
    """Shares by which mass centre, angular momentum and kinetic energy do not stay."""
    h = float(toss.t_s[1] - toss.t_s[0])
    inner, momentum, energy = slice(1, -1), np.zeros((len(toss.t_s) - 2, 3)), np.zeros(len(toss.t_s) - 2)
    for body, R, centre, w in zip(
        toss.bodies, toss.rotations, toss.centres, toss.turning(slice(0, len(toss.t_s))), strict=True
    ):
        v = (centre[2:] - centre[:-2]) / (2.0 * h)
        spin = np.einsum("nab,bc,ndc,nd->na", R[inner], body.inertia_B, R[inner], w)
        momentum += spin + body.mass_kg * np.cross(centre[inner], v)
        energy += 0.5 * (body.mass_kg * (v**2).sum(axis=1) + (spin * w).sum(axis=1))
    moves = max(float(np.ptp(c, axis=0).max()) for c in toss.centres)
    line = np.polynomial.polynomial.polyfit(toss.t_s, toss.com, 1)
    wander = np.abs(toss.com - (line[0] + toss.t_s[:, None] * line[1])).max()
    return float(wander) / max(moves, 1e-12), _change(momentum), _change(energy[:, None])


def _change(values: FloatArray) -> float:
    """Greatest departure from the first row, over its size."""
    return float(np.linalg.norm(values - values[0], axis=1).max() / max(np.linalg.norm(values[0]), 1e-300))
