"""The generator's equations of motion against energy, closed forms and SciPy on equations of another form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import GRAVITY, Hidden, Plant, Trial, believed_numbers, observe

STEP_S = 1e-3
LENGTH_S = 1.0


def plant_of(links: int, *, slides: bool = False, upright: bool = True, drive: str = "none") -> Plant:
    mass, length = np.array([1.2, 0.7, 0.4])[:links], np.array([0.4, 0.3, 0.25])[:links]
    lever = np.zeros(links) if slides else 0.55 * length
    inertia = mass.copy() if slides else 1.3 * mass * lever**2
    numbers = believed_numbers(links)
    numbers[:, Number.MASS], numbers[:, Number.LEVER] = mass, lever
    offset = np.concatenate([[0.0], length[:-1]])
    return Plant("a test", drive, slides, upright, inertia, mass, lever, offset, numbers)


def with_numbers(plant: Plant, **values: float) -> Plant:
    numbers = plant.numbers.copy()
    for name, value in values.items():
        numbers[:, Number[name]] = value
    return replace(plant, numbers=numbers)


def trial_of(plant: Plant, start: list[float], inputs=None, rows: int = 101) -> Trial:
    t = np.linspace(0.0, LENGTH_S, rows)
    given = np.zeros((rows, plant.joints)) if inputs is None else inputs(t)
    return Trial(t, given, np.ones(rows), np.array(start, dtype=float), 0.3, 0.5)


def mass_matrix(plant: Plant, q: np.ndarray) -> np.ndarray:
    """From the Jacobians of the links' mass centres, in joint angles: not the kernel's formula."""
    n, M = plant.joints, np.zeros((plant.joints, plant.joints))
    if plant.slides:
        return np.diag(plant.mass)
    angle = np.cumsum(q)
    for link in range(n):
        J = np.zeros((2, n))
        for joint in range(link + 1):
            for part in range(joint, link + 1):
                r = plant.lever[link] if part == link else plant.offset_m[part + 1]
                J[:, joint] += r * np.array([np.cos(angle[part]), np.sin(angle[part])])
        turns = np.where(np.arange(n) <= link, 1.0, 0.0)
        about_centre = plant.inertia[link] - plant.mass[link] * plant.lever[link] ** 2
        M += plant.mass[link] * J.T @ J + about_centre * np.outer(turns, turns)
    return M


def potential(plant: Plant, q: np.ndarray) -> float:
    angle, total = np.cumsum(q), 0.0
    for link in range(plant.joints if plant.upright else 0):
        height = -sum(plant.offset_m[k + 1] * np.cos(angle[k]) for k in range(link))
        total += plant.mass[link] * GRAVITY * (height - plant.lever[link] * np.cos(angle[link]))
    return total


def reference(plant: Plant, start: list[float], torque) -> np.ndarray:
    """Final positions by SciPy: Lagrange's equations with derivatives of M and V by central differences."""
    n, e = plant.joints, 1e-5

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        q, v = x[:n], x[n : 2 * n]
        steps = e * np.eye(n)
        dM = [(mass_matrix(plant, q + s) - mass_matrix(plant, q - s)) / (2 * e) for s in steps]
        dV = np.array([(potential(plant, q + s) - potential(plant, q - s)) / (2 * e) for s in steps])
        whirl = sum(dM[k] * v[k] for k in range(n)) @ v - 0.5 * np.array([v @ dM[k] @ v for k in range(n)])
        return np.concatenate([v, np.linalg.solve(mass_matrix(plant, q), torque(t, q, v) - whirl - dV)])

    return solve_ivp(rates, (0.0, LENGTH_S), start, rtol=1e-9, atol=1e-10, method="DOP853").y[:n, -1]


@pytest.mark.parametrize("links", [1, 2, 3])
def test_energy_stays_without_friction(links: int) -> None:
    plant = plant_of(links)
    (q, v), *_ = observe(plant, Hidden(), [trial_of(plant, [1.1] * links + [0.5] * links)], STEP_S)
    energy = [0.5 * b @ mass_matrix(plant, a) @ b + potential(plant, a) for a, b in zip(q, v, strict=True)]
    assert np.ptp(energy) < 1e-6 * abs(potential(plant, np.zeros(links)))


@pytest.mark.parametrize(
    ("links", "slides", "upright"),
    [(1, False, True), (1, False, False), (1, True, False), (2, False, True), (3, False, True)],
)
def test_free_motion_with_drag_is_that_of_scipy(links: int, slides: bool, upright: bool) -> None:
    plant = with_numbers(
        plant_of(links, slides=slides, upright=upright), VISCOUS=0.05, QUADRATIC=0.02, SPRING=0.4, SPRING_REST=0.1
    )
    start = [0.6] * links + [0.8] * links
    (q, _), *_ = observe(plant, Hidden(), [trial_of(plant, start)], STEP_S)
    expected = reference(plant, start, lambda t, q, v: -0.05 * v - 0.02 * v * np.abs(v) - 0.4 * (q - 0.1))
    assert q[-1] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("links", [1, 2])
def test_efforts_held_from_row_to_row_move_it_as_in_scipy(links: int) -> None:
    plant = plant_of(links, drive="effort")
    trial = trial_of(plant, [0.0] * 2 * links, lambda t: np.tile(np.where(t < 0.5, 0.8, -0.4)[:, None], links), rows=11)

    def torque(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.full(links, 0.8 if t < 0.5 else -0.4)

    (q, _), *_ = observe(plant, Hidden(), [trial], STEP_S)
    n = links
    first = solve_stages(plant, [0.0] * 2 * n, [(0.5, torque(0.0, q, q)), (0.5, torque(0.9, q, q))])
    assert q[-1] == pytest.approx(first, abs=1e-6)


def solve_stages(plant: Plant, start: list[float], stages: list[tuple[float, np.ndarray]]) -> np.ndarray:
    """Final positions under constant torques one after another (durations in s)."""
    n, e, x = plant.joints, 1e-5, np.array(start)
    for duration, torque in stages:

        def rates(_: float, x: np.ndarray, torque: np.ndarray = torque) -> np.ndarray:
            q, v = x[:n], x[n:]
            dM = [(mass_matrix(plant, q + s) - mass_matrix(plant, q - s)) / (2 * e) for s in e * np.eye(n)]
            dV = np.array([(potential(plant, q + s) - potential(plant, q - s)) / (2 * e) for s in e * np.eye(n)])
            whirl = sum(dM[k] * v[k] for k in range(n)) @ v - 0.5 * np.array([v @ m @ v for m in dM])
            return np.concatenate([v, np.linalg.solve(mass_matrix(plant, q), torque - whirl - dV)])

        x = solve_ivp(rates, (0.0, duration), x, rtol=1e-10, atol=1e-12, method="DOP853").y[:, -1]
    return x[:n]


def test_servo_with_a_lagging_command_is_that_of_scipy() -> None:
    plant = with_numbers(plant_of(1, drive="position_pd"), KP=30.0, KD=1.5, VISCOUS=0.1)
    trial = trial_of(plant, [0.0, 0.0], lambda t: np.full((len(t), 1), 0.7))
    hidden = Hidden(numbers={Number.LAG: 0.05, Number.SENSOR_LAG: 0.02})
    (q, _), *_ = observe(plant, hidden, [trial], STEP_S)
    weight, inertia = float(plant.mass[0] * GRAVITY * plant.lever[0]), float(plant.inertia[0])

    def rates(_: float, x: np.ndarray) -> list[float]:  # position, rate, reading; the lag starts at the first command
        torque = 30.0 * (0.7 - x[0]) - 1.6 * x[1] - weight * np.sin(x[0])
        return [x[1], torque / inertia, (x[0] - x[2]) / 0.02]

    expected = solve_ivp(rates, (0.0, LENGTH_S), [0.0, 0.0, 0.0], rtol=1e-10, atol=1e-12).y[2, -1]
    assert q[-1, 0] == pytest.approx(expected, abs=1e-6)


def test_dry_friction_stops_a_slide_where_it_should() -> None:
    plant = with_numbers(plant_of(1, slides=True, upright=False), COULOMB=1.8)
    (q, v), *_ = observe(plant, Hidden(), [trial_of(plant, [0.0, 1.0])], STEP_S)
    assert q[-1, 0] == pytest.approx(0.5 * 1.2 / 1.8, abs=1e-7)  # m v^2 / 2 F
    assert v[-1, 0] == 0.0


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_dry_friction_holds_until_the_effort_exceeds_it(way: float) -> None:
    plant = with_numbers(plant_of(1, slides=True, upright=False, drive="effort"), COULOMB=1.0)
    trial = trial_of(plant, [0.2, 0.0], lambda t: way * 2.0 * t[:, None])
    (q, _), *_ = observe(plant, Hidden(), [trial], STEP_S)
    assert np.all(q[trial.stamps_s <= 0.5, 0] == 0.2)
    expected = 0.2 + way * 2.0 * 0.5**3 / 6.0 / 1.2  # inputs are held from row to row: a little less
    assert q[-1, 0] == pytest.approx(expected, abs=2e-3)


def test_friction_holds_one_joint_of_a_chain_while_the_other_moves() -> None:
    plant = plant_of(2)
    numbers = plant.numbers.copy()
    numbers[1, Number.COULOMB] = 5.0
    (q, _), *_ = observe(replace(plant, numbers=numbers), Hidden(), [trial_of(plant, [1.0, 0.3, 0.0, 0.0])], STEP_S)
    assert np.all(q[:, 1] == 0.3)
    assert np.ptp(q[:, 0]) > 0.5


def test_late_sensor_reads_the_past_and_a_fast_clock_stretches_time() -> None:
    plant = plant_of(1)
    trial = trial_of(plant, [1.0, 0.0])
    later = replace(trial, stamps_s=trial.stamps_s + 0.1)
    (q, v), *_ = observe(plant, Hidden(), [trial], STEP_S)
    (late, _), *_ = observe(plant, Hidden(latency_s=0.1), [later], STEP_S)
    assert late == pytest.approx(q, abs=1e-9)
    (_, fast), *_ = observe(plant, Hidden(clock=1.25), [replace(trial, stamps_s=1.25 * trial.stamps_s)], STEP_S)
    assert fast == pytest.approx(v / 1.25, abs=1e-8)
