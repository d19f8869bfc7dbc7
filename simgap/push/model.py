"""What a pushed body is: a limit surface under it, an outline around it, a pusher that touches it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from schemas.model import FloatArray
from sim.body_replay import BodyModel
from sim.effects.effect import Numbers
from simgap.problem import Model

PUSHER = "body-pusher"
SUPPORT = "body-support"


@dataclass(frozen=True)
class PushModel:
    """`body` with its numbers; outline (k, 2) and evenly loaded points (p, 2) under it in body axes, m.

    pusher_friction   of the pair body-pusher.
    standoff_m        distance of the tip's recorded point from the outline in contact: the tip's radius.
    """

    body: BodyModel
    outline: FloatArray
    points: FloatArray
    pusher_friction: float
    standoff_m: float

    @property
    def weight_N(self) -> float:
        """Load on the support."""
        return self.body.mass_kg * float(np.linalg.norm(self.body.gravity_W))

    @property
    def lever_m(self) -> float:
        """Largest moment over largest force: as the pair's spinning friction says, else that of an even pressure."""
        if self.body.spinning_friction_m > 0.0:
            return self.body.spinning_friction_m / max(self.body.friction, 1e-6)
        return float(np.linalg.norm(self.points - self.body.com_B[:2], axis=1).mean())

    @property
    def axes(self) -> FloatArray:
        """(3,) semi-axes of the limit surface over the largest force: along x, along y (1 each if isotropic), and m.

        An ellipsoid in force and moment about the mass centre (Howe and Cutkosky, IJRR 15(6), 1996).
        """
        return np.array([*self.body.friction_ratio_B[:2], self.lever_m])

    @property
    def largest_N(self) -> float:
        """Friction of a body that slides without turning, across its x axis."""
        return self.body.friction * self.weight_N


def changed(declared: PushModel, model: Model) -> PushModel:
    """`declared` with the terms of `model` in their order. Raises ValueError for effects that do not act on pushes."""
    for term in model:
        hook, where = term.candidate.effect.hook, term.candidate.where
        if where.pair == PUSHER:
            declared = replace(declared, pusher_friction=term.values["mu"])
        elif isinstance(hook, Numbers):
            declared = replace(declared, body=hook.change(declared.body, term.values, where))
        else:
            raise ValueError(f"{term.candidate.effect.name} does not act on pushes")
    return declared
