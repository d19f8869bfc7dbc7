"""Tosses drawn at random, and how far belief misses their readings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.bodies import GRAVITY, Box, HiddenInBox, move


@dataclass(frozen=True)
class TrackedToss:
    """Stamps (r, rows), starts (r, 13) and noise of position (m) and rotation (rad)."""

    box: Box
    t_s: Array
    start: Array
    sigma_m: float
    sigma_rad: float
    rate_hz: float

    def errors(self, a: Array, b: Array) -> Array:
        """(r, rows, 6) in noise levels: positions, rotation vectors."""
        turn = Rotation.from_quat(np.roll(a[..., 3:7].reshape(-1, 4), -1, axis=1)).inv()
        turn = turn * Rotation.from_quat(np.roll(b[..., 3:7].reshape(-1, 4), -1, axis=1))
        turned = turn.as_rotvec().reshape(*a.shape[:2], 3)
        return np.concatenate([(a[..., :3] - b[..., :3]) / self.sigma_m, turned / self.sigma_rad], axis=2)

    def miss(self, readings: Array, horizon_s: float) -> float:
        """Noise levels by which belief misses positions and rotations when restarted every `horizon_s`."""
        window = readings.shape[1] if np.isinf(horizon_s) else max(2, round(horizon_s * self.rate_hz) + 1)
        firsts = range(0, readings.shape[1] - window + 1, window - 1)
        t = np.concatenate([self.t_s[:, i : i + window] for i in firsts])
        true = np.concatenate([readings[:, i : i + window] for i in firsts])
        error = self.errors(move(self.box, HiddenInBox(), t, true[:, 0]), true)[:, 1:]
        # A cause that moves positions alone is not made small by rotations that it leaves as they are.
        return float(np.sqrt(0.5 * max(np.mean(error[..., :3] ** 2), np.mean(error[..., 3:] ** 2))))


def draw_tumble(rng: np.random.Generator) -> TrackedToss:
    """A box of 3 to 40 cm that is thrown from about its length above the board, 8 to 30 trials at 60 to 500 Hz.

    Trials last ten to fifteen times as long as it falls its length.
    """
    length = float(np.exp(rng.uniform(np.log(0.03), np.log(0.4))))
    size = length * rng.uniform(0.5, 1.0, 3)
    mass = float(np.exp(rng.uniform(np.log(150.0), np.log(1500.0))) * size.prod())
    box = Box(size, mass, float(rng.uniform(0.2, 0.5)), slides=False, tumbles=True)
    rate, fall_s = float(np.exp(rng.uniform(np.log(60.0), np.log(500.0)))), float(np.sqrt(length / GRAVITY))
    trials, rows = int(rng.integers(8, 31)), max(30, int(rng.uniform(10.0, 15.0) * fall_s * rate))
    jitter = float(rng.choice([0.0, 0.01, 0.05]))
    t = np.round((np.arange(rows) + np.clip(rng.normal(0.0, jitter, (trials, rows)), -0.2, 0.2)) / rate, 6)
    t -= t[:, :1]
    start = np.zeros((trials, 13))
    aim, speed = rng.uniform(0.0, 2.0 * np.pi, trials), rng.uniform(0.3, 1.6, trials) * length / fall_s
    start[:, 2] = rng.uniform(1.0, 2.0, trials) * float(np.linalg.norm(size))
    start[:, 3:7] = np.roll(Rotation.random(trials, rng=rng).as_quat(), 1, axis=1)
    start[:, 7], start[:, 8] = speed * np.cos(aim), speed * np.sin(aim)
    start[:, 10:] = rng.normal(0.0, 0.3, (trials, 3)) / fall_s
    sigma = length * float(np.exp(rng.uniform(np.log(5e-4), np.log(3e-3))))
    return TrackedToss(box, t, start, sigma, float(rng.uniform(2e-3, 8e-3)), rate)


def draw_toss(slides: bool, rng: np.random.Generator) -> TrackedToss:
    """A box of 3 to 40 cm, 8 to 30 trials at 60 to 500 Hz."""
    length = float(np.exp(rng.uniform(np.log(0.03), np.log(0.4))))
    size = length * rng.uniform(0.5, 1.0, 3)
    box = Box(
        size, float(np.exp(rng.uniform(np.log(150.0), np.log(1500.0))) * size.prod()), rng.uniform(0.2, 0.5), slides
    )
    rate = float(np.exp(rng.uniform(np.log(60.0), np.log(500.0))))
    trials, span = int(rng.integers(8, 31)), float(rng.uniform(0.5, 1.0))
    rows = int(span * rate)
    jitter = float(rng.choice([0.0, 0.01, 0.05]))
    t = np.round((np.arange(rows) + np.clip(rng.normal(0.0, jitter, (trials, rows)), -0.2, 0.2)) / rate, 6)
    t -= t[:, :1]
    start = np.zeros((trials, 13))
    aim = rng.uniform(0.0, 2.0 * np.pi, trials)
    if slides:
        speed = rng.uniform(0.5, 1.2, trials) * box.mu * GRAVITY * span
        start[:, 2] = 0.5 * size[2]
        start[:, 3:7] = np.roll(
            Rotation.from_rotvec(rng.uniform(-3, 3, (trials, 1)) * [[0, 0, 1]]).as_quat(), 1, axis=1
        )
    else:
        speed = rng.uniform(1.0, 4.0, trials)
        start[:, 2] = rng.uniform(1.0, 1.5, trials)
        start[:, 3:7] = np.roll(Rotation.random(trials, rng=rng).as_quat(), 1, axis=1)
        start[:, 9] = rng.uniform(1.0, 4.0, trials)
        start[:, 10:] = rng.normal(0.0, 4.0, (trials, 3))
    start[:, 7], start[:, 8] = speed * np.cos(aim), speed * np.sin(aim)
    sigma = float(np.exp(rng.uniform(np.log(1e-4), np.log(1e-3))))
    return TrackedToss(box, t, start, sigma, float(rng.uniform(2e-3, 8e-3)), rate)
