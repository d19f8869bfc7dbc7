"""PyBullet as the engine of the sim gap (`simgap.case.ReplayEngine`): replays of bodies, linkages and mechanisms."""

from __future__ import annotations

from sim.bullet import mechanism
from sim.bullet.body import BulletBodyReplay
from sim.bullet.linkage import BulletLinkageReplay
from sim.bullet.windows import LARGEST_STEP_S


class BulletReplayEngine:
    """Makes the replays; holds no state of its own. `largest_step_s` is the step at which a search rolls out bodies."""

    largest_step_s = LARGEST_STEP_S
    mechanism_rollout = staticmethod(mechanism.rollout)

    def body_replay(self, step_s: float) -> BulletBodyReplay:
        """A replay of one free rigid body with steps of at most `step_s`; the caller closes it."""
        return BulletBodyReplay(step_s)

    def linkage_replay(self, step_s: float) -> BulletLinkageReplay:
        """A replay of a free linkage of bodies and joints with steps of at most `step_s`; the caller closes it."""
        return BulletLinkageReplay(step_s)
