"""Each law that a case can hide against SciPy on the law written out, one joint at a time; sensors in closed form."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import GRAVITY, Hidden, Plant, observe
from tests.suites.gap2.test_kernel import LENGTH_S, STEP_S, plant_of, trial_of, with_numbers

EFFORT, SUPPLY, PHASE = 0.9, 0.8, 0.3
PENDULUM, SLIDE = plant_of(1, drive="effort"), plant_of(1, slides=True, upright=False)
MASS, LEVER, INERTIA = float(PENDULUM.mass[0]), float(PENDULUM.lever[0]), float(PENDULUM.inertia[0])
WEIGHT = MASS * GRAVITY * LEVER
Torque = Callable[[float, float, float], float]  # of time, position and rate


def end(plant: Plant, numbers: dict[str, float], start: list[float], given: float = EFFORT) -> float:
    """The last reading under a constant input; the law acts on the believed plant from outside."""
    trial = trial_of(plant, start, lambda t: np.full((len(t), 1), given))
    trial = replace(trial, supply=np.full(len(trial.stamps_s), SUPPLY))
    hidden = Hidden(numbers={Number[name]: value for name, value in numbers.items()})
    (q, _), *_ = observe(plant, hidden, [trial], 0.2 * STEP_S)
    return float(q[-1, 0])


def solved(rates: Callable[[float, np.ndarray], Sequence[float]], start: list[float]) -> np.ndarray:
    """States at the end by SciPy; (states, stages)."""
    return solve_ivp(rates, (0.0, LENGTH_S), start, rtol=1e-9, atol=1e-10, max_step=2e-3).y


TORQUES: dict[str, tuple[dict[str, float], Torque]] = {
    "upper stop": (
        {"STOP_UPPER": 0.5, "STOP_STIFFNESS": 40.0, "STOP_LOSS": 0.2},
        lambda t, q, v: EFFORT - 40.0 * max(q - 0.5, 0.0) ** 1.5 * max(1.0 + 0.2 * v, 0.0),
    ),
    "lower stop": (
        {"STOP_LOWER": 0.2, "STOP_STIFFNESS": 40.0, "STOP_LOSS": 0.2},
        lambda t, q, v: EFFORT + 40.0 * max(0.2 - q, 0.0) ** 1.5 * max(1.0 - 0.2 * v, 0.0),
    ),
    "detent": (
        {"DETENT": 0.4, "DETENT_COUNT": 5.0, "DETENT_PHASE": 0.7},
        lambda t, q, v: EFFORT - 0.4 * np.sin(5.0 * q - 0.7),
    ),
    "magnet": (
        {"MAGNET": 0.5, "MAGNET_AT": 0.3, "MAGNET_WIDTH": 0.2},
        lambda t, q, v: EFFORT - 0.5 * (q - 0.3) / 0.2 * np.exp(0.5 * (1.0 - ((q - 0.3) / 0.2) ** 2)),
    ),
    "shaking base": ({"SHAKE": 0.4, "SHAKE_RATE": 15.0}, lambda t, q, v: EFFORT + 0.4 * np.sin(15.0 * t + PHASE)),
    "deadband": ({"DEADBAND": 0.25}, lambda t, q, v: EFFORT - 0.25),
    "saturation": ({"SATURATION": 0.5}, lambda t, q, v: 0.5),
    "declared limit": ({"LIMIT": 0.6}, lambda t, q, v: 0.6),
    "gain": ({"GAIN": 1.3}, lambda t, q, v: 1.3 * EFFORT),
    "bias": ({"BIAS": 0.2}, lambda t, q, v: EFFORT + 0.2),
    "ripple": (
        {"RIPPLE": 0.3, "RIPPLE_COUNT": 6.0, "RIPPLE_PHASE": 0.4},
        lambda t, q, v: EFFORT * (1.0 + 0.3 * np.sin(6.0 * q - 0.4)),
    ),
    "supply sag": ({"SAG": 0.7}, lambda t, q, v: EFFORT * (1.0 - 0.7 * (1.0 - SUPPLY))),
    "axis tilt": ({"TILT": 0.2}, lambda t, q, v: EFFORT - WEIGHT * (np.sin(q - 0.2) - np.sin(q))),
    "weight": ({"GRAVITY_FACTOR": 1.2}, lambda t, q, v: EFFORT - 0.2 * WEIGHT * np.sin(q)),
    "rotor": (
        {"ROTOR": 0.25 * INERTIA},
        lambda t, q, v: (EFFORT - WEIGHT * np.sin(q)) / 1.25 + WEIGHT * np.sin(q),
    ),
}


@pytest.mark.parametrize("name", TORQUES)
def test_torque_moves_a_pendulum_as_in_scipy(name: str) -> None:
    numbers, torque = TORQUES[name]
    start = [0.6, -2.0]
    states = solved(lambda t, x: [x[1], (torque(t, x[0], x[1]) - WEIGHT * np.sin(x[0])) / INERTIA], start)
    plain = end(PENDULUM, {}, start)
    assert end(PENDULUM, numbers, start) == pytest.approx(states[0, -1], abs=2e-5)
    assert abs(states[0, -1] - plain) > 1e-2


FRICTIONS: dict[str, tuple[dict[str, float], Callable[[float, float], float]]] = {  # of position and rate; from 0.2 on
    "asymmetric": ({"ASYMMETRY": 0.3}, lambda q, v: 0.8),
    "stribeck": ({"STRIBECK": 0.4, "STRIBECK_RATE": 1.5}, lambda q, v: 0.5 + 0.4 * np.exp(-((v / 1.5) ** 2))),
    "heated by travel": ({"HEATING": 0.6}, lambda q, v: 0.5 * (1.0 + 0.6 * (q - 0.2))),
    "by position": ({"PLACE_FRICTION": 0.7, "PLACE_COUNT": 3.0}, lambda q, v: 0.5 * (1.0 + 0.7 * np.sin(3.0 * q))),
}


@pytest.mark.parametrize("name", FRICTIONS)
def test_friction_slows_a_slide_as_in_scipy(name: str) -> None:
    numbers, friction = FRICTIONS[name]
    states = solved(lambda t, x: [x[1], -friction(x[0], x[1]) / MASS], [0.2, 2.0])
    assert states[1].min() > 0.0
    assert end(with_numbers(SLIDE, COULOMB=0.5), numbers, [0.2, 2.0]) == pytest.approx(states[0, -1], abs=1e-5)


def test_friction_follows_the_load_of_the_bearing() -> None:
    def rates(t: float, x: np.ndarray) -> list[float]:
        torque = EFFORT - WEIGHT * np.sin(x[0])
        along = MASS * (LEVER * x[1] ** 2 + GRAVITY * np.cos(x[0]))
        across = MASS * (LEVER * torque / INERTIA + GRAVITY * np.sin(x[0]))
        return [x[1], (torque - 0.001 * np.hypot(along, across)) / INERTIA]

    states = solved(rates, [0.0, 14.0])
    assert states[1].min() > 0.0
    assert end(PENDULUM, {"LOAD_RADIUS": 0.001}, [0.0, 14.0]) == pytest.approx(states[0, -1], abs=1e-4)


def test_gains_fade_with_speed() -> None:
    plant = with_numbers(plant_of(1, drive="position_pd"), KP=30.0, KD=1.5)

    def rates(t: float, x: np.ndarray) -> list[float]:
        servo = (1.0 - 0.6 * abs(x[1]) / (abs(x[1]) + 1.5)) * (30.0 * (EFFORT - x[0]) - 1.5 * x[1])
        return [x[1], (servo - WEIGHT * np.sin(x[0])) / INERTIA]

    expected = solved(rates, [0.0, -3.0])[0, -1]
    assert end(plant, {"GAIN_FADE": 0.6, "GAIN_FADE_RATE": 1.5}, [0.0, -3.0]) == pytest.approx(expected, abs=2e-5)


def test_hysteresis_is_that_of_bouc_and_wen() -> None:
    def rates(t: float, x: np.ndarray) -> list[float]:
        slope = 1.0 - x[2] ** 2 if x[1] * x[2] > 0.0 else 1.0
        return [x[1], (EFFORT - WEIGHT * np.sin(x[0]) - 0.5 * x[2]) / INERTIA, x[1] / 0.3 * slope]

    expected = solved(rates, [0.6, -2.0, 0.0])[0, -1]
    assert end(PENDULUM, {"HYSTERESIS": 0.5, "HYSTERESIS_TRAVEL": 0.3}, [0.6, -2.0]) == pytest.approx(
        expected, abs=2e-4
    )


@pytest.mark.parametrize("play", [0.0, 0.2])
def test_motor_behind_a_gear_moves_the_joint_through_its_spring_and_play(play: float) -> None:
    motor, stiff, loss = 0.3 * INERTIA, 8.0, 0.1

    def rates(t: float, x: np.ndarray) -> list[float]:  # joint, its rate, motor, its rate
        twist = x[2] - x[0]
        deep = twist - 0.5 * play if twist > 0.5 * play else min(twist + 0.5 * play, 0.0)
        passed = stiff * deep + (loss * (x[3] - x[1]) if deep != 0.0 or play == 0.0 else 0.0)
        passed = 0.0 if play > 0.0 and passed * deep <= 0.0 else passed  # teeth push and never pull
        return [x[1], (passed - WEIGHT * np.sin(x[0])) / (INERTIA - motor), x[3], (EFFORT - passed) / motor]

    gear = {"MOTOR_INERTIA": motor, "ROTOR": -motor, "GEAR_STIFFNESS": stiff, "GEAR_LOSS": loss, "GEAR_PLAY": play}
    expected = solved(rates, [0.6, -2.0, 0.6, -2.0])[0, -1]
    assert end(PENDULUM, gear, [0.6, -2.0]) == pytest.approx(expected, abs=5e-4)


def test_command_filter_and_delay_hold_back_a_step() -> None:
    trial = trial_of(SLIDE, [0.0, 0.0], lambda t: np.where(t < 0.1 - 1e-9, 0.0, EFFORT)[:, None])
    plant = replace(SLIDE, drive="effort")
    filtered = Hidden(numbers={Number.FILTER_RATE: 12.0, Number.FILTER_DAMPING: 0.3}, delay_s=0.05)

    def rates(t: float, x: np.ndarray) -> list[float]:
        sent = EFFORT if t >= 0.15 else 0.0
        return [x[1], x[2] / MASS, x[3], 144.0 * (sent - x[2]) - 7.2 * x[3]]

    (q, _), *_ = observe(plant, filtered, [trial], STEP_S)
    assert q[-1, 0] == pytest.approx(solved(rates, [0.0, 0.0, 0.0, 0.0])[0, -1], abs=1e-4)


def test_encoder_filter_reads_a_steady_slide_late_by_its_group_delay() -> None:
    hidden = Hidden(numbers={Number.SENSOR_RATE: 20.0, Number.SENSOR_DAMPING: 0.4})
    (q, v), *_ = observe(SLIDE, hidden, [trial_of(SLIDE, [0.0, 1.0])], STEP_S)
    assert q[:, 0] == pytest.approx(np.linspace(0.0, LENGTH_S, 101) - 2.0 * 0.4 / 20.0, abs=1e-6)
    assert v[:, 0] == pytest.approx(np.ones(101), abs=1e-6)


def test_scale_offset_and_eccentricity_change_readings_and_no_motion() -> None:
    trial = trial_of(PENDULUM, [0.6, -2.0])
    (q, v), *_ = observe(PENDULUM, Hidden(), [trial], STEP_S)
    (scaled, rate), *_ = observe(PENDULUM, Hidden(scale=1.2, offset=0.1), [trial], STEP_S)
    assert scaled == pytest.approx(1.2 * q + 0.1)
    assert rate == pytest.approx(1.2 * v)
    (eccentric, rate), *_ = observe(PENDULUM, Hidden(eccentricity=0.1, eccentric_phase=0.4), [trial], STEP_S)
    assert eccentric == pytest.approx(q + 0.1 * np.sin(q + 0.4))
    assert rate == pytest.approx(v * (1.0 + 0.1 * np.cos(q + 0.4)))


@pytest.mark.parametrize("plant", [PENDULUM, with_numbers(SLIDE, SPRING=4.0)], ids=["pendulum", "slide"])
def test_payload_of_a_trial_sits_at_the_mass_centre(plant: Plant) -> None:
    trial = trial_of(plant, [0.6, -2.0])  # its load is 0.5
    (q, _), *_ = observe(replace(plant, drive="effort"), Hidden(payload=0.4), [trial], STEP_S)
    more = 0.2 * plant.mass * (1.0 if plant.slides else plant.lever**2)
    heavier = replace(plant, drive="effort", mass=1.2 * plant.mass, inertia=plant.inertia + more)
    (expected, _), *_ = observe(heavier, Hidden(), [trial], STEP_S)
    assert q == pytest.approx(expected, abs=1e-9)
