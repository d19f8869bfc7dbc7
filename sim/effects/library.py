"""The list of all effects: the one table of their names, in the order of docs/reference/effects.md; look-up by name."""

from __future__ import annotations

from sim.effects.actuator import bias, deadband, delay, gain, lag, ripple, saturation, supply_sag
from sim.effects.body import com_offset, inertia, mass, size
from sim.effects.contact import (
    anisotropic_friction,
    compliance,
    friction,
    restitution,
    rolling_friction,
    spinning_friction,
)
from sim.effects.effect import Effect
from sim.effects.joint import (
    armature,
    axis_tilt,
    backlash,
    coulomb_friction,
    detent,
    friction_asymmetry,
    gravity_load,
    hard_stop,
    load_dependent_friction,
    quadratic_drag,
    spring,
    stribeck_friction,
    viscous_friction,
)
from sim.effects.robot import pd_gains
from sim.effects.sensor import bias as sensor_bias
from sim.effects.sensor import clock_skew, frame_rotation, latency, scale, velocity_age
from sim.effects.sensor import lag as sensor_lag
from sim.effects.world import constant_force, gravity_magnitude, gravity_tilt, linear_drag
from sim.effects.world import quadratic_drag as world_quadratic_drag

EFFECTS: tuple[Effect, ...] = (
    friction.EFFECT,
    restitution.EFFECT,
    rolling_friction.EFFECT,
    spinning_friction.EFFECT,
    anisotropic_friction.EFFECT,
    compliance.EFFECT,
    mass.EFFECT,
    com_offset.EFFECT,
    inertia.EFFECT,
    size.EFFECT,
    gravity_magnitude.EFFECT,
    gravity_tilt.EFFECT,
    linear_drag.EFFECT,
    world_quadratic_drag.EFFECT,
    constant_force.EFFECT,
    coulomb_friction.EFFECT,
    viscous_friction.EFFECT,
    stribeck_friction.EFFECT,
    load_dependent_friction.EFFECT,
    quadratic_drag.EFFECT,
    friction_asymmetry.EFFECT,
    spring.EFFECT,
    hard_stop.EFFECT,
    backlash.EFFECT,
    detent.EFFECT,
    axis_tilt.EFFECT,
    armature.EFFECT,
    gravity_load.EFFECT,
    delay.EFFECT,
    gain.EFFECT,
    saturation.EFFECT,
    bias.EFFECT,
    lag.EFFECT,
    ripple.EFFECT,
    deadband.EFFECT,
    supply_sag.EFFECT,
    latency.EFFECT,
    sensor_lag.EFFECT,
    sensor_bias.EFFECT,
    scale.EFFECT,
    clock_skew.EFFECT,
    frame_rotation.EFFECT,
    velocity_age.EFFECT,
    pd_gains.EFFECT,
)
EFFECT_NAMES: tuple[str, ...] = tuple(e.name for e in EFFECTS)
RESERVED_NAMES: tuple[str, ...] = ("robot.payload",)  # documented, without an effect yet


def effect(name: str) -> Effect:
    """The effect of that name. Raises KeyError with the known names: unknown effects are refused, not skipped."""
    for listed in EFFECTS:
        if listed.name == name:
            return listed
    raise KeyError(f"unknown effect '{name}'; known are {', '.join(EFFECT_NAMES)}")
