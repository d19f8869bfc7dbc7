"""Hidden-effect cases on tossed boxes: effects and controls in MuJoCo, problems in PyBullet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from schemas.measurement import MeasurementSpec, SensorNoise
from sim.bullet.body import BulletBodyRollout
from simgap.kinds.free_body.declared_model import build_body
from simgap.kinds.free_body.problem import FreeBodyProblem
from simgap.kinds.free_body.rigid import RigidBodySimulator
from simgap.recording.read import Measurement
from simgap.recording.recording import Trial
from tests.suites.gap.case import Case, Family
from tests.suites.gap.free_body_truth import STEP_S, Box, Recording, toss
from tests.suites.gap.power import ideal_gain, size_of

TRIALS = 12


@dataclass(frozen=True)
class Toss:
    """An effect: its hidden numbers, its names in the library, and those that these data cannot distinguish from it."""

    hidden: Mapping[str, float]
    truth: tuple[str, ...] = ()
    doubles: frozenset[str] = frozenset()
    checked: Mapping[tuple[str, str], float] = field(default_factory=dict)
    family: Family = "single"
    noise: float = 1.0
    step_s: float = STEP_S


_FALLS = frozenset({"world.gravity_magnitude", "sensor.clock_skew", "world.constant_force"})
_LEANS = frozenset({"world.gravity_tilt", "world.constant_force"})
_DRAGS = frozenset({"world.linear_drag", "world.quadratic_drag"})


def free_body_case(number: int) -> Case:
    """The case of that number; every third is a control. The same number gives the same case."""
    rng = np.random.default_rng(104729 + number)
    size = rng.uniform(0.06, 0.12, 3)
    box = Box(size, float(800.0 * size.prod()), float(rng.uniform(0.3, 0.5)))
    weight = 9.81 * box.mass
    kind = number % 3
    if kind == 2:
        name, hidden = list(_controls(box, rng).items())[(number // 3) % 5]
    else:
        some = _effects(box, weight)
        name, hidden = list(some.items())[(number - number // 3) % len(some)]
    spec, again = spec_of(box), deepcopy(rng)
    problem = _recorded(box, spec, hidden, rng)
    gain = ideal_gain(problem(), _recorded(box, spec, replace(hidden, hidden={}), again)()) if hidden.truth else 0.0
    size_word = size_of(gain) if hidden.truth else ""
    return Case(
        name=f"{number:03d} toss {name}" + (f" {size_word}" if size_word else ""),
        family="pair" if hidden.doubles else hidden.family,
        problem=problem,
        spec=spec,
        truth=hidden.truth,
        doubles=hidden.doubles,
        checked=hidden.checked,
        size=size_word,
        ideal=gain,
    )


def _recorded(box: Box, spec: MeasurementSpec, made: Toss, rng: np.random.Generator) -> Callable[[], FreeBodyProblem]:
    """Tosses as MuJoCo makes them, as a problem; starts and noise follow from the state of `rng`."""
    recordings = [toss(box, made.hidden, rng, made.noise, made.step_s) for _ in range(TRIALS)]
    measurement = measured(spec, recordings)
    return lambda: FreeBodyProblem(measurement, RigidBodySimulator(build_body(spec, Path(".")), BulletBodyRollout()))


def _controls(box: Box, rng: np.random.Generator) -> dict[str, Toss]:
    """Nothing hidden; friction a little off; three times the noise; steps four times larger and smaller."""
    return {
        "none": Toss({}, family="control"),
        "friction 3 % off": Toss({"mu": box.mu * (1.0 + rng.uniform(-0.03, 0.03))}, family="control"),
        "noise x3": Toss({}, family="control", noise=3.0),
        "coarse": Toss({}, family="control", step_s=2e-3),
        "fine": Toss({}, family="control", step_s=2.5e-4),
    }


def _effects(box: Box, weight: float) -> dict[str, Toss]:
    length = float(box.size_m.max())
    return {
        "slippery": Toss({"mu": 0.12}, ("contact.friction",), checked={("contact.friction", "mu"): 0.12}),
        "grippy": Toss({"mu": 0.8}, ("contact.friction",), checked={("contact.friction", "mu"): 0.8}),
        "scale": Toss({"scale": 0.95}, ("sensor.scale",), checked={("sensor.scale", "factor"): 0.95}),
        "gravity": Toss({"g": 7.5}, ("world.gravity_magnitude",), _FALLS),
        "clock": Toss({"clock": 1.1}, ("sensor.clock_skew",), _FALLS),
        "tilt": Toss({"tilt_rad": 0.08}, ("world.gravity_tilt",), _LEANS),
        "push": Toss({"push_x": 0.08 * weight, "push_y": 0.04 * weight}, ("world.constant_force",), _LEANS),
        "size": Toss({"size": 0.93}, ("body.size",), checked={("body.size", "factor"): 0.93}),
        "inertia": Toss({"inertia": 1.6}, ("body.inertia",), checked={("body.inertia", "factor"): 1.6}),
        "mass centre": Toss(
            {"com_x": 0.12 * length, "com_y": -0.05 * length},
            ("body.com_offset",),
            checked={("body.com_offset", "x_m"): 0.12 * length},
        ),
        "bouncy": Toss({"damping_ratio": 0.2}, ("contact.restitution",), frozenset()),
        "drag": Toss({"drag": 0.15 * weight}, ("world.linear_drag",), _DRAGS),
        "air": Toss({"square_drag": 0.15 * weight}, ("world.quadratic_drag",), _DRAGS),
        "age": Toss({"age_s": 0.012}, ("sensor.velocity_age",), checked={("sensor.velocity_age", "age_s"): 0.012}),
        "turned tag": Toss(
            {"turned_rad": 0.08}, ("sensor.frame_rotation",), checked={("sensor.frame_rotation", "x_rad"): 0.08}
        ),
        "slippery and scaled": Toss({"mu": 0.15, "scale": 0.95}, ("contact.friction", "sensor.scale"), family="two"),
        "magnus": Toss({"magnus": 0.03 * weight}, family="outside"),
    }


def spec_of(box: Box) -> MeasurementSpec:
    """The measurement that its owner writes for the box."""
    return MeasurementSpec.model_validate(
        {
            "schema_version": 1,
            "name": "case",
            "kind": "free_body",
            "columns": {
                "t": "t",
                "p": ["px", "py", "pz"],
                "q_wxyz": ["qw", "qx", "qy", "qz"],
                "v": ["vx", "vy", "vz"],
                "w_body": ["wx", "wy", "wz"],
            },
            "subject": {
                "box": {"size_m": box.size_m.tolist()},
                "mass_kg": box.mass,
                "inertia_kgm2": box.inertia.tolist(),
                "contact": {"friction": box.mu, "restitution": 0.0},
            },
            "world": {
                "gravity_mps2": [0.0, 0.0, -9.81],
                "support": {"plane": {"normal": [0.0, 0.0, 1.0], "height_m": 0.0}},
            },
        }
    )


def measured(spec: MeasurementSpec, recordings: list[Recording]) -> Measurement:
    """The recordings as they are read."""
    trials = []
    for k, r in enumerate(recordings):
        n = len(r.t_s)

        def absent(width: int, n: int = n) -> np.ndarray:
            return np.full((n, width), np.nan)

        trials.append(
            Trial(
                id=f"t{k:02d}",
                t_s=r.t_s - r.t_s[0],
                p=r.p,
                quat_wxyz=r.quat_wxyz,
                v_W=r.v,
                w_B=r.w,
                q=absent(0),
                qd=absent(0),
                effort=absent(0),
                command=absent(0),
                command_p=absent(3),
                command_quat_wxyz=absent(4),
            )
        )
    noise = SensorNoise(p_m=5e-5, rotation_rad=5e-4, v_mps=4e-3, w_radps=0.04)
    return Measurement(spec, tuple(trials), Path("."), "case", (), noise)
