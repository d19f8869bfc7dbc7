"""Thrown, sliding and tumbling boxes by integrators of their own; SI.

States (r, 13) are what a tracker of the body's origin reads without noise: position, quaternion wxyz, velocity in the
world, angular velocity in the body. All runs of a call advance together, from row to row.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.flight import flight_rates, flight_step, njit
from tests.suites.gap2.generate.tumbling import box_corners, on_board, tumble_runs

GRAVITY = 9.81  # m/s2
_LARGEST_STEP_S = 2e-3


@dataclass(frozen=True)
class Box:
    """A box as its owner believes it: edges (3,) m, mass kg, friction with the board; it slides, tumbles or flies."""

    size_m: Array
    mass_kg: float
    mu: float
    slides: bool
    tumbles: bool = False

    @property
    def inertia_kgm2(self) -> Array:
        """(3,) of an evenly filled box."""
        x, y, z = self.size_m**2
        return self.mass_kg / 12.0 * np.array([y + z, x + z, x + y])


@dataclass(frozen=True)
class HiddenInBox:
    """What differs from belief; vectors are (3,)."""

    gravity: float = GRAVITY
    tilt: tuple[float, float] = (0.0, 0.0)  # rotation vector of gravity about x and y
    drag: float = 0.0  # N s/m
    square_drag: float = 0.0  # N s2/m2
    force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mu: float | None = None
    com: tuple[float, float, float] = (0.0, 0.0, 0.0)
    scale: float = 1.0
    clock: float = 1.0
    lift: float = 0.0  # kg: force = lift * angular velocity x velocity
    gust: float = 0.0  # N, of a side wind that comes and goes
    rough: float = 0.0  # share by which friction varies over the board
    rough_count: float = 20.0  # 1/m
    fading: float = 0.0  # share of friction that speed takes away

    def beside(self, other: HiddenInBox) -> HiddenInBox:
        """Both at once."""
        plain = HiddenInBox()
        names = [n for n in self.__dataclass_fields__ if getattr(other, n) != getattr(plain, n)]
        return replace(self, **{n: getattr(other, n) for n in names})


def move(box: Box, hidden: HiddenInBox, t_s: Array, start: Array) -> Array:
    """Readings (r, rows, 13) at stamps (r, rows), from the readings (r, 13) at the first rows."""
    t = t_s / hidden.clock
    x = start.copy()
    x[:, :3] /= hidden.scale
    x[:, 7:10] *= hidden.clock / hidden.scale
    x[:, 10:] *= hidden.clock
    com = np.array(hidden.com)
    turn = _rotation(x[:, 3:7])
    x[:, :3] += turn.apply(np.tile(com, (len(x), 1)))
    x[:, 7:10] += turn.apply(np.cross(x[:, 10:], com))
    out = np.empty((*t.shape, 13))
    gravity, force = gravity_vector(hidden), np.array(hidden.force)
    board = np.array([hidden.rough, hidden.rough_count, hidden.fading])
    if box.slides:
        mu = box.mu if hidden.mu is None else hidden.mu
        pull = gravity + force / box.mass_kg
        drags = np.array([hidden.drag, hidden.square_drag]) / box.mass_kg
        _slide_runs(t, x, mu * max(-pull[2], 0.0), pull, drags, board, out)
    else:
        forces = np.array([hidden.drag, hidden.square_drag, hidden.lift, hidden.gust]) / box.mass_kg
        pull = gravity + force / box.mass_kg
        if box.tumbles:
            corners, mu = box_corners(box.size_m) - com, box.mu if hidden.mu is None else hidden.mu
            tumble_runs(t, x, pull, forces, box.inertia_kgm2 / box.mass_kg, corners, mu, board, out)
        else:
            _fly_runs(t, x, pull, forces, box.inertia_kgm2, out)
    turn = _rotation(out[..., 3:7].reshape(-1, 4))
    many = out.reshape(-1, 13)
    many[:, :3] -= turn.apply(np.tile(com, (len(many), 1)))
    many[:, 7:10] -= turn.apply(np.cross(many[:, 10:], com))
    out[..., :3] *= hidden.scale
    out[..., 7:10] *= hidden.scale / hidden.clock
    out[..., 10:] /= hidden.clock
    return out


def _rotation(quat_wxyz: Array) -> Rotation:
    return Rotation.from_quat(np.roll(quat_wxyz, -1, axis=-1))


def gravity_vector(hidden: HiddenInBox) -> Array:
    """(3,) m/s2 in the world."""
    return Rotation.from_rotvec([*hidden.tilt, 0.0]).apply([0.0, 0.0, -hidden.gravity])


@njit
def _fly_runs(t, start, pull, forces, inertia, out):
    """Fourth-order Runge-Kutta steps of every run, into out (r, rows, 13)."""
    k = np.empty((4, 13))
    for r in range(len(t)):
        x = start[r].copy()
        out[r, 0] = x
        for row in range(t.shape[1] - 1):
            span = t[r, row + 1] - t[r, row]
            steps = max(1, int(np.ceil(span / _LARGEST_STEP_S)))
            h = span / steps
            for s in range(steps):
                now = t[r, row] + s * h
                flight_rates(x, now, pull, forces, inertia, k[0])
                x = flight_step(x, now, h, pull, forces, inertia, k)
                x[3:7] /= np.sqrt((x[3:7] ** 2).sum())
            out[r, row + 1] = x


@njit
def _slide_runs(t, start, grip, pull, drags, board, out):
    """Midpoint steps along a level board; what friction would turn back within a step stops, and stays where it can.

    grip is the friction of a uniform board per mass; board is that of `on_board`.
    """
    for r in range(len(t)):
        x = start[r].copy()
        out[r, 0] = x
        for row in range(t.shape[1] - 1):
            span = t[r, row + 1] - t[r, row]
            steps = max(1, int(np.ceil(span / _LARGEST_STEP_S)))
            h = span / steps
            for _ in range(steps):
                px, vx, vy = x[0], x[7], x[8]
                ax, ay = 0.0, 0.0
                for half in range(2):
                    speed = np.sqrt(vx * vx + vy * vy)
                    rubs = on_board(grip, board, px, speed)
                    slows = rubs / max(speed, 1e-12) + drags[0] + drags[1] * speed
                    ax, ay = pull[0] - slows * vx, pull[1] - slows * vy
                    if half == 0:
                        if speed == 0.0 and np.hypot(pull[0], pull[1]) <= rubs:
                            ax, ay = 0.0, 0.0
                            break
                        px, vx, vy = x[0] + 0.5 * h * vx, vx + 0.5 * h * ax, vy + 0.5 * h * ay
                nx, ny = x[7] + h * ax, x[8] + h * ay
                if nx * x[7] + ny * x[8] <= 0.0 and np.hypot(pull[0], pull[1]) <= grip * (1.0 - board[0]):
                    nx, ny = 0.0, 0.0
                x[0] += 0.5 * h * (x[7] + nx)
                x[1] += 0.5 * h * (x[8] + ny)
                x[7], x[8] = nx, ny
            out[r, row + 1] = x
