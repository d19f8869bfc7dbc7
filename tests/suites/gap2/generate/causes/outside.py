"""Outside causes (`outside.<word>`): physics that no library effect describes."""

from __future__ import annotations

import numpy as np

from tests.suites.gap2.generate.causes.cause import Cause, Where
from tests.suites.gap2.generate.plant import Hidden
from tests.suites.gap2.generate.scenes import (
    SCENES,
    SINGLE,
    SINGLE_DRIVEN,
    SINGLE_FREE,
    SINGLE_PUSHED,
    SINGLE_SERVO,
    TURNING,
)


def _soft_gear(s: float, w: Where) -> Hidden:
    """A motor of 30 % of the inertia behind a spring that twists by `s` of the travel at the typical torque."""
    motor = 0.3 * w.sizes.inertia
    stiff = w.sizes.torque / (s * w.sizes.reach)
    loss = 0.1 * np.sqrt(stiff * motor)
    return w.changed(MOTOR_INERTIA=motor, ROTOR=-motor, GEAR_STIFFNESS=stiff, GEAR_LOSS=loss)


OUTSIDE: tuple[Cause, ...] = (
    Cause("outside.elastic_joint", SINGLE_PUSHED, _soft_gear, least=1e-4, most=0.4),
    Cause(
        "outside.eccentric_encoder",
        TURNING,
        lambda s, w: Hidden(w.joint, eccentricity=s, eccentric_phase=6.28 * w.draws[2]),
        most=0.3,
    ),
    Cause(
        "outside.hysteresis",
        (*SINGLE_FREE, *SINGLE_DRIVEN),
        lambda s, w: w.changed(
            HYSTERESIS=s * w.sizes.torque, HYSTERESIS_TRAVEL=(0.2 + 0.5 * w.draws[1]) * w.sizes.reach
        ),
    ),
    Cause("outside.payload_by_trial", SINGLE, lambda s, w: Hidden(w.joint, payload=s), most=0.9),
    Cause(
        "outside.command_filter",
        SINGLE_PUSHED,
        lambda s, w: w.changed(
            FILTER_RATE=2.0 * np.pi / (s * w.sizes.period_s), FILTER_DAMPING=0.15 + 0.3 * w.draws[1]
        ),
        least=0.01,
        most=1.0,
    ),
    Cause(
        "outside.encoder_filter",
        SINGLE_PUSHED,
        lambda s, w: w.changed(
            SENSOR_RATE=2.0 * np.pi / (s * w.sizes.period_s), SENSOR_DAMPING=0.15 + 0.3 * w.draws[1]
        ),
        least=0.01,
        most=1.0,
    ),
    Cause(
        "outside.gain_fade",
        SINGLE_SERVO,
        lambda s, w: w.changed(GAIN_FADE=s, GAIN_FADE_RATE=0.7 * w.sizes.speed),
        most=0.95,
    ),
    Cause(
        "outside.magnet",
        SINGLE,
        lambda s, w: w.changed(
            MAGNET=s * w.sizes.torque,
            MAGNET_AT=w.sizes.low + (0.25 + 0.5 * w.draws[1]) * 2.0 * w.sizes.reach,
            MAGNET_WIDTH=0.08 * w.sizes.reach,
        ),
        most=3.0,
    ),
    Cause(
        "outside.shaking_base",
        SCENES,
        lambda s, w: w.changed(SHAKE=s * w.sizes.torque, SHAKE_RATE=2.0 * np.pi * (2.0 + 3.0 * w.draws[1])),
        most=3.0,
    ),
    Cause(
        "outside.heating_friction",
        (*SINGLE_FREE, *SINGLE_DRIVEN),
        lambda s, w: w.changed(HEATING=s / w.sizes.reach),
        most=5.0,
        rubs=True,
    ),
    Cause(
        "outside.friction_by_position",
        (*SINGLE_FREE, *SINGLE_DRIVEN),
        lambda s, w: w.changed(PLACE_FRICTION=s, PLACE_COUNT=w.count(1.0, 3.0)),
        most=0.95,
        rubs=True,
    ),
)
