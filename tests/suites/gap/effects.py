"""Hidden effects of mechanisms: in which scenes they show, what they are made of, and what looks the same there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from tests.suites.gap.truth import Plant, TorqueLaw

Values = dict[str, float]


@dataclass(frozen=True)
class Sizes:
    """Typical magnitudes of a plain run at the joint in question: torque, speed, reach of position, input."""

    torque: float
    speed: float
    reach: float
    effort: float
    inertia: float
    weight_Nm: float
    kp: float


@dataclass(frozen=True)
class HiddenEffect:
    """An effect that a case can hide.

    name      the library's.
    scenes    where data can show it, with the names that cannot be distinguished from it there.
    made      truth numbers at a strength; `most` is the largest strength, `guess` the first one tried.
    checked   the library's parameter that is the same number, and its value.
    torque    the law as a torque at a state, from the physics and not from the library; None where `truth` has it.
    whole     acts on the whole log, not on one joint.
    mujoco    MuJoCo can make it too.
    """

    name: str
    scenes: Mapping[str, tuple[str, ...]]
    made: Callable[[float, Sizes], Values]
    checked: Callable[[float, Sizes], tuple[str, float]] | None = None
    torque: TorqueLaw | None = None
    guess: float = 0.05
    most: float = 2.0
    whole: bool = False
    mujoco: bool = False
    declared_friction: float = field(default=0.0)  # share of the torque that the owner knows of


_HEAVY = ("joint.armature", "joint.gravity_load", "sensor.clock_skew", "joint.spring")
_SLOW = ("actuator.lag", "sensor.lag")  # a linear joint does not show on which side of it a low-pass lies
_LATE = ("actuator.delay", "sensor.latency")
_PULL = ("joint.armature", "actuator.gain", "sensor.scale", "sensor.clock_skew")
_ZERO = ("joint.axis_tilt", "sensor.bias")
_PUSH = ("actuator.bias", "joint.friction_asymmetry")
_OFFSET = ("actuator.bias", "sensor.bias", "joint.axis_tilt")
_GAINS = ("robot.pd_gains",)  # friction in proportion to speed is a gain on the rate

EFFECTS: tuple[HiddenEffect, ...] = (
    HiddenEffect(
        "joint.coulomb_friction",
        {"swing": (), "driven": (), "slide": (), "chain": (), "low_swing": ("joint.load_dependent_friction",)},
        lambda s, z: {"coulomb": s * z.torque},
        lambda s, z: ("torque_Nm", s * z.torque),
        mujoco=True,
    ),
    HiddenEffect(
        "joint.viscous_friction",
        {"swing": (), "driven": (), "slide": (), "servo": _GAINS, "chain": ()},
        lambda s, z: {"viscous": s * z.torque / z.speed},
        lambda s, z: ("damping_Nms_per_rad", s * z.torque / z.speed),
        mujoco=True,
    ),
    HiddenEffect("joint.stribeck_friction", {"driven": (), "slide": ()}, lambda s, z: {"stribeck": s * z.torque}),
    HiddenEffect(
        "joint.load_dependent_friction",
        {"swing": (), "driven": (), "low_swing": ("joint.coulomb_friction",)},
        lambda s, z: {"load_radius": s * 0.1},
        lambda s, z: ("radius_m", s * 0.1),
    ),
    HiddenEffect(
        "joint.quadratic_drag",
        {"swing": (), "driven": (), "slide": ()},
        lambda s, z: {"drag": s * z.torque / z.speed**2},
        lambda s, z: ("drag_Nms2_per_rad2", s * z.torque / z.speed**2),
        torque=lambda h, q, v: -h("drag") * v * np.abs(v),
    ),
    HiddenEffect(
        "joint.friction_asymmetry",
        {"swing": (), "slide": _PUSH, "driven": _PUSH},
        lambda s, z: {"asymmetry": s * z.torque},
        lambda s, z: ("torque_Nm", s * z.torque),
        most=0.15,
        declared_friction=0.15,
    ),
    HiddenEffect(
        "joint.spring",
        {"driven": (), "slide": (), "chain": (), "swing": ()},
        lambda s, z: {"spring": s * z.torque / z.reach},  # at rest where gravity is: a constant part would be a bias
        lambda s, z: ("stiffness_Nm_per_rad", s * z.torque / z.reach),
        guess=0.1,
        mujoco=True,
    ),
    HiddenEffect(
        "joint.hard_stop",
        {"driven": (), "swing": (), "slide": ()},
        lambda s, z: {"stop_at": (1.0 - s) * z.reach, "stop_stiffness": 400.0 * z.torque / z.reach**1.5},
        lambda s, z: ("upper_rad", (1.0 - s) * z.reach),
        guess=0.3,
        most=0.8,
    ),
    HiddenEffect(
        "joint.backlash",
        {"driven": (), "slide": ()},
        lambda s, z: {"gap": s * z.reach},
        guess=0.03,
        most=0.4,
    ),
    HiddenEffect(
        "joint.detent",
        {"swing": (), "driven": (), "slide": ()},
        lambda s, z: {"cogging": s * z.torque, "teeth": 12.0 / z.reach},
        lambda s, z: ("torque_Nm", s * z.torque),
        torque=lambda h, q, v: -h("cogging") * np.cos(h("teeth") * q + 0.4),
        guess=0.05,
    ),
    HiddenEffect(
        "joint.axis_tilt",
        {"swing": _ZERO, "driven": _ZERO},
        lambda s, z: {"tilt_rad": s},
        mujoco=True,
        most=0.5,
        whole=True,
    ),
    HiddenEffect(
        "joint.armature",
        {"driven": (), "swing": _HEAVY, "slide": _PULL, "servo": ()},
        lambda s, z: {"inertia_share": s},
        lambda s, z: ("inertia_kgm2", s * z.inertia),
        guess=0.15,
        most=3.0,
        mujoco=True,
    ),
    HiddenEffect(
        "joint.gravity_load",
        {"driven": (), "swing": _HEAVY, "chain": ()},
        lambda s, z: {"weight_share": -s},
        lambda s, z: ("factor", 1.0 - s),
        guess=0.1,
        most=0.9,
    ),
    HiddenEffect(
        "actuator.delay",
        {"driven": _LATE, "slide": _LATE, "servo": _LATE},
        lambda s, z: {"delay_s": s},
        lambda s, z: ("delay_s", s),
        guess=0.01,
        most=0.25,
    ),
    HiddenEffect(
        "actuator.lag",
        {"driven": _SLOW, "slide": _SLOW, "servo": _SLOW},
        lambda s, z: {"lag_s": s},
        lambda s, z: ("lag_s", s),
        guess=0.02,
        most=0.4,
    ),
    HiddenEffect(
        "actuator.gain",
        {"driven": (), "slide": _PULL},
        lambda s, z: {"gain_share": -s},
        lambda s, z: ("gain", 1.0 - s),
        guess=0.1,
        most=0.8,
        mujoco=True,
    ),
    HiddenEffect(
        "actuator.saturation",
        {"driven": (), "slide": (), "servo": ()},
        lambda s, z: {"limit": (1.0 - s) * z.effort},
        lambda s, z: ("limit_Nm", (1.0 - s) * z.effort),
        guess=0.3,
        most=0.85,
    ),
    HiddenEffect(
        "actuator.bias",
        {"driven": _PUSH, "slide": _PUSH, "servo": _OFFSET},
        lambda s, z: {"push": s * z.torque},
        lambda s, z: ("torque_Nm", s * z.torque),
        mujoco=True,
    ),
    HiddenEffect(
        "actuator.deadband",
        {"driven": (), "slide": (), "servo": ()},
        lambda s, z: {"band": s * z.effort},
        most=0.6,
    ),
    HiddenEffect(
        "actuator.ripple",
        {"driven": (), "slide": ()},
        lambda s, z: {"ripple": s, "teeth": 12.0 / z.reach},
        lambda s, z: ("share", s),
        guess=0.1,
        most=1.0,
    ),
    HiddenEffect(
        "actuator.supply_sag",
        {"driven": (), "slide": ()},
        lambda s, z: {"sag": s},
        guess=0.5,
        most=2.0,
    ),
    HiddenEffect(
        "sensor.latency",
        {"driven": _LATE, "slide": _LATE, "servo": _LATE},
        lambda s, z: {"latency_s": s},
        lambda s, z: ("latency_s", s),
        guess=0.01,
        most=0.25,
    ),
    HiddenEffect(
        "sensor.bias",
        {"swing": _ZERO, "driven": _ZERO, "servo": _OFFSET},
        lambda s, z: {"zero_rad": s},
        guess=0.02,
        most=0.5,
    ),
    HiddenEffect("sensor.scale", {"slide": _PULL}, lambda s, z: {"scale_share": s}, guess=0.1, most=0.9),
    HiddenEffect(
        "sensor.clock_skew",
        {"swing": _HEAVY, "driven": ()},
        lambda s, z: {"clock_share": s},
        guess=0.1,
        most=0.9,
        whole=True,
    ),
    HiddenEffect(
        "sensor.lag",
        {"driven": _SLOW, "slide": _SLOW, "servo": _SLOW},
        lambda s, z: {"sensor_lag_s": s},
        lambda s, z: ("time_constant_s", s),
        guess=0.02,
        most=0.25,
    ),
    HiddenEffect(
        "robot.pd_gains",
        {"servo": ("joint.viscous_friction",)},  # slow tones show the ratio of both gains alone
        lambda s, z: {"kp_share": -s},
        lambda s, z: ("kp", (1.0 - s) * z.kp),
        guess=0.1,
        most=0.8,
    ),
    HiddenEffect(  # a drive that gives energy: its rate is late, or its gain on the rate is smaller than declared
        "joint.viscous_friction",
        {"driven": (), "servo": _GAINS},
        lambda s, z: {"viscous": -s * z.torque / z.speed},
        lambda s, z: ("damping_Nms_per_rad", -s * z.torque / z.speed),
        guess=0.03,
        most=0.15,
    ),
)

# Listed as alone, yet the same law: with stamps that run fast by f under efforts held from row to row a joint obeys
# I f^2 q'' = effort - weight, as with another inertia. Their cases count as pairs.
SAME_LAW: Mapping[str, tuple[str, str]] = {
    "joint.armature": ("driven", "sensor.clock_skew"),
    "sensor.clock_skew": ("driven", "joint.armature"),
}

OUTSIDE: dict[str, Callable[[float, Sizes], Values]] = {
    "hum": lambda s, z: {"hum": s * z.torque},
    "kicks": lambda s, z: {"kicks": s * z.torque},
    "gusts": lambda s, z: {"gusts": s * z.torque},
    "absorber": lambda s, z: {"absorber": s},
}


LAWS: tuple[TorqueLaw, ...] = tuple(e.torque for e in EFFECTS if e.torque is not None)


def effect_named(name: str) -> HiddenEffect:
    """The first hidden effect of that name."""
    return next(e for e in EFFECTS if e.name == name)


def hidden_numbers(values: Values, joint: int, joints: int, whole: bool) -> dict[str, np.ndarray | float]:
    """Numbers of one joint as (j,) arrays with zeros elsewhere; scalars where they belong to the whole log."""
    if whole:
        return dict(values)
    return {n: np.where(np.arange(joints) == joint, v, 0.0) for n, v in values.items()}


def with_friction(plant: Plant, torque: float, share: float) -> Plant:
    """The plant with a dry friction that its owner knows of."""
    return Plant(**{**plant.__dict__, "friction": share * torque}) if share else plant
