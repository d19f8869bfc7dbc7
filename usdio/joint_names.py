"""Names of joint attributes beside those of UsdPhysics, under which writer and reader of packages keep them.

Newton: docs of `NewtonJointAPI` and `NewtonMimicAPI`; PhysX: `PhysxJointAPI`. Angles are degrees there, too.
"""

from __future__ import annotations

from typing import Final

FRICTION: Final = "newton:friction"
ARMATURE: Final = "newton:armature"
SPEED: Final = "physxJoint:maxJointVelocity"
LEADER: Final = "newton:mimicJoint"
OFFSET: Final = "newton:mimicCoef0"
MULTIPLIER: Final = "newton:mimicCoef1"
