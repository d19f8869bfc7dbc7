"""Library effects under the library's names, with the library parameters of the same meaning; formulas from physics."""

from __future__ import annotations

import numpy as np

from tests.suites.gap2.generate.causes.cause import Cause, Where
from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import Hidden
from tests.suites.gap2.generate.scenes import (
    DRIVEN,
    PUSHED,
    SCENES,
    SERVO,
    SINGLE,
    SINGLE_DRIVEN,
    SINGLE_PUSHED,
    SINGLE_UPRIGHT,
    UPRIGHT,
)

# Least relative change: an owner trusts declared numbers to 5 %, and what lies within is no effect.
_TRUSTED = 0.15


def _stop(s: float, w: Where) -> Hidden:
    """A stop so stiff that a blow at full speed goes 6 % of half the travel deep."""
    z = w.sizes
    stiffness = 1.25 * z.inertia * z.speed**2 / (0.06 * z.reach) ** 2.5
    upper = z.high - 0.8 * s * 2.0 * z.reach
    return w.changed(STOP_UPPER=upper, STOP_STIFFNESS=stiffness, STOP_LOSS=0.3 / z.speed)


def _play(s: float, w: Where) -> Hidden:
    """A motor of a tenth of the inertia beyond a gap; together they weigh what is declared."""
    motor = 0.1 * w.sizes.inertia
    stiff = motor * (60.0 * 2.0 * np.pi / w.sizes.period_s) ** 2
    return w.changed(
        MOTOR_INERTIA=motor,
        ROTOR=-motor,
        GEAR_STIFFNESS=stiff,
        GEAR_LOSS=0.5 * np.sqrt(stiff * motor),
        GEAR_PLAY=s * w.sizes.reach,
    )


LIBRARY: tuple[Cause, ...] = (
    Cause(
        "joint.coulomb_friction",
        SCENES,
        lambda s, w: w.changed(COULOMB=w.believed(Number.COULOMB) + s * w.sizes.torque),
        lambda h: {"torque_Nm": h.numbers[Number.COULOMB]},
    ),
    Cause(
        "joint.viscous_friction",
        SCENES,
        lambda s, w: w.changed(VISCOUS=w.believed(Number.VISCOUS) + s * w.sizes.torque / w.sizes.speed),
        lambda h: {"damping_Nms_per_rad": h.numbers[Number.VISCOUS]},
    ),
    Cause(
        "joint.stribeck_friction",
        ("pendulum", "slide", *SINGLE_DRIVEN),
        lambda s, w: w.changed(STRIBECK=s * w.sizes.torque, STRIBECK_RATE=(0.1 + 0.3 * w.draws[1]) * w.sizes.speed),
    ),
    Cause(
        "joint.load_dependent_friction",
        SINGLE_UPRIGHT,
        lambda s, w: w.changed(LOAD_RADIUS=0.5 * s * float(w.plant.lever[0])),
        lambda h: {"radius_m": h.numbers[Number.LOAD_RADIUS]},
    ),
    Cause(
        "joint.quadratic_drag",
        SINGLE,
        lambda s, w: w.changed(QUADRATIC=s * w.sizes.torque / w.sizes.speed**2),
        lambda h: {"drag_Nms2_per_rad2": h.numbers[Number.QUADRATIC]},
    ),
    Cause(
        "joint.friction_asymmetry",
        ("pendulum", "slide", *SINGLE_DRIVEN),
        lambda s, w: w.changed(ASYMMETRY=w.way * s * w.believed(Number.COULOMB)),
        lambda h: {"torque_Nm": h.numbers[Number.ASYMMETRY]},
        most=0.95,
        rubs=True,
    ),
    Cause(
        "joint.spring",
        SCENES,
        lambda s, w: w.changed(
            SPRING=s * w.sizes.torque / w.sizes.reach, SPRING_REST=0.4 * (w.draws[1] - 0.5) * w.sizes.reach
        ),
        lambda h: {"stiffness_Nm_per_rad": h.numbers[Number.SPRING]},
    ),
    Cause(
        "joint.hard_stop",
        SINGLE,
        _stop,
        lambda h: {"upper_rad": h.numbers[Number.STOP_UPPER]},
        least=1e-3,
    ),
    Cause("joint.backlash", SINGLE_DRIVEN, _play, most=0.5),
    Cause(
        "joint.detent",
        SINGLE,
        lambda s, w: w.changed(
            DETENT=s * w.sizes.torque, DETENT_COUNT=w.count(2.0, 6.0), DETENT_PHASE=6.28 * w.draws[2] - 3.14
        ),
        lambda h: {"torque_Nm": h.numbers[Number.DETENT]},
    ),
    Cause(
        "joint.axis_tilt",
        UPRIGHT,
        lambda s, w: w.changed(TILT=w.way * s),
        lambda h: {"about_y_rad": h.numbers[Number.TILT]},
        most=0.3,
        whole=True,
    ),
    Cause(
        "joint.armature",
        SCENES,
        lambda s, w: w.changed(ROTOR=s * w.sizes.inertia),
        lambda h: {"inertia_kgm2": h.numbers[Number.ROTOR]},
        most=3.0,
        least=_TRUSTED,
    ),
    Cause(
        "joint.gravity_load",
        UPRIGHT,
        lambda s, w: w.changed(GRAVITY_FACTOR=w.share(s) * w.believed(Number.GRAVITY_FACTOR)),
        lambda h: {"factor": h.numbers[Number.GRAVITY_FACTOR]},
        most=0.6,
        least=_TRUSTED,
    ),
    Cause(
        "actuator.delay",
        PUSHED,
        lambda s, w: Hidden(w.joint, delay_s=s * w.sizes.period_s),
        lambda h: {"delay_s": h.delay_s},
        most=0.15,
    ),
    Cause(
        "actuator.lag",
        PUSHED,
        lambda s, w: w.changed(LAG=s * w.sizes.period_s),
        lambda h: {"lag_s": h.numbers[Number.LAG]},
        least=1e-3,
        most=0.3,
    ),
    Cause(
        "actuator.gain",
        DRIVEN,
        lambda s, w: w.changed(GAIN=w.share(s) * w.believed(Number.GAIN)),
        lambda h: {"gain": h.numbers[Number.GAIN]},
        most=0.6,
        least=_TRUSTED,
    ),
    Cause(
        "actuator.saturation",
        SINGLE_PUSHED,
        lambda s, w: w.changed(SATURATION=(1.0 - s) * 1.2 * w.sizes.effort),
        lambda h: {"limit_Nm": h.numbers[Number.SATURATION]},
        most=0.9,
    ),
    Cause(
        "actuator.bias",
        PUSHED,
        lambda s, w: w.changed(BIAS=w.way * s * w.sizes.torque),
        lambda h: {"torque_Nm": h.numbers[Number.BIAS]},
    ),
    Cause(
        "actuator.deadband",
        SINGLE_PUSHED,
        lambda s, w: w.changed(DEADBAND=s * w.sizes.effort),
        lambda h: {"band_Nm": h.numbers[Number.DEADBAND]},
        most=0.7,
    ),
    Cause(
        "actuator.ripple",
        SINGLE_PUSHED,
        lambda s, w: w.changed(RIPPLE=s, RIPPLE_COUNT=w.count(2.0, 6.0), RIPPLE_PHASE=6.28 * w.draws[2] - 3.14),
        lambda h: {"share": h.numbers[Number.RIPPLE]},
        most=0.9,
    ),
    Cause(
        "actuator.supply_sag",
        SINGLE_PUSHED,
        lambda s, w: w.changed(SAG=s),
        lambda h: {"sag": h.numbers[Number.SAG]},
        most=2.5,
        supply=True,
    ),
    Cause(
        "sensor.latency",
        PUSHED,
        lambda s, w: Hidden(w.joint, latency_s=s * w.sizes.period_s),
        lambda h: {"latency_s": h.latency_s},
        most=0.1,
    ),
    Cause(
        "sensor.lag",
        PUSHED,
        lambda s, w: w.changed(SENSOR_LAG=s * w.sizes.period_s),
        lambda h: {"time_constant_s": h.numbers[Number.SENSOR_LAG]},
        least=1e-3,
        most=0.2,
    ),
    Cause(
        "sensor.bias",
        (*UPRIGHT, *SERVO),
        lambda s, w: Hidden(w.joint, offset=w.way * s * w.sizes.reach),
        lambda h: {"offset_rad": h.offset},
        most=0.4,
    ),
    Cause(
        "sensor.scale",
        SCENES,
        lambda s, w: Hidden(w.joint, scale=w.share(s)),
        lambda h: {"factor": h.scale},
        most=0.5,
        least=_TRUSTED,
    ),
    Cause(
        "sensor.clock_skew",
        SCENES,
        lambda s, w: Hidden(w.joint, clock=w.share(s)),
        lambda h: {"factor": h.clock},
        most=0.4,
        whole=True,
        least=_TRUSTED / 2,
    ),
    Cause(
        "robot.pd_gains",
        SERVO,
        lambda s, w: w.changed(KP=w.share(s) * w.believed(Number.KP)),
        lambda h: {"kp": h.numbers[Number.KP]},
        least=_TRUSTED,
        most=0.6,
    ),
    Cause(
        "robot.pd_gains",
        SERVO,
        lambda s, w: w.changed(KD=w.share(s) * w.believed(Number.KD)),
        lambda h: {"kd": h.numbers[Number.KD]},
        least=_TRUSTED,
        most=0.8,
    ),
)


def library_cause(name: str) -> Cause:
    """The first cause of that name."""
    return next(c for c in LIBRARY if c.name == name)
