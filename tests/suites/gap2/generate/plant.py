"""A mechanism as its owner believes it, what is hidden in it, and its noise-free readings; SI."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tests.suites.gap2.generate import kernel
from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.parameters import NEUTRAL, Number

GRAVITY = 9.81  # m/s2
DRIVES = {"none": kernel.FREE, "effort": kernel.EFFORT, "position_pd": kernel.POSITION}
_NANOSECONDS = 9  # decimals to which instants are merged
_INSTANT_S = 2e-4  # filters that are faster are delays


@dataclass(frozen=True)
class Plant:
    """The believed mechanism.

    inertia, mass, lever   (n,) of each link about its own axis (kg m2; kg for a slide), kg, m to its mass centre.
    offset_m               (n,) from the parent's axis to each joint's; 0 for the first.
    numbers                (n, Number) of the equations as believed.
    """

    scene: str
    drive: str
    slides: bool
    upright: bool  # feels gravity
    inertia: Array
    mass: Array
    lever: Array
    offset_m: Array
    numbers: Array

    @property
    def joints(self) -> int:
        """Number of joints."""
        return len(self.inertia)

    def number(self, joint: int, which: Number) -> float:
        """A believed number of a joint."""
        return float(self.numbers[joint, which])

    def couplings(self) -> tuple[Array, Array]:
        """A (n, n) kg m2 of absolute angles, and W (n, n) N m: the weight of link k on joint i, link hanging level."""
        n = self.joints
        A, W = np.zeros((n, n)), np.zeros((n, n))
        for i in range(n):
            A[i, i] = self.inertia[i] + sum(self.mass[k] * self.offset_m[i + 1] ** 2 for k in range(i + 1, n))
            W[i, i] = self.mass[i] * self.lever[i]
            for k in range(i + 1, n):
                W[i, k] = self.mass[k] * self.offset_m[i + 1]
                beyond = sum(self.mass[m] * self.offset_m[i + 1] * self.offset_m[k + 1] for m in range(k + 1, n))
                A[i, k] = A[k, i] = self.mass[k] * self.offset_m[i + 1] * self.lever[k] + beyond
        return A, W * (GRAVITY if self.upright else 0.0)


def _settle(numbers: Array) -> tuple[float, float, float]:
    """(step, delay, latency) in s: the step that the fastest part of a joint allows, and filters too fast for any step.

    A filter that is faster than `_INSTANT_S` is late by its group delay and does nothing else; it leaves `numbers`.
    """
    late, times = [0.0, 0.0], []
    filters = ((0, Number.LAG, Number.FILTER_RATE, Number.FILTER_DAMPING),)
    filters += ((1, Number.SENSOR_LAG, Number.SENSOR_RATE, Number.SENSOR_DAMPING),)
    for side, lag, rate, damping in filters:
        if 0.0 < numbers[lag] < _INSTANT_S:
            late[side] += numbers[lag]
            numbers[lag] = 0.0
        if numbers[rate] * _INSTANT_S > 1.0:
            late[side] += 2.0 * numbers[damping] / numbers[rate]
            numbers[rate] = 0.0
        times += [numbers[lag], 1.0 / numbers[rate] if numbers[rate] else 0.0]
    motor, stiffest = numbers[Number.MOTOR_INERTIA], numbers[Number.MOTOR_INERTIA] / (2.0 * _INSTANT_S) ** 2
    if numbers[Number.GEAR_STIFFNESS] > stiffest:
        numbers[Number.GEAR_STIFFNESS] = stiffest
        numbers[Number.GEAR_LOSS] = min(numbers[Number.GEAR_LOSS], np.sqrt(stiffest * motor))
    times.append(0.5 * np.sqrt(motor / numbers[Number.GEAR_STIFFNESS]) if motor else 0.0)
    return min((float(t) for t in times if t > 0.0), default=np.inf), float(late[0]), float(late[1])


def believed_numbers(joints: int) -> Array:
    """(n, Number): nothing but inertia and gravity."""
    numbers = np.zeros((joints, len(Number)))
    for which, value in NEUTRAL.items():
        numbers[:, which] = value
    return numbers


@dataclass(frozen=True)
class Hidden:
    """What differs from belief: numbers of one joint, and errors of clock and sensor.

    payload   share of the mass by which a trial's load may differ; each trial has its own draw.
    step_s    with a positive one, a semi-implicit Euler integrator of that step makes the motion.
    """

    joint: int = 0
    numbers: Mapping[Number, float] = field(default_factory=dict)
    delay_s: float = 0.0
    latency_s: float = 0.0
    clock: float = 1.0
    scale: float = 1.0
    offset: float = 0.0
    eccentricity: float = 0.0
    eccentric_phase: float = 0.0
    eccentric_count: float = 1.0
    payload: float = 0.0
    step_s: float = 0.0

    def beside(self, other: Hidden) -> Hidden:
        """Both at once; they must act on the same joint."""
        plain = Hidden()
        changes = {
            name: getattr(other, name)
            for name in self.__dataclass_fields__
            if name not in ("joint", "numbers") and getattr(other, name) != getattr(plain, name)
        }
        return replace(self, numbers={**self.numbers, **other.numbers}, **changes)


@dataclass(frozen=True)
class Trial:
    """What a trial was set up to do: stamps (rows,), inputs (rows, n) held from stamp to stamp, start (2 n,) at time 0.

    supply (rows,) is relative to its nominal value; phase and load are the trial's own draws for shaking and payload.
    """

    stamps_s: Array
    inputs: Array
    supply: Array
    start: Array
    phase: float
    load: float


@dataclass(frozen=True)
class Segment:
    """Rows `first` to `last` (exclusive) of a trial, started at `start` (2 n,) at time `from_s` of the mechanism."""

    trial: int
    first: int
    last: int
    start: Array
    from_s: float


def observe(plant: Plant, hidden: Hidden, trials: Sequence[Trial], step_s: float) -> list[tuple[Array, Array]]:
    """Noise-free readings of positions and rates (rows, n) of whole trials."""
    whole = [Segment(i, 0, len(t.stamps_s), t.start, 0.0) for i, t in enumerate(trials)]
    return read_segments(plant, hidden, trials, whole, step_s)


def read_segments(
    plant: Plant, hidden: Hidden, trials: Sequence[Trial], segments: Sequence[Segment], step_s: float
) -> list[tuple[Array, Array]]:
    """Readings (rows, n) and their rates by segment."""
    n, joint = plant.joints, hidden.joint
    numbers = plant.numbers.copy()
    for which, value in hidden.numbers.items():
        numbers[joint if which != Number.TILT else 0, which] = value
    fastest_s, delay_s, latency_s = _settle(numbers[joint])
    step_s, delay_s, latency_s = min(step_s, fastest_s), hidden.delay_s + delay_s, hidden.latency_s + latency_s
    A, W = plant.couplings()
    breaks, inputs, supply, reads, early = [], [], [], [], []
    for s in segments:
        trial = trials[s.trial]
        stamps = trial.stamps_s / hidden.clock
        when = stamps[s.first : s.last] - latency_s
        switch = stamps + delay_s
        inside = switch[(switch > s.from_s) & (switch <= when[-1] + 1e-9)]
        t = np.unique(np.round(np.concatenate([[s.from_s], inside, when[when > s.from_s]]), _NANOSECONDS))
        row = np.maximum(np.searchsorted(np.round(switch, _NANOSECONDS), t, side="right") - 1, 0)
        breaks.append(t)
        inputs.append(trial.inputs[row])
        supply.append(trial.supply[row])
        reads.append(np.searchsorted(t, np.round(np.maximum(when, s.from_s), _NANOSECONDS)))
        early.append(np.minimum(when - s.from_s, 0.0))
    offsets = np.concatenate([[0], np.cumsum([len(t) for t in breaks])])
    states = kernel.integrate_runs(
        n, A, W, numbers, DRIVES[plant.drive], joint, offsets, np.concatenate(breaks), np.concatenate(inputs),
        np.concatenate(supply), np.array([s.start for s in segments], dtype=float),
        np.array([trials[s.trial].phase for s in segments]),
        np.array([hidden.payload * trials[s.trial].load for s in segments]),
        kernel.EULER if hidden.step_s else kernel.RUNGE_KUTTA, hidden.step_s or step_s,
    )  # fmt: skip
    filtered = numbers[joint, Number.SENSOR_LAG] > 0.0 or numbers[joint, Number.SENSOR_RATE] > 0.0
    out = []
    for first, rows, before in zip(offsets[:-1], reads, early, strict=True):
        state = states[first + rows]
        q, v = state[:, :n].copy(), state[:, n : 2 * n].copy()
        if filtered:
            q[:, joint], v[:, joint] = state[:, 2 * n], state[:, 2 * n + 1]
        q += before[:, None] * v
        if hidden.eccentricity:
            turn = hidden.eccentric_count * q[:, joint] + hidden.eccentric_phase
            q[:, joint] += hidden.eccentricity * np.sin(turn)
            v[:, joint] *= 1.0 + hidden.eccentricity * hidden.eccentric_count * np.cos(turn)
        q[:, joint] = hidden.scale * q[:, joint] + hidden.offset
        v[:, joint] *= hidden.scale
        out.append((q, v / hidden.clock))
    return out
