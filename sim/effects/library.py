"""Every effect, in one explicit list; the order is that of the contract's table."""

from __future__ import annotations

from sim.effects import (
    actuator_bias,
    actuator_deadband,
    actuator_delay,
    actuator_gain,
    actuator_lag,
    actuator_ripple,
    actuator_saturation,
    actuator_supply_sag,
    joint_armature,
    joint_axis_tilt,
    joint_backlash,
    joint_coulomb_friction,
    joint_detent,
    joint_friction_asymmetry,
    joint_gravity_load,
    joint_hard_stop,
    joint_load_dependent_friction,
    joint_quadratic_drag,
    joint_spring,
    joint_stribeck_friction,
    joint_viscous_friction,
    sensor_bias,
    sensor_clock_skew,
    sensor_latency,
    sensor_scale,
    sensor_velocity_age,
)
from sim.effects.effect import Effect

EFFECTS: tuple[Effect, ...] = (
    joint_coulomb_friction.EFFECT,
    joint_viscous_friction.EFFECT,
    joint_stribeck_friction.EFFECT,
    joint_load_dependent_friction.EFFECT,
    joint_quadratic_drag.EFFECT,
    joint_friction_asymmetry.EFFECT,
    joint_spring.EFFECT,
    joint_hard_stop.EFFECT,
    joint_backlash.EFFECT,
    joint_detent.EFFECT,
    joint_axis_tilt.EFFECT,
    joint_armature.EFFECT,
    joint_gravity_load.EFFECT,
    actuator_delay.EFFECT,
    actuator_gain.EFFECT,
    actuator_saturation.EFFECT,
    actuator_bias.EFFECT,
    actuator_lag.EFFECT,
    actuator_ripple.EFFECT,
    actuator_deadband.EFFECT,
    actuator_supply_sag.EFFECT,
    sensor_latency.EFFECT,
    sensor_bias.EFFECT,
    sensor_scale.EFFECT,
    sensor_clock_skew.EFFECT,
    sensor_velocity_age.EFFECT,
)


def effect(name: str) -> Effect:
    """The effect of that name. Raises KeyError with the known names: unknown effects are refused, not skipped."""
    for each in EFFECTS:
        if each.name == name:
            return each
    raise KeyError(f"unknown effect '{name}'; known are {', '.join(e.name for e in EFFECTS)}")
