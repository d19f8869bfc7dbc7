"""Names of library effects that are hidden as twins of one another, and of those that are hidden two at once."""

from __future__ import annotations

from tests.suites.gap2.generate.scenes import SINGLE_DRIVEN, SINGLE_SERVO, UPRIGHT

_WEIGHTLESS_DRIVEN, _WEIGHTLESS_SERVO = (
    tuple(s for s in kind if s not in UPRIGHT) for kind in (SINGLE_DRIVEN, SINGLE_SERVO)
)

# Pairs that some scenes cannot separate: what is hidden, its twin, and where.
TWINS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    ("joint.armature", "joint.gravity_load", ("pendulum",)),
    ("joint.gravity_load", "joint.armature", ("pendulum",)),
    ("sensor.clock_skew", "joint.gravity_load", ("pendulum",)),
    ("joint.axis_tilt", "sensor.bias", ("pendulum", "pendulum_effort")),
    ("sensor.bias", "joint.axis_tilt", ("pendulum", "pendulum_effort")),
    ("actuator.delay", "sensor.latency", SINGLE_DRIVEN),
    ("sensor.latency", "actuator.delay", SINGLE_DRIVEN),
    ("actuator.lag", "sensor.lag", _WEIGHTLESS_DRIVEN),
    ("sensor.lag", "actuator.lag", _WEIGHTLESS_DRIVEN),
    ("actuator.gain", "joint.armature", _WEIGHTLESS_DRIVEN),
    ("joint.armature", "sensor.clock_skew", _WEIGHTLESS_DRIVEN),
    ("sensor.clock_skew", "joint.armature", _WEIGHTLESS_DRIVEN),
    ("sensor.scale", "actuator.gain", _WEIGHTLESS_DRIVEN),
    ("actuator.bias", "joint.friction_asymmetry", _WEIGHTLESS_DRIVEN),
    ("joint.friction_asymmetry", "actuator.bias", _WEIGHTLESS_DRIVEN),
    ("robot.pd_gains", "joint.viscous_friction", _WEIGHTLESS_SERVO),
    ("joint.viscous_friction", "robot.pd_gains", _WEIGHTLESS_SERVO),
    ("joint.coulomb_friction", "sensor.scale", ("slide", "door")),
    ("actuator.bias", "sensor.bias", _WEIGHTLESS_SERVO),
    ("sensor.bias", "actuator.bias", _WEIGHTLESS_SERVO),
)

# Two at once, of different kinds.
PAIRS: tuple[tuple[str, str, str], ...] = (
    ("joint.coulomb_friction", "joint.quadratic_drag", "pendulum"),
    ("joint.viscous_friction", "actuator.delay", "pendulum_servo"),
    ("joint.gravity_load", "joint.coulomb_friction", "pendulum_effort"),
    ("joint.spring", "actuator.deadband", "slide_effort"),
    ("actuator.gain", "joint.quadratic_drag", "pendulum_effort"),
    ("joint.hard_stop", "joint.viscous_friction", "door"),
    ("joint.coulomb_friction", "sensor.latency", "slide_servo"),
    ("joint.detent", "joint.viscous_friction", "pendulum"),
    ("actuator.saturation", "joint.spring", "door_effort"),
    ("joint.spring", "joint.viscous_friction", "chain2"),
    ("joint.coulomb_friction", "joint.gravity_load", "chain2_effort"),
    ("joint.backlash", "joint.viscous_friction", "door_effort"),
)
