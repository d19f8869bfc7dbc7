"""What a case can hide: library effects under the library's names, and outside causes; formulas from the physics.

Each cause maps a strength and the sizes of the believed motion to `Hidden`; `checked` gives the value of the library's
parameter where it is the same number.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import Hidden, Plant
from tests.suites.gap2.generate.scenes import DRIVEN, FREE, SCENES, SERVO, Sizes

Draws = np.ndarray  # (4,) uniform in 0 to 1: the shape of a cause, equal at every strength


@dataclass(frozen=True)
class Where:
    """The believed mechanism, the joint on which a cause acts, its sizes there and the cause's draws."""

    plant: Plant
    joint: int
    sizes: Sizes
    draws: Draws

    def believed(self, which: Number) -> float:
        """A believed number of the joint."""
        return self.plant.number(self.joint, which)

    @property
    def way(self) -> float:
        """1 or -1, drawn."""
        return 1.0 if self.draws[0] < 0.5 else -1.0

    def count(self, fewest: float, most: float) -> float:
        """Repeats per rad (m) such that the travel holds `fewest` to `most` of them."""
        return float(2.0 * np.pi * (fewest + self.draws[1] * (most - fewest)) / (2.0 * self.sizes.reach))


@dataclass(frozen=True)
class Cause:
    """One cause.

    name      the library's, or `outside.<word>`.
    scenes    where data can show it.
    least, most   strengths; a cause that is large at its least gets a noisier sensor.
    hidden    what it is at a strength.
    checked   (parameter, value) of the library's parameter that is the same number.
    rubs      needs dry friction that the owner knows of; supply: needs the supply's log.
    whole     acts on the whole log or world: the verdict names no joint.
    """

    name: str
    scenes: tuple[str, ...]
    hidden: Callable[[float, Where], Hidden]
    checked: Callable[[float, Where], tuple[str, float]] | None = None
    least: float = 1e-5
    most: float = 1.0
    rubs: bool = False
    supply: bool = False
    whole: bool = False


_UPRIGHT = tuple(s for s in SCENES if s.startswith(("pendulum", "chain")))
_SINGLE_UPRIGHT = tuple(s for s in _UPRIGHT if s.startswith("pendulum"))
_PUSHED = (*DRIVEN, *SERVO)
_SINGLE = tuple(s for s in SCENES if not s.startswith("chain"))
_TURNING = tuple(s for s in SCENES if s.startswith(("pendulum", "door")))


def _set(w: Where, **numbers: float) -> Hidden:
    return Hidden(w.joint, {Number[name]: value for name, value in numbers.items()})


def _stop(s: float, w: Where) -> Hidden:
    """A stop so stiff that a blow at full speed goes 6 % of half the travel deep."""
    z = w.sizes
    stiffness = 1.25 * z.inertia * z.speed**2 / (0.06 * z.reach) ** 2.5
    upper = z.high - 0.8 * s * 2.0 * z.reach
    return _set(w, STOP_UPPER=upper, STOP_STIFFNESS=stiffness, STOP_LOSS=0.3 / z.speed)


def _play(s: float, w: Where) -> Hidden:
    """A motor of a tenth of the inertia beyond a gap; together they weigh what is declared."""
    motor = 0.1 * w.sizes.inertia
    stiff = motor * (60.0 * 2.0 * np.pi / w.sizes.period_s) ** 2
    return _set(
        w,
        MOTOR_INERTIA=motor,
        ROTOR=-motor,
        GEAR_STIFFNESS=stiff,
        GEAR_LOSS=0.5 * np.sqrt(stiff * motor),
        GEAR_PLAY=s * w.sizes.reach,
    )


def _soft_gear(s: float, w: Where) -> Hidden:
    """A motor of 30 % of the inertia behind a spring that twists by `s` of the travel at the typical torque."""
    motor = 0.3 * w.sizes.inertia
    stiff = w.sizes.torque / (s * w.sizes.reach)
    loss = 0.1 * np.sqrt(stiff * motor)
    return _set(w, MOTOR_INERTIA=motor, ROTOR=-motor, GEAR_STIFFNESS=stiff, GEAR_LOSS=loss)


def _share(s: float, w: Where) -> float:
    return 1.0 + w.way * s


# Least relative change: an owner trusts declared numbers to 5 %, and what lies within is no effect.
_TRUSTED = 0.15
_F, _B = Number.COULOMB, Number.VISCOUS

LIBRARY: tuple[Cause, ...] = (
    Cause(
        "joint.coulomb_friction",
        SCENES,
        lambda s, w: _set(w, COULOMB=w.believed(_F) + s * w.sizes.torque),
        lambda s, w: ("torque_Nm", w.believed(_F) + s * w.sizes.torque),
    ),
    Cause(
        "joint.viscous_friction",
        SCENES,
        lambda s, w: _set(w, VISCOUS=w.believed(_B) + s * w.sizes.torque / w.sizes.speed),
        lambda s, w: ("damping_Nms_per_rad", w.believed(_B) + s * w.sizes.torque / w.sizes.speed),
    ),
    Cause(
        "joint.stribeck_friction",
        ("pendulum", "slide", *DRIVEN[:3]),
        lambda s, w: _set(w, STRIBECK=s * w.sizes.torque, STRIBECK_RATE=(0.1 + 0.3 * w.draws[1]) * w.sizes.speed),
    ),
    Cause(
        "joint.load_dependent_friction",
        _SINGLE_UPRIGHT,
        lambda s, w: _set(w, LOAD_RADIUS=0.5 * s * float(w.plant.lever[0])),
        lambda s, w: ("radius_m", 0.5 * s * float(w.plant.lever[0])),
    ),
    Cause(
        "joint.quadratic_drag",
        _SINGLE,
        lambda s, w: _set(w, QUADRATIC=s * w.sizes.torque / w.sizes.speed**2),
        lambda s, w: ("drag_Nms2_per_rad2", s * w.sizes.torque / w.sizes.speed**2),
    ),
    Cause(
        "joint.friction_asymmetry",
        ("pendulum", "slide", *DRIVEN[:3]),
        lambda s, w: _set(w, ASYMMETRY=w.way * s * w.believed(_F)),
        lambda s, w: ("torque_Nm", w.way * s * w.believed(_F)),
        most=0.95,
        rubs=True,
    ),
    Cause(
        "joint.spring",
        SCENES,
        lambda s, w: _set(
            w, SPRING=s * w.sizes.torque / w.sizes.reach, SPRING_REST=0.4 * (w.draws[1] - 0.5) * w.sizes.reach
        ),
        lambda s, w: ("stiffness_Nm_per_rad", s * w.sizes.torque / w.sizes.reach),
    ),
    Cause(
        "joint.hard_stop",
        _SINGLE,
        _stop,
        lambda s, w: ("upper_rad", w.sizes.high - 0.8 * s * 2.0 * w.sizes.reach),
        least=1e-3,
    ),
    Cause("joint.backlash", DRIVEN[:3], _play, most=0.5),
    Cause(
        "joint.detent",
        _SINGLE,
        lambda s, w: _set(
            w, DETENT=s * w.sizes.torque, DETENT_COUNT=w.count(2.0, 6.0), DETENT_PHASE=6.28 * w.draws[2] - 3.14
        ),
        lambda s, w: ("torque_Nm", s * w.sizes.torque),
    ),
    Cause(
        "joint.axis_tilt",
        _UPRIGHT,
        lambda s, w: _set(w, TILT=w.way * s),
        lambda s, w: ("about_y_rad", w.way * s),
        most=0.3,
        whole=True,
    ),
    Cause(
        "joint.armature",
        SCENES,
        lambda s, w: _set(w, ROTOR=s * w.sizes.inertia),
        lambda s, w: ("inertia_kgm2", s * w.sizes.inertia),
        most=3.0,
        least=_TRUSTED,
    ),
    Cause(
        "joint.gravity_load",
        _UPRIGHT,
        lambda s, w: _set(w, GRAVITY_FACTOR=_share(s, w) * w.believed(Number.GRAVITY_FACTOR)),
        lambda s, w: ("factor", _share(s, w)),
        most=0.6,
        least=_TRUSTED,
    ),
    Cause(
        "actuator.delay",
        _PUSHED,
        lambda s, w: Hidden(w.joint, delay_s=s * w.sizes.period_s),
        lambda s, w: ("delay_s", s * w.sizes.period_s),
        most=0.15,
    ),
    Cause(
        "actuator.lag",
        _PUSHED,
        lambda s, w: _set(w, LAG=s * w.sizes.period_s),
        lambda s, w: ("lag_s", s * w.sizes.period_s),
        least=1e-3,
        most=0.3,
    ),
    Cause(
        "actuator.gain",
        DRIVEN,
        lambda s, w: _set(w, GAIN=_share(s, w) * w.believed(Number.GAIN)),
        lambda s, w: ("gain", _share(s, w)),
        most=0.6,
        least=_TRUSTED,
    ),
    Cause(
        "actuator.saturation",
        (*DRIVEN[:3], *SERVO[:2]),
        lambda s, w: _set(w, SATURATION=(1.0 - s) * 1.2 * w.sizes.effort),
        lambda s, w: ("limit_Nm", (1.0 - s) * 1.2 * w.sizes.effort),
        most=0.9,
    ),
    Cause(
        "actuator.bias",
        _PUSHED,
        lambda s, w: _set(w, BIAS=w.way * s * w.sizes.torque),
        lambda s, w: ("torque_Nm", w.way * s * w.sizes.torque),
    ),
    Cause(
        "actuator.deadband",
        (*DRIVEN[:3], *SERVO[:2]),
        lambda s, w: _set(w, DEADBAND=s * w.sizes.effort),
        lambda s, w: ("band_Nm", s * w.sizes.effort),
        most=0.7,
    ),
    Cause(
        "actuator.ripple",
        (*DRIVEN[:3], *SERVO[:2]),
        lambda s, w: _set(w, RIPPLE=s, RIPPLE_COUNT=w.count(2.0, 6.0), RIPPLE_PHASE=6.28 * w.draws[2] - 3.14),
        lambda s, w: ("share", s),
        most=0.9,
    ),
    Cause(
        "actuator.supply_sag",
        (*DRIVEN[:3], *SERVO[:2]),
        lambda s, w: _set(w, SAG=s),
        lambda s, w: ("sag", s),
        most=2.5,
        supply=True,
    ),
    Cause(
        "sensor.latency",
        _PUSHED,
        lambda s, w: Hidden(w.joint, latency_s=s * w.sizes.period_s),
        lambda s, w: ("latency_s", s * w.sizes.period_s),
        most=0.1,
    ),
    Cause(
        "sensor.lag",
        _PUSHED,
        lambda s, w: _set(w, SENSOR_LAG=s * w.sizes.period_s),
        lambda s, w: ("time_constant_s", s * w.sizes.period_s),
        least=1e-3,
        most=0.2,
    ),
    Cause(
        "sensor.bias",
        (*_UPRIGHT, *SERVO),
        lambda s, w: Hidden(w.joint, offset=w.way * s * w.sizes.reach),
        lambda s, w: ("offset_rad", w.way * s * w.sizes.reach),
        most=0.4,
    ),
    Cause(
        "sensor.scale",
        SCENES,
        lambda s, w: Hidden(w.joint, scale=_share(s, w)),
        lambda s, w: ("factor", _share(s, w)),
        most=0.5,
        least=_TRUSTED,
    ),
    Cause(
        "sensor.clock_skew",
        SCENES,
        lambda s, w: Hidden(w.joint, clock=_share(s, w)),
        lambda s, w: ("factor", _share(s, w)),
        most=0.4,
        whole=True,
        least=_TRUSTED / 2,
    ),
    Cause(
        "robot.pd_gains",
        SERVO,
        lambda s, w: _set(w, KP=_share(s, w) * w.believed(Number.KP)),
        lambda s, w: ("kp", _share(s, w) * w.believed(Number.KP)),
        least=_TRUSTED,
        most=0.6,
    ),
    Cause(
        "robot.pd_gains",
        SERVO,
        lambda s, w: _set(w, KD=_share(s, w) * w.believed(Number.KD)),
        lambda s, w: ("kd", _share(s, w) * w.believed(Number.KD)),
        least=_TRUSTED,
        most=0.8,
    ),
)

OUTSIDE: tuple[Cause, ...] = (
    Cause("outside.elastic_joint", (*DRIVEN[:3], *SERVO[:2]), _soft_gear, least=1e-4, most=0.4),
    Cause(
        "outside.eccentric_encoder",
        _TURNING,
        lambda s, w: Hidden(w.joint, eccentricity=s, eccentric_phase=6.28 * w.draws[2]),
        most=0.3,
    ),
    Cause(
        "outside.hysteresis",
        (*FREE[:3], *DRIVEN[:3]),
        lambda s, w: _set(w, HYSTERESIS=s * w.sizes.torque, HYSTERESIS_TRAVEL=(0.2 + 0.5 * w.draws[1]) * w.sizes.reach),
    ),
    Cause("outside.payload_by_trial", _SINGLE, lambda s, w: Hidden(w.joint, payload=s), most=0.9),
    Cause(
        "outside.command_filter",
        (*DRIVEN[:3], *SERVO[:2]),
        lambda s, w: _set(w, FILTER_RATE=2.0 * np.pi / (s * w.sizes.period_s), FILTER_DAMPING=0.15 + 0.3 * w.draws[1]),
        least=0.01,
        most=1.0,
    ),
    Cause(
        "outside.encoder_filter",
        (*DRIVEN[:3], *SERVO[:2]),
        lambda s, w: _set(w, SENSOR_RATE=2.0 * np.pi / (s * w.sizes.period_s), SENSOR_DAMPING=0.15 + 0.3 * w.draws[1]),
        least=0.01,
        most=1.0,
    ),
    Cause(
        "outside.gain_fade",
        SERVO[:2],
        lambda s, w: _set(w, GAIN_FADE=s, GAIN_FADE_RATE=0.7 * w.sizes.speed),
        most=0.95,
    ),
    Cause(
        "outside.magnet",
        _SINGLE,
        lambda s, w: _set(
            w,
            MAGNET=s * w.sizes.torque,
            MAGNET_AT=w.sizes.low + (0.25 + 0.5 * w.draws[1]) * 2.0 * w.sizes.reach,
            MAGNET_WIDTH=0.08 * w.sizes.reach,
        ),
        most=3.0,
    ),
    Cause(
        "outside.shaking_base",
        SCENES,
        lambda s, w: _set(w, SHAKE=s * w.sizes.torque, SHAKE_RATE=2.0 * np.pi * (2.0 + 3.0 * w.draws[1])),
        most=3.0,
    ),
    Cause(
        "outside.heating_friction",
        (*FREE[:3], *DRIVEN[:3]),
        lambda s, w: _set(w, HEATING=s / w.sizes.reach),
        most=5.0,
        rubs=True,
    ),
    Cause(
        "outside.friction_by_position",
        (*FREE[:3], *DRIVEN[:3]),
        lambda s, w: _set(w, PLACE_FRICTION=s, PLACE_COUNT=w.count(1.0, 3.0)),
        most=0.95,
        rubs=True,
    ),
)

# Pairs that some scenes cannot separate: what is hidden, its twin, and where.
TWINS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    ("joint.armature", "joint.gravity_load", ("pendulum",)),
    ("joint.gravity_load", "joint.armature", ("pendulum",)),
    ("sensor.clock_skew", "joint.gravity_load", ("pendulum",)),
    ("joint.axis_tilt", "sensor.bias", ("pendulum", "pendulum_effort")),
    ("sensor.bias", "joint.axis_tilt", ("pendulum", "pendulum_effort")),
    ("actuator.delay", "sensor.latency", DRIVEN[:3]),
    ("sensor.latency", "actuator.delay", DRIVEN[:3]),
    ("actuator.lag", "sensor.lag", DRIVEN[1:3]),
    ("sensor.lag", "actuator.lag", DRIVEN[1:3]),
    ("actuator.gain", "joint.armature", DRIVEN[1:3]),
    ("joint.armature", "sensor.clock_skew", DRIVEN[1:3]),
    ("sensor.clock_skew", "joint.armature", DRIVEN[1:3]),
    ("sensor.scale", "actuator.gain", DRIVEN[1:3]),
    ("actuator.bias", "joint.friction_asymmetry", DRIVEN[1:3]),
    ("joint.friction_asymmetry", "actuator.bias", DRIVEN[1:3]),
    ("robot.pd_gains", "joint.viscous_friction", SERVO[1:2]),
    ("joint.viscous_friction", "robot.pd_gains", SERVO[1:2]),
    ("joint.coulomb_friction", "sensor.scale", ("slide", "door")),
    ("actuator.bias", "sensor.bias", SERVO[1:2]),
    ("sensor.bias", "actuator.bias", SERVO[1:2]),
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


def library_cause(name: str) -> Cause:
    """The first cause of that name."""
    return next(c for c in LIBRARY if c.name == name)
