"""Mechanisms and recordings drawn at random: 3 cm and 5 g to 1.5 m and 50 kg; free, driven and servo-controlled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import (
    Hidden,
    Plant,
    Trial,
    believed_numbers,
    observe,
)

FREE = ("pendulum", "door", "slide", "chain2", "chain3")
DRIVEN = ("pendulum_effort", "door_effort", "slide_effort", "chain2_effort", "chain3_effort")
SERVO = ("pendulum_servo", "slide_servo", "chain2_servo")
SCENES = (*FREE, *DRIVEN, *SERVO)
PUSHED = (*DRIVEN, *SERVO)
UPRIGHT = tuple(s for s in SCENES if s.startswith(("pendulum", "chain")))
TURNING = tuple(s for s in SCENES if s.startswith(("pendulum", "door")))
# Of one joint.
SINGLE = tuple(s for s in SCENES if not s.startswith("chain"))
SINGLE_FREE, SINGLE_DRIVEN, SINGLE_SERVO = (tuple(s for s in kind if s in SINGLE) for kind in (FREE, DRIVEN, SERVO))
SINGLE_PUSHED = (*SINGLE_DRIVEN, *SINGLE_SERVO)
SINGLE_UPRIGHT = tuple(s for s in SINGLE if s in UPRIGHT)
SMALLEST_M, LARGEST_M = 0.03, 1.5
LIGHTEST_KG, HEAVIEST_KG = 0.005, 50.0
_LEAD_S = 0.1  # the mechanism runs that long before the first row, so that late sensors have something to read
_MOST_ROWS = 8000
_MOST_S = 60.0  # of all trials together


@dataclass(frozen=True)
class Recording:
    """How a mechanism was recorded.

    sigma       noise of positions, one standard deviation, quantisation included (rad or m).
    step_s      of the truth's integrator; horizon_s of the restarts that size an effect.
    period_s    the mechanism's own time.
    """

    trials: tuple[Trial, ...]
    rate_hz: float
    sigma: float
    horizon_s: float
    period_s: float
    step_s: float


@dataclass(frozen=True)
class Sizes:
    """Magnitudes at one joint of the believed motion: net torque, speed, half the travel, its ends, largest effort."""

    torque: float
    speed: float
    reach: float
    low: float
    high: float
    effort: float
    inertia: float
    period_s: float


def draw_plant(scene: str, rng: np.random.Generator, *, rubs: bool = False, bare: bool = False) -> tuple[Plant, float]:
    """A mechanism and its own time (s); with `rubs` its owner knows of dry friction at each joint, `bare` of none."""
    shape, _, drive = scene.partition("_")
    n = {"chain2": 2, "chain3": 3}.get(shape, 1)
    slides, upright = shape == "slide", shape not in ("slide", "door")
    length = np.exp(rng.uniform(np.log(SMALLEST_M), np.log(LARGEST_M))) * rng.uniform(0.7, 1.0, n)
    mass = np.clip(20.0 * length**2 * np.exp(rng.normal(0.0, 0.7, n)), LIGHTEST_KG, HEAVIEST_KG)
    lever = np.zeros(n) if slides else length * rng.uniform(0.35, 0.7, n)
    inertia = mass.copy() if slides else mass * lever**2 * (1.0 + rng.uniform(0.08, 0.5, n))
    offset = np.concatenate([[0.0], length[:-1]])
    numbers = believed_numbers(n)
    numbers[:, Number.MASS], numbers[:, Number.LEVER] = mass, lever
    plant = Plant(scene, _DRIVES[drive], slides, upright, inertia, mass, lever, offset, numbers)
    A, W = plant.couplings()
    if upright:
        period = float(2.0 * np.pi * np.sqrt(A[0, 0] / W[0].sum()))
    else:
        period = float(np.exp(rng.uniform(np.log(0.6), np.log(3.0))))
    about_axis = np.diag(A).copy()
    pace = 2.0 * np.pi / period
    if drive == "servo":
        pace = float(pace * rng.uniform(2.0, 4.0)) if upright else float(2.0 * np.pi * rng.uniform(0.8, 3.0))
        numbers[:, Number.KP] = about_axis * pace**2
        numbers[:, Number.KD] = 2.0 * rng.uniform(0.4, 1.0) * about_axis * pace
        period = 2.0 * np.pi / pace
    reach = length if slides else np.ones(n)
    force = about_axis * pace**2 * reach * (1.0 if not upright else 0.5)
    if rubs or rng.random() < 0.6:
        numbers[:, Number.COULOMB] = force * rng.uniform(0.01, 0.06)
    if not upright and drive == "":  # what only coasts must come to rest
        numbers[:, Number.VISCOUS] = about_axis * pace * rng.uniform(0.08, 0.3)
    elif rng.random() < 0.7:
        numbers[:, Number.VISCOUS] = about_axis * pace * rng.uniform(0.01, 0.1)
    if bare:
        numbers[:, [Number.COULOMB, Number.VISCOUS]] = 0.0
    return plant, period


def draw_recording(plant: Plant, period_s: float, rng: np.random.Generator, *, supply: bool = False) -> Recording:
    """Stamps, inputs, starts and noise of 6 to 30 trials of 1 to 10 s at 30 to 1000 Hz."""
    slowest = max(30.0, 20.0 / period_s)
    rate = float(np.exp(np.log(slowest) + rng.random() ** 1.5 * (np.log(1000.0) - np.log(slowest))))
    length_s = float(np.clip(period_s * rng.uniform(2.0, 8.0), 1.0, 10.0))
    count = int(rng.integers(6, 31))
    length_s = max(1.0, min(length_s, _MOST_S / 6, _MOST_ROWS / 6 / rate))
    count = int(np.clip(count, 6, max(6, min(_MOST_S / length_s, _MOST_ROWS / rate / length_s))))
    jitter = float(rng.choice([0.0, 0.01, 0.05]))
    dropped = float(rng.choice([0.0, 0.0, 0.01, 0.03]))
    scale = float(plant.mass[0] / 20.0) ** 0.5 if plant.slides else 1.0
    sigma = scale * float(np.exp(rng.uniform(np.log(2e-4), np.log(3e-3))))
    stamps = [_stamps(length_s, rate, jitter, dropped, rng) for _ in range(count)]
    sags = supply or rng.random() < 0.35
    trials = []
    for t in stamps:
        inputs, start = _excitation(plant, period_s, t, rng)
        trials.append(
            Trial(
                t,
                inputs,
                _supply(t, rng) if sags else np.ones(len(t)),
                start,
                float(rng.uniform(0.0, 2.0 * np.pi)),
                float(rng.uniform(-1.0, 1.0)),
            )
        )
    return Recording(
        tuple(trials),
        rate,
        sigma,
        float(np.clip(0.2 * period_s, max(0.1, 4.0 / rate), 0.5)),
        period_s,
        float(np.clip(period_s / 800.0, 2.5e-4, 2e-3)),
    )


def sizes_of(plant: Plant, recording: Recording, joint: int) -> Sizes:
    """Magnitudes of the believed motion at a joint."""
    readings = observe(plant, Hidden(), recording.trials, recording.step_s)
    q = np.concatenate([q[:, joint] for q, _ in readings])
    v = np.concatenate([v[:, joint] for _, v in readings])
    rises = [np.gradient(v[:, joint], t.stamps_s) for (_, v), t in zip(readings, recording.trials, strict=True)]
    about_axis = float(plant.couplings()[0][joint, joint])
    low, high = np.quantile(q, [0.01, 0.99])
    effort = 0.0
    if plant.drive != "none":
        sent = np.concatenate([t.inputs[:, joint] for t in recording.trials])
        numbers = plant.numbers[joint]
        given = sent if plant.drive == "effort" else numbers[Number.KP] * (sent - q) - numbers[Number.KD] * v
        effort = float(np.quantile(np.abs(given), 0.98))
    return Sizes(
        float(np.quantile(np.abs(np.concatenate(rises)), 0.9)) * about_axis,
        float(np.quantile(np.abs(v), 0.9)),
        0.5 * float(high - low),
        float(low),
        float(high),
        effort,
        about_axis,
        recording.period_s,
    )


_DRIVES = {"": "none", "effort": "effort", "servo": "position_pd"}


def _stamps(length_s: float, rate: float, jitter: float, dropped: float, rng: np.random.Generator) -> Array:
    rows = max(int(length_s * rate), 30)
    t = _LEAD_S + (np.arange(rows) + np.clip(rng.normal(0.0, jitter, rows), -0.3, 0.3)) / rate
    written = rng.random(rows) >= dropped
    written[[0, -1]] = True
    return np.round(t[written], 6)  # as a file holds them: the mechanism's inputs change at the same instants


def _supply(t: Array, rng: np.random.Generator) -> Array:
    """Relative supply voltage: falls within a trial, from another level in each."""
    knots = np.cumsum(rng.normal(-0.01, 0.04, 8)) + rng.uniform(-0.1, 0.02)
    return np.clip(1.0 + np.interp(t, np.linspace(t[0], t[-1], 8), knots), 0.6, 1.1)


def _excitation(plant: Plant, period_s: float, t: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Inputs (rows, n) and the start (2 n,) at time 0."""
    n, pace = plant.joints, 2.0 * np.pi / period_s
    inputs = np.zeros((len(t), n))
    length = np.sqrt(plant.mass / 20.0) if plant.slides else np.ones(n)
    ways = rng.choice([-1.0, 1.0], n)
    if plant.drive == "none":
        if plant.upright:
            most = 2.2 if n == 1 else 1.2
            start = ways * rng.uniform(0.4, most, n)
            return inputs, np.concatenate([start, rng.normal(0.0, 0.2, n) * pace])
        speed = ways * rng.uniform(0.3, 1.5, n) * pace * length * 0.25
        return inputs, np.concatenate([rng.uniform(-0.3, 0.3, n) * length, speed])
    tones = 4
    rates = pace * rng.uniform(0.25, 1.6, (tones, n)) * (0.5 if plant.drive == "position_pd" else 1.0)
    phases = rng.uniform(0.0, 2.0 * np.pi, (tones, n))
    heights = rng.uniform(0.15, 0.45, (tones, n)) * length
    angle = rates * t[:, None, None] + phases
    q = (heights * np.sin(angle)).sum(axis=1)
    if plant.drive == "position_pd":
        step_s = period_s * rng.uniform(2.0, 4.0)
        q = q + 0.3 * length * np.sign(np.sin(np.pi * t / step_s))[:, None] * (rng.random() < 0.5)
        return q, np.concatenate([q[0], np.zeros(n)])
    v = (heights * rates * np.cos(angle)).sum(axis=1)
    a = -(heights * rates**2 * np.sin(angle)).sum(axis=1)
    A, W = plant.couplings()
    first = (heights * np.sin(phases)).sum(axis=0), (heights * rates * np.cos(phases)).sum(axis=0)
    if n == 1:
        numbers = plant.numbers[0]
        needed = A[0, 0] * a + W[0, 0] * np.sin(q) + numbers[Number.VISCOUS] * v + numbers[Number.COULOMB] * np.sign(v)
        return needed, np.concatenate(first)
    return 0.5 * W.sum(axis=1) * q / tones, np.zeros(2 * n)


def rows_of(trials: Sequence[Trial]) -> int:
    """Rows of all trials."""
    return sum(len(t.stamps_s) for t in trials)
