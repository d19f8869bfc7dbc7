"""PyBullet as the engine of the sim gap (`simgap.case.ReplayEngine`): roll-outs of bodies, linkages and mechanisms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from importlib.metadata import version

from schemas.arrays import FloatArray
from sim.bullet import mechanism
from sim.bullet.body import BulletBodyRollout
from sim.bullet.linkage import BulletLinkageRollout
from sim.bullet.windows import BODY_STEP_S
from sim.dynamics.mechanism import Law, MechanismModel, Windows


class BulletReplayEngine:
    """Makes the roll-outs; holds no state of its own. `largest_step_s` is the step of a search."""

    name = f"PyBullet {version('pybullet')}"
    largest_step_s = BODY_STEP_S
    mechanism_rollout = staticmethod(mechanism.rollout)

    def mechanism_rollout_at(
        self, step_s: float
    ) -> Callable[[MechanismModel, Windows, Sequence[Law]], tuple[FloatArray, FloatArray]]:
        """Roll-outs of mechanisms with steps of at most `step_s`."""
        return partial(mechanism.rollout, largest_step_s=step_s)

    def body_rollout(self, step_s: float) -> BulletBodyRollout:
        """Roll-outs of one free rigid body with steps of at most `step_s`; the caller closes them."""
        return BulletBodyRollout(step_s)

    def linkage_rollout(self, step_s: float) -> BulletLinkageRollout:
        """Roll-outs of a free linkage of bodies and joints with steps of at most `step_s`; the caller closes them."""
        return BulletLinkageRollout(step_s)
