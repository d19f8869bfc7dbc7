"""The list of mechanism cases: family, scene, effect, size and noise by a rule from a number, none by hand."""

from __future__ import annotations

from functools import partial

import numpy as np

from simgap.kinds.mechanism.problem import MechanismProblem
from simgap.recording.train_test_split import split_trials
from tests.suites.gap import mujoco_truth, truth
from tests.suites.gap.case import Case, Family
from tests.suites.gap.effects import (
    EFFECTS,
    LAWS,
    OUTSIDE,
    SAME_LAW,
    HiddenEffect,
    Sizes,
    effect_named,
    hidden_numbers,
    with_friction,
)
from tests.suites.gap.power import GAINS, chance, ideal_gain, size_of, sized
from tests.suites.gap.readings import declared_spec, measurement, read
from tests.suites.gap.truth import STEP_S, Hidden, Plant

ROWS, ROW_S, TRIALS = 500, 5e-3, 12
# Of twenty numbers in a row: seven controls, six single effects, two with doubles, three of two effects, two outside.
_ROUND: tuple[Family, ...] = (
    *("control", "single", "outside", "control", "two", "single", "control", "pair", "single", "control"),
    *("single", "two", "control", "single", "control", "outside", "pair", "single", "control", "two"),
)
_STRIDES = (17, 19, 23)
_CONTROLS = ("none", "nuisance", "coloured", "engine", "declared", "finer", "shuffled")
_DRIVEN = ("driven", "slide", "servo")
_ALONE = tuple((e, s) for e in EFFECTS for s, doubles in e.scenes.items() if not doubles)
_DOUBLED = tuple((e, s) for e in EFFECTS for s, doubles in e.scenes.items() if doubles)
# Causes of different kinds at once; both can be seen in the scene.
_TWO = (
    ("joint.coulomb_friction", "joint.spring", "driven"),
    ("joint.viscous_friction", "actuator.saturation", "slide"),
    ("joint.gravity_load", "joint.coulomb_friction", "driven"),
    ("joint.coulomb_friction", "joint.viscous_friction", "swing"),
    ("actuator.lag", "joint.viscous_friction", "servo"),
    ("joint.detent", "joint.quadratic_drag", "swing"),
    ("joint.spring", "actuator.deadband", "slide"),
    ("actuator.gain", "joint.quadratic_drag", "driven"),
    ("joint.coulomb_friction", "actuator.ripple", "slide"),
    ("joint.spring", "joint.viscous_friction", "chain"),
)


def mechanism_case(number: int) -> Case:
    """The case of that number; the same number gives the same case."""
    family = family_of(number)
    turn = number // len(_ROUND) * _ROUND.count(family) + _ROUND[: number % len(_ROUND)].count(family)
    noise = (1.0, 3.0)[(turn // 2) % 2]
    if family == "control":
        return _control(number, turn, noise)
    if family == "outside":
        return _outside(number, turn, noise)
    size = list(GAINS)[(turn + turn // len(EFFECTS)) % 3]
    if family == "two":
        first, second, scene = _TWO[turn % len(_TWO)]
        return _hidden(number, family, scene, [effect_named(first), effect_named(second)], "large", noise)
    table = _ALONE if family == "single" else _DOUBLED
    stride = next(n for n in _STRIDES if len(table) % n)  # shares no factor with the length: all come by
    one, scene = table[(turn * stride) % len(table)]
    return _hidden(number, family, scene, [one], size, noise)


def single_case(number: int, name: str, scene: str, size: str, noise: float = 1.0) -> Case:
    """One hidden effect that has no double there; a further row in the list of hidden effects leaves it as it is."""
    return _hidden(number, "single", scene, [effect_named(name)], size, noise)


def family_of(number: int) -> Family:
    """The family of a case, without making it."""
    return _ROUND[number % len(_ROUND)]


class Stage:
    """A plant with its inputs, starts and noise, ready to be recorded with anything hidden in it."""

    def __init__(self, number: int, scene: str, noise: float, friction_share: float = 0.0) -> None:
        rng = np.random.default_rng(104729 + number)
        self.number, self.scene, self.noise = number, scene, noise
        self.plant = _plant(scene, rng)
        self.inputs, self.start = _excitation(scene, self.plant, rng)
        self.supply_V = 12.0 - np.cumsum(np.abs(rng.normal(0.0, 1.0, (TRIALS, ROWS))), axis=1) * 4.0 / ROWS
        self.supply_V += rng.uniform(-1.5, 0.0, (TRIALS, 1))
        self.joint = int(rng.integers(len(self.plant.inertia)))
        self.mujoco = False
        plain = self.motion({})
        self.sizes = self._sizes(plain)
        self.plant = with_friction(self.plant, self.sizes.torque, friction_share)

    def motion(self, hidden: Hidden) -> np.ndarray:
        """Positions on the fine grid."""
        if self.mujoco:
            return mujoco_truth.simulate(self.plant, hidden, self.inputs, self.start, ROW_S)
        return truth.simulate(self.plant, hidden, self.inputs, self.start, ROW_S, self.supply_V, LAWS)

    def problem(self, hidden: Hidden, colour: float = 0.0, shuffled: bool = False) -> MechanismProblem:
        """What the tool gets: readings of that motion."""
        rng = np.random.default_rng(15485863 + self.number)
        logs = read(self.motion(hidden), hidden, ROW_S, self.noise, colour, rng)
        inputs = np.roll(self.inputs, 1, axis=0) if shuffled else self.inputs
        return MechanismProblem(measurement(f"case {self.number}", self.plant, logs, inputs, self.supply_V))

    def numbers(self, one: HiddenEffect, strength: float) -> dict[str, np.ndarray | float]:
        """Truth numbers of an effect at a strength."""
        if strength == 0.0:
            return {}
        return hidden_numbers(one.made(strength, self.sizes), self.joint, len(self.plant.inertia), one.whole)

    def _sizes(self, motion: np.ndarray) -> Sizes:
        q = motion[:, ::10, self.joint]
        v = np.gradient(q, 10 * STEP_S, axis=1)
        inertia = float(self.plant.inertia[self.joint])
        weight = float(self.plant.weight_Nm[self.joint])
        effort = 0.0
        if self.plant.drive != "none":
            given = self.inputs[:, :, self.joint]
            effort = float(
                np.quantile(np.abs(given if self.plant.drive == "effort" else self.plant.kp * 0.2 * given), 0.95)
            )
        torque = max(float(np.quantile(np.abs(np.gradient(v, 10 * STEP_S, axis=1)), 0.9)) * inertia, 0.5 * weight)
        return Sizes(
            torque=torque,
            speed=float(np.quantile(np.abs(v), 0.9)),
            reach=float(np.quantile(q, 0.98) if self.scene != "slide" else np.quantile(q, 0.9)),
            effort=effort,
            inertia=inertia,
            weight_Nm=weight,
            kp=self.plant.kp,
        )


def _hidden(number: int, family: Family, scene: str, chosen: list[HiddenEffect], size: str, noise: float) -> Case:
    stage = Stage(number, scene, noise, max(e.declared_friction for e in chosen))
    stage.mujoco = number % 3 == 0 and all(e.mujoco for e in chosen)
    strengths, gain = [], 0.0
    for one in chosen:
        strength, gain = sized(lambda s, e=one: stage.problem(stage.numbers(e, s)), one.guess, one.most, GAINS[size])
        strengths.append(strength)
    hidden: dict[str, np.ndarray | float] = {}
    for one, strength in zip(chosen, strengths, strict=True):
        hidden |= stage.numbers(one, strength)
    if len(chosen) > 1:
        gain = ideal_gain(stage.problem(hidden), stage.problem({}))
    place = ("axis", "elbow")[stage.joint]
    checked: dict[tuple[str, str], float] = {}
    for one, strength in zip(chosen, strengths, strict=True):
        if one.checked is not None:
            parameter, value = one.checked(strength, stage.sizes)
            checked[one.name, parameter] = value + (
                stage.plant.friction if parameter == "torque_Nm" and "coulomb" in one.name else 0.0
            )
    same_scene, same = SAME_LAW.get(chosen[0].name, ("", ""))
    if family == "single" and scene == same_scene:
        family, chosen_doubles = "pair", (same,)
    else:
        chosen_doubles = chosen[0].scenes[scene]
    names = "+".join(e.name.partition(".")[2] for e in chosen)
    size = size_of(gain)
    spec, problem = declared_spec(stage.plant), stage.problem(hidden)
    words = f"{scene} {names} {size} x{noise:.0f}" + (" mujoco" if stage.mujoco else "")
    return Case(
        _titled(number, words),
        family,
        partial(stage.problem, hidden),
        spec,
        truth=tuple(e.name if e.whole else f"{e.name}@{place}" for e in chosen),
        doubles=frozenset((*chosen_doubles, chosen[0].name)) if family == "pair" else frozenset(),
        checked=checked,
        size=size,
        ideal=gain,
        chance=chance(problem, stage.problem({}), split_trials(spec, problem.trial_ids).train),
    )


def _outside(number: int, turn: int, noise: float) -> Case:
    kind = list(OUTSIDE)[turn % len(OUTSIDE)]
    stage = Stage(number, ("swing", "driven", "slide")[(turn // len(OUTSIDE)) % 3], noise)

    def at(strength: float) -> MechanismProblem:
        if strength == 0.0:
            return stage.problem({})
        return stage.problem({**OUTSIDE[kind](strength, stage.sizes), "seed": float(number)})

    strength, gain = sized(at, 0.1, 3.0, GAINS["large"])
    title = _titled(number, f"{stage.scene} {kind} x{noise:.0f}")
    return Case(title, "outside", partial(at, strength), declared_spec(stage.plant), ideal=gain)


def _control(number: int, turn: int, noise: float) -> Case:
    """Nothing hidden: declared numbers up to 3 % off, coloured noise, another engine, inputs of another trial."""
    kind = _CONTROLS[turn % len(_CONTROLS)]
    scenes = _DRIVEN if kind == "shuffled" else ("swing", "driven", "slide", "servo", "chain", "low_swing")
    scene = scenes[(turn // len(_CONTROLS) + turn) % len(scenes)]
    stage = Stage(number, scene, noise, 0.08 if kind == "declared" else 0.0)
    hidden: dict[str, float] = {}
    if kind in ("nuisance", "declared"):
        rng = np.random.default_rng(number)
        hidden = {f"{n}_share": float(rng.uniform(-0.03, 0.03)) for n in ("inertia", "weight", "friction", "gain")}
    stage.mujoco = kind == "engine"
    make = partial(stage.problem, hidden, 0.9 if kind == "coloured" else 0.0, kind == "shuffled")
    return Case(_titled(number, f"{scene} {kind} x{noise:.0f}"), "control", make, declared_spec(stage.plant))


def _titled(number: int, words: str) -> str:
    return f"mechanism {number:03d} {words}"


def _plant(scene: str, rng: np.random.Generator) -> Plant:
    inertia = float(rng.uniform(0.002, 0.05))
    if scene == "slide":
        mass = np.array([float(rng.uniform(0.5, 20.0))])
        return Plant("effort", True, mass, mass, np.zeros(1))
    if scene == "chain":
        length = rng.uniform(0.2, 0.4, 2)
        mass = rng.uniform(0.1, 1.0, 2)
        return Plant("none", False, mass * length**2 * 0.4, mass, 0.5 * length, float(length[0]))
    weight = inertia * float(rng.uniform(25.0, 60.0))
    lever = 0.5 * inertia * 9.81 / weight  # half of the inertia is that of the mass at its lever
    one = (np.array([inertia]), np.array([weight / 9.81 / lever]), np.array([lever]))
    if scene == "servo":
        kp = 20.0 * weight
        return Plant("position_pd", False, *one, kp=kp, kd=0.8 * float(np.sqrt(inertia * kp)))
    return Plant("effort" if scene == "driven" else "none", False, *one)


def _excitation(scene: str, plant: Plant, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Inputs (k, rows, j) and starts (k, j): released swings, or four tones between 0.3 and 2.5 Hz."""
    joints = len(plant.inertia)
    inputs, start = np.zeros((TRIALS, ROWS, joints)), np.zeros((TRIALS, joints))
    if plant.drive == "none":
        low, high = (0.1, 0.3) if scene == "low_swing" else (0.5, 1.6)
        start[:] = rng.uniform(low, high, (TRIALS, joints)) * rng.choice([-1.0, 1.0], (TRIALS, joints))
        return inputs, start
    t = np.arange(ROWS) * ROW_S
    tones = 2.0 * np.pi * rng.uniform(0.3, 2.5, (TRIALS, 4, 1)) * t + rng.uniform(0.0, 6.28, (TRIALS, 4, 1))
    waves = (rng.uniform(0.2, 0.5, (TRIALS, 4, 1)) * np.sin(tones)).sum(axis=1)
    unit = {"driven": 0.3 * float(plant.weight_Nm[0]), "slide": 4.0 * float(plant.inertia[0]), "servo": 0.8}[scene]
    inputs[:, :, 0] = unit * waves
    start[:, 0] = inputs[:, 0, 0] if scene == "servo" else 0.0
    return inputs, start
