"""Which library effects explain a toss as well as what it hides: best refits whose starts are free."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.bodies import GRAVITY, Box, HiddenInBox, move
from tests.suites.gap2.generate.least_squares import gauss_newton
from tests.suites.gap2.generate.tosses.causes import vector
from tests.suites.gap2.generate.tosses.recording import TrackedToss
from tests.suites.gap2.generate.truth import Truth

_ROUNDS = 6
_TRIALS_REFITTED, _ROWS_REFITTED = 6, 60  # of which rivals are refitted; noncentralities are scaled to all
Make = Callable[[Array, Box], HiddenInBox]

_RIVALS: dict[str, tuple[Make, int, bool | None]] = {
    "world.gravity_magnitude": (lambda x, box: HiddenInBox(gravity=GRAVITY * (1.0 + x[0])), 1, False),
    "world.gravity_tilt": (lambda x, box: HiddenInBox(tilt=(x[0], x[1])), 2, None),
    "world.linear_drag": (lambda x, box: HiddenInBox(drag=x[0] * box.mass_kg), 1, None),
    "world.quadratic_drag": (lambda x, box: HiddenInBox(square_drag=x[0] * box.mass_kg), 1, None),
    "world.constant_force": (lambda x, box: HiddenInBox(force=vector(x * box.mass_kg * GRAVITY)), 3, None),
    "contact.friction": (lambda x, box: HiddenInBox(mu=box.mu * (1.0 + x[0])), 1, True),
    "body.com_offset": (lambda x, box: HiddenInBox(com=vector(x * box.size_m)), 3, False),
    "sensor.scale": (lambda x, box: HiddenInBox(scale=1.0 + x[0]), 1, None),
    "sensor.clock_skew": (lambda x, box: HiddenInBox(clock=1.0 + x[0]), 1, None),
}


def labelled(truth: Truth, tracked: TrackedToss, readings: Array) -> Truth:
    """The truth with what else explains the readings: best refits with free starts, of some trials and rows."""
    every = max(1, readings.shape[1] // _ROWS_REFITTED)
    share = len(readings) / min(len(readings), _TRIALS_REFITTED) * every
    tracked = replace(
        tracked, t_s=tracked.t_s[:_TRIALS_REFITTED, ::every].copy(), start=tracked.start[:_TRIALS_REFITTED]
    )
    readings = readings[:_TRIALS_REFITTED, ::every].copy()
    visible = share * _left(lambda x, box: HiddenInBox(), 0, tracked, readings)
    rivals = {
        name: float(f"{share * _left(make, count, tracked, readings):.4g}")
        for name, (make, count, slides) in _RIVALS.items()
        if slides in (None, tracked.box.slides) and name != truth.effects[0].name
    }
    near = dict(sorted((item for item in rivals.items() if item[1] < 0.5 * visible), key=lambda item: item[1]))
    return truth.with_rivals(visible, near)


def _left(make: Make, count: int, tracked: TrackedToss, readings: Array) -> float:
    """Squared noise levels that the best refit of a rival leaves."""
    x, start = np.zeros(count), readings[:, 0].copy()

    def errors(x: Array, start: Array) -> list[Array]:
        moved = move(tracked.box, make(x, tracked.box), tracked.t_s, start)
        return [e.ravel() for e in tracked.errors(moved, readings)]

    at = errors(x, start)
    cost = sum(float(e @ e) for e in at)
    free = [0, 1, 6, 7] if tracked.box.slides else list(range(12))  # of `_shifted`
    for _ in range(_ROUNDS):
        shared: list[list[Array]] = [[] for _ in at]
        for k in range(count):
            step = 1e-4 * (np.arange(count) == k)
            for columns, a, b in zip(shared, errors(x + step, start), at, strict=True):
                columns.append((a - b) / 1e-4)
        by_start: list[list[Array]] = [[] for _ in at]
        for k in free:
            moved = _shifted(start, 1e-5 * (np.arange(12) == k))
            for columns, a, b in zip(by_start, errors(x, moved), at, strict=True):
                columns.append((a - b) / 1e-5)
        step, moves = gauss_newton(shared, by_start, at, np.zeros(0), count)
        shift = np.zeros((len(start), 12))
        shift[:, free] = np.stack(moves)
        x_new, start_new = x + step, _shifted(start, shift)
        at_new = errors(x_new, start_new)
        cost_new = sum(float(e @ e) for e in at_new)
        if not cost_new < cost:
            break
        gained, x, start, at, cost = cost - cost_new, x_new, start_new, at_new, cost_new
        if gained < 0.01 * cost:
            break
    return cost


def _shifted(start: Array, by: Array) -> Array:
    """Starts moved by position, rotation vector, velocity and angular velocity ((12,) or (r, 12))."""
    by = by + np.zeros((len(start), 12))
    out = start.copy()
    out[:, :3] += by[:, :3]
    turn = Rotation.from_quat(np.roll(start[:, 3:7], -1, axis=1)) * Rotation.from_rotvec(by[:, 3:6])
    out[:, 3:7] = np.roll(turn.as_quat(), 1, axis=1)
    out[:, 7:10] += by[:, 6:9]
    out[:, 10:] += by[:, 9:]
    return out
