"""PyBullet as the engine of the sim gap (`simgap.case.ReplayEngine`): roll-outs of bodies, linkages and mechanisms."""

from __future__ import annotations

from sim.bullet import mechanism
from sim.bullet.body import BulletBodyRollout
from sim.bullet.linkage import BulletLinkageRollout
from sim.bullet.windows import BODY_STEP_S


class BulletReplayEngine:
    """Makes the roll-outs; holds no state of its own. `largest_step_s` is the step of a search."""

    largest_step_s = BODY_STEP_S
    mechanism_rollout = staticmethod(mechanism.rollout)

    def body_rollout(self, step_s: float) -> BulletBodyRollout:
        """Roll-outs of one free rigid body with steps of at most `step_s`; the caller closes them."""
        return BulletBodyRollout(step_s)

    def linkage_rollout(self, step_s: float) -> BulletLinkageRollout:
        """Roll-outs of a free linkage of bodies and joints with steps of at most `step_s`; the caller closes them."""
        return BulletLinkageRollout(step_s)
