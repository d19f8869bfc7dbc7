"""One stroke of a joint over its range: reach, lever arm, the inertia and weight that it moves, speed and strength.

Numbers are in units of the model that the engine simulates (`sim.port.model_scale`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from geom import pose
from geom.convex.placement import moved_shape
from geom.convex.support_function import surface
from schemas.mechanism import MechanismJoint
from schemas.physical_constants import GRAVITY_MPS2
from sim.bullet.articulation import BuiltArticulation
from sim.joint_exercise import Pace, moved_links, reach_of

# Seconds of a stroke over the whole range: a hand moves a handle at 2 m/s when it is quick, within these bounds.
FAST_MPS, FAST_LEAST_S, FAST_MOST_S, SLOW_S = 2.0, 0.4, 1.0, 2.0
STRENGTH = 3.0  # of motor and hand, over what the stroke takes


@dataclass(frozen=True)
class Stroke:
    """One joint, in units of the model.

    reach      least and greatest true position; `low`, `high` the same from rest, in units of the model.
    arm        distance of the farthest collider from the axis; 1 of a sliding joint.
    inertia    of all moved mass at the end of the arm; `gravity` the largest effort of its weight.
    fall_mps   speed after the highest free fall that the motion allows.
    """

    joint: MechanismJoint
    reach: tuple[float, float]  # true positions
    low: float
    high: float
    arm: float
    inertia: float
    damping: float
    stiffness: float
    friction: float
    gravity: float
    fall_mps: float

    @property
    def span(self) -> float:
        """Length of the range."""
        return max(self.high - self.low, 1e-9)

    def seconds(self, pace: Pace, root: float) -> float:
        """Duration of a stroke; `root` is how many times slower the model moves than the object."""
        fast_s = min(max(self.span * self.arm / (FAST_MPS * root), FAST_LEAST_S * root), FAST_MOST_S * root)
        return fast_s if pace == "fast" else max(SLOW_S * root, fast_s)

    def strength(self, rate: float, inertia: float) -> float:
        """Effort that brings an inertia, at most that of all mass at the end of the arm, to `rate` in a tenth of the
        stroke, against all that resists.
        """
        speeding = min(inertia, self.inertia) * rate / (0.1 * self.span / rate)
        resisting = self.gravity + self.friction + self.damping * rate + 2.0 * self.stiffness * self.span
        return STRENGTH * (speeding + resisting)


def stroke_of(built: BuiltArticulation, joint: MechanismJoint) -> Stroke:
    """The numbers of a joint of the tree, with all links below it."""
    mechanism, scale = built.articulation.mechanism, built.scale
    moved = moved_links(mechanism, (joint,))
    origins = {link.name: pose.pose(None, link.origin) for link in mechanism.links}
    bodies = [body for body in built.articulation.links if body.name in moved]
    clouds = [surface(moved_shape(s, origins[body.name]))[0] for body in bodies for s in body.shapes]
    points = np.concatenate([np.asarray(joint.anchor)[None], *clouds]) - joint.anchor
    mass = sum(body.mass.mass_kg for body in bodies) * scale**3
    reach = reach_of(mechanism, joint)
    low, high = ((end - joint.rest) * built.unit(joint) for end in reach)
    upright = abs(float(joint.axis[2]))
    level = math.sqrt(max(1.0 - upright**2, 0.0))
    arm = float(np.linalg.norm(np.cross(points, joint.axis), axis=1).max()) * scale if joint.is_angular else 1.0
    arm = arm if arm > 0.0 else 1.0
    fall = 2.0 * arm * level if joint.is_angular else upright * (high - low)
    return Stroke(
        joint,
        reach,
        low,
        high,
        arm,
        inertia=mass * arm**2,
        gravity=mass * GRAVITY_MPS2 * (arm * level if joint.is_angular else upright),
        fall_mps=math.sqrt(2.0 * GRAVITY_MPS2 * max(fall, 0.0)),
        # Froude (`sim.port.model_scale`): torques x s^4, forces x s^3, times x sqrt(s).
        damping=joint.damping * (scale**4.5 if joint.is_angular else scale**2.5),
        stiffness=joint.stiffness * (scale**4 if joint.is_angular else scale**2),
        friction=joint.friction * (scale**4 if joint.is_angular else scale**3),
    )
