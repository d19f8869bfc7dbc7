"""Model of a pushed body: limit surface of its support, convex outline, contact with the pusher; SI."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange
from sim.effects.ranges import PUSHER_PAIR
from simgap.problem import Model

_CENTRES = (0.5, 0.75, 1.0, 1.5, 2.0, 3.0)  # distances of the centre of rotation over the mean distance of the load


@dataclass(frozen=True)
class PushModel:
    """`body` with its numbers; outline (k, 2) and evenly loaded points (p, 2) under it in body axes, m.

    pusher_friction   of the pair body-pusher.
    reference_friction   at which spinning friction is stated: the pair's moment grows with its force.
    standoff_m        distance of the tip's recorded point from the outline in contact: the tip's radius.
    """

    body: BodyModel
    outline: FloatArray
    points: FloatArray
    pusher_friction: float
    reference_friction: float
    standoff_m: float

    @property
    def weight_N(self) -> float:
        """Load on the support."""
        return self.body.mass_kg * float(np.linalg.norm(self.body.gravity_W))

    @cached_property
    def lever_m(self) -> float:
        """Moment over force on the limit surface: from spinning friction, else that of an even pressure."""
        if self.body.spinning_friction_m > 0.0:
            return self.body.spinning_friction_m / self.reference_friction
        return even_lever(self.points - self.body.com_B[:2])

    @cached_property
    def axes(self) -> FloatArray:
        """(3,) semi-axes of the limit surface over the largest force: along x, along y (1 each if isotropic), and m.

        An ellipsoid in force and moment about the mass centre (Howe and Cutkosky, IJRR 15(6), 1996).
        """
        return np.array([*self.body.friction_ratio_B[:2], self.lever_m])

    @property
    def largest_N(self) -> float:
        """Friction of a body that slides without turning, across its x axis."""
        return self.body.friction * self.weight_N


def even_lever(arms: FloatArray) -> float:
    """m: lever of the ellipsoid that turns a body best as points at `arms` (p, 2) from its mass centre, equally loaded.

    The true limit surface of many points is no ellipsoid: at its tip, pure spin, the lever is their mean distance, but
    pushed bodies slide and turn. The lever is matched there, over centres of rotation near and far.
    """
    mean = float(np.linalg.norm(arms, axis=1).mean())
    ways = np.arange(8) * np.pi / 4.0
    u = np.stack([np.cos(ways), np.sin(ways)], axis=1)
    v = (mean * np.array(_CENTRES))[:, None, None] * u  # of the mass centre, at a turn of 1
    slip = v.reshape(-1, 1, 2) + np.stack([-arms[:, 1], arms[:, 0]], axis=1)
    pull = slip / np.maximum(np.linalg.norm(slip, axis=2, keepdims=True), 1e-12)
    force = pull.mean(axis=1)
    moment = (arms[:, 0] * pull[..., 1] - arms[:, 1] * pull[..., 0]).mean(axis=1)
    squared = moment * (v.reshape(-1, 2) * force).sum(axis=1) / (force**2).sum(axis=1)
    return float(np.sqrt(np.median(np.maximum(squared, 0.0))))


def changed(declared: PushModel, model: Model) -> PushModel:
    """`declared` with the terms of `model` in their order. Raises ValueError for effects that do not act on pushes."""
    for term in model:
        hook, where = term.candidate.effect.hook, term.candidate.where
        if where.pair == PUSHER_PAIR:
            declared = replace(declared, pusher_friction=term.values["mu"])
        elif isinstance(hook, ModelChange):
            declared = replace(declared, body=hook.change(declared.body, term.values, where))
        else:
            raise ValueError(f"{term.candidate.effect.name} does not act on pushes")
    return declared
