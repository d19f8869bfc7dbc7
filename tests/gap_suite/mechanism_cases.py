"""Hidden-effect cases on pendulums and slides: scene x effect x size x noise, at least 30 % controls."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from schemas.measurement import MeasurementSpec
from simgap.measurement import Measurement
from simgap.trial import Trial
from tests.gap_suite.truth import Plant, simulate

ROWS, ROW_S, TRIALS = 600, 5e-3, 10
SIZES = {"small": 0.03, "middle": 0.1, "large": 0.3}


@dataclass(frozen=True)
class Case:
    """A measurement with the truth beside it: accepted names (empty for controls) and one checked parameter."""

    name: str
    measurement: Measurement
    truth: frozenset[str]
    parameter: tuple[str, float] | None
    size: str


@dataclass(frozen=True)
class Hidden:
    """An effect: names that count as right, its truth from (plant, typical torque, typical speed, share), scenes."""

    names: tuple[str, ...]
    scenes: tuple[str, ...]
    truth: str


# Names that no data of the scene can tell apart stand together.
EFFECTS: tuple[Hidden, ...] = (
    Hidden(("joint.coulomb_friction",), ("swing", "driven", "slide"), "coulomb"),
    Hidden(("joint.coulomb_friction", "joint.stribeck_friction"), ("swing", "driven", "slide"), "lugre"),
    Hidden(("joint.viscous_friction",), ("swing", "driven", "slide", "servo"), "viscous"),
    Hidden(("joint.quadratic_drag",), ("swing", "driven"), "drag"),
    Hidden(("joint.stribeck_friction",), ("driven", "slide"), "stribeck"),
    Hidden(("joint.load_dependent_friction", "joint.coulomb_friction"), ("swing", "driven"), "load_share"),
    Hidden(("joint.friction_asymmetry",), ("driven", "slide"), "asymmetry"),
    Hidden(("joint.spring",), ("driven", "slide"), "spring"),
    Hidden(("joint.hard_stop",), ("driven", "swing"), "stop"),
    Hidden(("joint.detent",), ("driven", "slide"), "cogging"),
    Hidden(("joint.armature", "joint.gravity_load", "sensor.clock_skew"), ("swing",), "inertia"),
    Hidden(("joint.armature",), ("driven",), "inertia"),
    Hidden(("joint.armature", "actuator.gain"), ("slide",), "inertia"),
    Hidden(("joint.gravity_load",), ("driven",), "weight"),
    Hidden(("joint.axis_tilt", "sensor.bias"), ("swing",), "tilt"),
    Hidden(("actuator.delay", "sensor.latency"), ("driven", "slide", "servo"), "delay"),
    Hidden(("actuator.lag",), ("driven", "servo"), "lag"),
    Hidden(("actuator.gain",), ("driven",), "gain"),
    Hidden(("actuator.bias",), ("slide",), "push"),
    Hidden(("actuator.saturation",), ("driven", "slide"), "limit"),
    Hidden(("actuator.deadband",), ("driven",), "band"),
    Hidden(("joint.backlash",), ("driven", "slide"), "gap"),
)


def mechanism_case(number: int) -> Case:
    """The case of that number: every third is a control; the same number gives the same case."""
    rng = np.random.default_rng(7919 + number)
    if number % 3 == 2:
        return _control(number, rng)
    position = number - number // 3
    hidden = EFFECTS[(position * 5) % len(EFFECTS)]
    scene = hidden.scenes[int(rng.integers(len(hidden.scenes)))]
    size = list(SIZES)[1 + (position // len(EFFECTS) + position) % 2] if number % 5 else "small"
    plant = _plant(scene, rng)
    truth, checked = _truth(hidden.truth, plant, SIZES[size], rng)
    spec, trials = _record(scene, plant, truth, rng, "white")
    name = f"{number:03d} {scene} {hidden.truth} {size}"
    return Case(name, _measured(name, spec, trials), frozenset(hidden.names), checked, size)


def _control(number: int, rng: np.random.Generator) -> Case:
    """No effect, declared numbers 3 % off, noise that is not white, a smaller friction already declared."""
    kind = ("none", "nuisance", "coloured", "declared")[(number // 3) % 4]
    scene = ("swing", "driven", "slide", "servo")[int(rng.integers(4))]
    plant = _plant(scene, rng)
    truth: dict[str, float] = {}
    if kind == "declared":
        plant = Plant(**{**plant.__dict__, "friction": 0.05 * _torque(plant), "damping": 0.02 * _torque(plant)})
    if kind in ("nuisance", "declared"):
        names = ("inertia_share", "weight_share", "friction_share", "damping_share")
        truth = {n: float(rng.uniform(-0.03, 0.03)) for n in names}
    spec, trials = _record(scene, plant, truth, rng, "coloured" if kind == "coloured" else "white")
    name = f"{number:03d} {scene} control {kind}"
    return Case(name, _measured(name, spec, trials), frozenset(), None, "control")


def _plant(scene: str, rng: np.random.Generator) -> Plant:
    inertia = float(rng.uniform(0.002, 0.05))
    if scene == "slide":
        return Plant(float(rng.uniform(0.5, 20.0)), 0.0, "effort")
    weight = inertia * float(rng.uniform(25.0, 60.0))
    if scene == "servo":
        return Plant(inertia, weight, "position_pd", kp=20.0 * weight, kd=0.1 * np.sqrt(inertia * 20.0 * weight) * 8.0)
    return Plant(inertia, weight, "none" if scene == "swing" else "effort")


def _torque(plant: Plant) -> float:
    return plant.weight_Nm or 4.0 * plant.inertia


def _truth(
    kind: str, plant: Plant, share: float, rng: np.random.Generator
) -> tuple[dict[str, float], tuple[str, float] | None]:
    """Hidden numbers of about `share` of the typical torque, and the library parameter that they stand for."""
    torque, speed = 0.6 * _torque(plant), 2.0
    one = share * torque
    table: dict[str, tuple[dict[str, float], tuple[str, float] | None]] = {
        "coulomb": ({"coulomb": 0.5 * one}, ("torque_Nm", 0.5 * one)),
        "lugre": ({"lugre": 0.5 * one}, None),
        "viscous": ({"viscous": one / speed}, ("damping_Nms_per_rad", one / speed)),
        "drag": ({"drag": one / speed**2}, ("drag_Nms2_per_rad2", one / speed**2)),
        "stribeck": ({"stribeck": 2.0 * one, "stribeck_radps": 0.2}, None),
        "load_share": ({"load_share": 0.5 * share}, None),
        "asymmetry": ({"asymmetry": 0.5 * one, "coulomb": 0.0, "friction_share": 0.0}, None),
        "spring": ({"spring": 2.0 * one, "rest": 0.2}, ("stiffness_Nm_per_rad", 2.0 * one)),
        "stop": ({"stop_rad": 0.5, "stop_stiffness": 60.0 * one}, ("upper_rad", 0.5)),
        "cogging": ({"cogging": one, "teeth": float(rng.uniform(8.0, 20.0))}, ("torque_Nm", one)),
        "inertia": ({"inertia_share": 2.0 * share + 0.1}, ("inertia_kgm2", (2.0 * share + 0.1) * plant.inertia)),
        "weight": ({"weight_share": -(share + 0.1)}, ("factor", 1.0 - (share + 0.1))),
        "tilt": ({"tilt_rad": share}, None),
        "delay": ({"delay_s": 0.005 + 0.1 * share}, None),
        "lag": ({"lag_s": 0.01 + 0.2 * share}, ("lag_s", 0.01 + 0.2 * share)),
        "gain": ({"gain_share": -(share + 0.05)}, ("gain", 1.0 - (share + 0.05))),
        "push": ({"push": one}, ("torque_Nm", one)),
        "limit": ({"limit": (1.2 - 2.0 * share) * torque}, ("limit_Nm", (1.2 - 2.0 * share) * torque)),
        "band": ({"band": one}, ("band_Nm", one)),
        "gap": ({"gap": 0.3 * share}, ("gap_rad", 0.3 * share)),
    }
    return table[kind]


def _record(
    scene: str, plant: Plant, truth: dict[str, float], rng: np.random.Generator, noise: str
) -> tuple[dict, list[tuple[np.ndarray, np.ndarray | None]]]:
    """The declared model and, per trial, readings and inputs."""
    t = np.arange(ROWS) * ROW_S
    inputs = np.zeros((TRIALS, ROWS))
    start = np.zeros((TRIALS, 2))
    if scene == "swing":
        start[:, 0] = rng.uniform(0.5, 1.6, TRIALS) * rng.choice([-1, 1], TRIALS)
    else:
        tones = rng.uniform(0.3, 2.5, (TRIALS, 4))
        inputs = np.einsum(
            "ka,kat->kt",
            rng.uniform(0.2, 0.5, (TRIALS, 4)),
            np.sin(2 * np.pi * tones[:, :, None] * t + rng.uniform(0, 6.28, (TRIALS, 4, 1))),
        )
        inputs *= _torque(plant) * (1.0 if scene != "servo" else 0.0) + (0.8 if scene == "servo" else 0.0)
        start[:, 0] = inputs[:, 0] if scene == "servo" else 0.0
    if "asymmetry" in truth:
        plant = Plant(**{**plant.__dict__, "friction": 1.5 * truth["asymmetry"]})
    true = simulate(plant, truth, inputs, start, ROW_S)
    sigma = float(rng.choice([2e-4, 6e-4]))
    error = rng.normal(0.0, sigma, true.shape)
    if noise == "coloured":
        for k in range(1, ROWS):
            error[:, k] = 0.9 * error[:, k - 1] + np.sqrt(1 - 0.81) * error[:, k]
    read = np.round((true + error) / (2 * np.pi / 2**14)) * (2 * np.pi / 2**14)
    joint: dict = {"name": "axis", "type": "prismatic" if scene == "slide" else "revolute"}
    joint |= {"friction": plant.friction, "damping": plant.damping}
    if scene == "slide":
        joint["mass_kg"] = plant.inertia
    else:
        lever = 4.0 * plant.inertia * 9.81 / plant.weight_Nm
        lever = min(lever, 0.9 * plant.inertia * 9.81 / plant.weight_Nm)
        joint |= {"inertia_kgm2": plant.inertia}
        joint["gravity_load"] = {"mass_kg": plant.weight_Nm / 9.81 / lever, "com_distance_m": lever}
    spec = {
        "schema_version": 1,
        "name": "case",
        "kind": "mechanism",
        "rate_hz": 1.0 / ROW_S,
        "columns": {"t": "t", "q_axis": "q"},
        "subject": {"joints": [joint]},
        "actuation": {"type": plant.drive, "kp": plant.kp, "kd": plant.kd},
    }
    used = None if plant.drive == "none" else inputs
    return spec, [(read[k], None if used is None else used[k]) for k in range(TRIALS)]


def _measured(name: str, spec: dict, trials: list[tuple[np.ndarray, np.ndarray | None]]) -> Measurement:
    column = {"effort": "effort", "position_pd": "command"}.get(spec["actuation"]["type"], "")
    made = []
    for k, (q, used) in enumerate(trials):
        n = len(q)

        def absent(width: int, n: int = n) -> np.ndarray:
            return np.full((n, width), np.nan)

        logged = None if used is None else used[:, None]
        made.append(
            Trial(
                id=f"t{k:02d}",
                t_s=np.arange(n) * ROW_S,
                p=absent(3),
                quat_wxyz=absent(4),
                v_W=absent(3),
                w_B=absent(3),
                q=q[:, None],
                qd=absent(1),
                command_p=absent(3),
                command_quat_wxyz=absent(4),
                effort=logged if logged is not None and column == "effort" else absent(1),
                command=logged if logged is not None and column == "command" else absent(1),
            )
        )
    return Measurement(MeasurementSpec(**spec), tuple(made), Path("."), name, ("axis",))
