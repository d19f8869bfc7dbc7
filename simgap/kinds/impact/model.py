"""The declared body of an impact measurement, and its events transformed to the declared mass centre; SI."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray
from schemas.measurement import MeasurementSpec
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange
from simgap.kinds.impact.law import mobility, velocity_after
from simgap.problem import Model
from simgap.recording.recording import Impacts


def build_body(spec: MeasurementSpec) -> BodyModel:
    """Mass, inertia, mass centre and pair coefficients. Raises ValueError without the first two."""
    subject = spec.subject
    if subject.mass_kg is None or subject.inertia_kgm2 is None:
        raise ValueError("impacts need the subject's mass_kg and inertia_kgm2: they turn impulses into velocities")
    return BodyModel(
        shapes=(),
        mass_kg=subject.mass_kg,
        com_B=np.array(subject.com_m),
        inertia_B=np.diag(subject.inertia_kgm2),
        friction=subject.contact.friction,
        restitution=subject.contact.restitution,
    )


def changed(body: BodyModel, model: Model) -> BodyModel:
    """`body` with the terms of `model` in their order. Raises ValueError for effects that do not act in an impact."""
    for term in model:
        hook = term.candidate.effect.hook
        if not isinstance(hook, ModelChange):
            raise ValueError(f"{term.candidate.effect.name} does not act on impacts")
        body = hook.change(body, term.values, term.candidate.where)
    return body


def com_W(body: BodyModel, angle_rad: FloatArray) -> FloatArray:
    """(n, 2) mass centre from the tracked point, world axes; events without a pose count as not turned."""
    angle = np.nan_to_num(angle_rad)
    c, s = np.cos(angle), np.sin(angle)
    x, y = body.com_B[:2]
    return np.stack([c * x - s * y, s * x + c * y], axis=1)


def predicted(body: BodyModel, events: Impacts) -> FloatArray:
    """(n, 3) velocity of the tracked point after the impact, by the rigid law."""
    W = mobility(body.mass_kg, float(body.inertia_B[2, 2]), com_W(body, events.pose_before[:, 2]))
    return velocity_after(
        events.velocity_before, events.normal, events.tangent, W, body.friction, max(body.restitution, 0.0)
    )


@dataclass(frozen=True)
class Impulses:
    """Contact impulses from the states before and after alone, without a law of friction or restitution.

    normal, along (n,)      impulses in N s; `spin` (n,) change of angular momentum about the mass centre, N m s.
    normal_arm, along_arm   (n,) m: moment about the mass centre per impulse.
    approach, slip          (n, 2) contact velocities before and after, m/s.
    """

    normal: FloatArray
    along: FloatArray
    spin: FloatArray
    normal_arm: FloatArray
    along_arm: FloatArray
    approach: FloatArray
    slip: FloatArray

    @property
    def moment(self) -> FloatArray:
        """(n,) moment of the impulses about the mass centre, N m s."""
        return self.normal_arm * self.normal + self.along_arm * self.along


def impulses(body: BodyModel, events: Impacts) -> Impulses:
    """Momentum balance of every event."""
    c = com_W(body, events.pose_before[:, 2])
    jump = events.velocity_after - events.velocity_before
    of_com = jump[:, :2] + jump[:, 2:] * np.stack([-c[:, 1], c[:, 0]], axis=1)
    linear = body.mass_kg * of_com
    to_com = np.stack([c[:, 1], -c[:, 0]], axis=1)
    both = (events.velocity_before, events.velocity_after)
    return Impulses(
        normal=np.einsum("ni,ni->n", linear, events.normal[:, :2]),
        along=np.einsum("ni,ni->n", linear, events.tangent[:, :2]),
        spin=float(body.inertia_B[2, 2]) * jump[:, 2],
        normal_arm=events.normal[:, 2] + np.einsum("ni,ni->n", events.normal[:, :2], to_com),
        along_arm=events.tangent[:, 2] + np.einsum("ni,ni->n", events.tangent[:, :2], to_com),
        approach=np.stack([np.einsum("ni,ni->n", events.normal, v) for v in both], axis=1),
        slip=np.stack([np.einsum("ni,ni->n", events.tangent, v) for v in both], axis=1),
    )
