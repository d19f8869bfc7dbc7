"""One joint, a slide or a two-link chain as differential equations of their own; shares no code with the library.

All trials at once, half a millisecond per step (symplectic Euler). Formulas that the library does not share: friction
is a field of bristles (Dahl 1968; with a Stribeck level: Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE TAC 40(3),
1995), end stops follow Hunt and Crossley (J. Appl. Mech. 42, 1975), play is a second mass between two flanks, a drive
saturates softly, and a chain is its two coupled equations written out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

STEP_S = 5e-4
GRAVITY = 9.81
_BRISTLE = 3e-4  # rad or m of deflection before a joint slips
Hidden = Mapping[str, np.ndarray | float]  # numbers per joint (j,)
Number = Callable[[str], np.ndarray | float]  # a hidden number by name, 0 where it is not hidden
TorqueLaw = Callable[[Number, np.ndarray, np.ndarray], np.ndarray]  # torque (k, j) at positions and rates (k, j)


@dataclass(frozen=True)
class Plant:
    """The thing as its owner believes it; all (j,).

    inertia   about each own axis, load included (kg m2), or the mass of a slide; `lever` of the mass centre (m), 0 for
    a slide; `offset_m` from the first axis to the second.
    """

    drive: str  # none | effort | position_pd
    slides: bool
    inertia: np.ndarray
    mass: np.ndarray
    lever: np.ndarray
    offset_m: float = 0.0
    kp: float = 0.0
    kd: float = 0.0
    friction: float = 0.0
    damping: float = 0.0

    @property
    def weight_Nm(self) -> np.ndarray:
        """(j,) moment of gravity with the link held level."""
        return np.zeros_like(self.mass) if self.slides else self.mass * GRAVITY * self.lever


def simulate(
    plant: Plant,
    hidden: Hidden,
    inputs: np.ndarray,
    start: np.ndarray,
    row_s: float,
    supply_V: np.ndarray,
    laws: Sequence[TorqueLaw] = (),
) -> np.ndarray:
    """Positions (k, steps, j) every `STEP_S` under inputs (k, rows, j) held from row to row, from rest at start (k, j).

    `supply_V` (k, rows) moves the drive's strength when `sag` is hidden; `laws` add torques that depend on the state.
    """

    def h(name: str) -> np.ndarray | float:
        return hidden.get(name, 0.0)

    trials, rows, joints = inputs.shape
    every = round(row_s / STEP_S)
    late = round(float(np.max(h("delay_s"))) / STEP_S)
    q, v = start.astype(float).copy(), np.zeros((trials, joints))
    memory = {"lagged": inputs[:, 0].copy(), "bristle": np.zeros_like(q), "motor": q.copy(), "motor_rate": v.copy()}
    memory |= {"absorber": q.copy(), "absorber_rate": v.copy()}
    push = _disturbance(hidden, trials, rows * every, joints)
    out = np.empty((trials, rows * every, joints))
    gained = np.zeros_like(v)
    for step in range(rows * every):
        out[:, step] = q
        # A step's kick stands for half a step to either side of it.
        row, before = (max(step - late - k, 0) // every for k in (0, 1))
        sent = 0.5 * (inputs[:, row] + inputs[:, before])
        effort = _effort(plant, h, memory, sent, q, v, supply_V[:, step // every, None])
        passive = sum((law(h, q, v) for law in laws), _passive(plant, h, memory, q, v))
        torque = effort + push[:, step] + passive - _friction(plant, h, memory, q, v)
        # Rates are those of half a step ago; how links whirl one another depends on them too strongly for that.
        gained = STEP_S * _accelerations(plant, h, q, v + 0.5 * gained, torque)
        v = v + gained
        q = q + STEP_S * v
    return out


def _accelerations(plant, h, q, v, torque):
    inertia = plant.inertia * (1.0 + h("inertia_share"))
    if q.shape[1] == 1:
        return torque / inertia
    swing = plant.mass[1] * plant.offset_m * plant.lever[1]
    a = plant.inertia[0] + plant.mass[1] * plant.offset_m**2 + inertia[1] + 2.0 * swing * np.cos(q[:, 1])
    a = a + (inertia[0] - plant.inertia[0])
    b = inertia[1] + swing * np.cos(q[:, 1])
    d = inertia[1]
    whirl = swing * np.sin(q[:, 1])
    r1 = torque[:, 0] + whirl * (2.0 * v[:, 0] * v[:, 1] + v[:, 1] ** 2)
    r2 = torque[:, 1] - whirl * v[:, 0] ** 2
    det = a * d - b * b
    return np.stack([(d * r1 - b * r2) / det, (a * r2 - b * r1) / det], axis=1)


def _gravity(plant, h, q):
    if plant.slides:
        return np.zeros_like(q)
    weight = plant.weight_Nm * (1.0 + h("weight_share"))
    level = np.sin(np.cumsum(q, axis=1) + np.max(h("tilt_rad")))
    if q.shape[1] == 1:
        return weight * level
    heavier = np.broadcast_to(1.0 + h("weight_share"), (2,))[1]  # all of a link's weight, where it hangs on the first
    carried = plant.mass[1] * GRAVITY * plant.offset_m * heavier
    second = weight[1] * level[:, 1]
    return np.stack([(weight[0] + carried) * level[:, 0] + second, second], axis=1)


def _effort(plant, h, memory, sent, q, v, supply_V):
    if plant.drive == "none":
        return np.zeros_like(q)
    if np.max(h("lag_s")) > 0.0:
        memory["lagged"] += (1.0 - np.exp(-STEP_S / np.max(h("lag_s")))) * (sent - memory["lagged"])
        sent = memory["lagged"]
    kp, kd = plant.kp * (1.0 + h("kp_share")), plant.kd * (1.0 + h("kd_share"))
    asked = kp * (sent - q) - kd * v if plant.drive == "position_pd" else sent
    if np.max(h("limit")) > 0.0:
        asked = asked / (1.0 + np.abs(asked / np.max(h("limit"))) ** 8) ** 0.125
    if np.max(h("band")) > 0.0:
        asked = asked - h("band") * np.tanh(asked / np.max(h("band")))
    asked = asked * (1.0 + h("gain_share")) * (1.0 + h("sag") * (supply_V / 12.0 - 1.0))
    asked = asked * (1.0 + h("ripple") * np.cos(h("teeth") * q + 0.7)) + h("push")
    if np.max(h("gap")) > 0.0:
        return _through_play(plant, float(np.max(h("gap"))), memory, asked, q, v)
    return asked


def _through_play(plant, gap, memory, effort, q, v):
    """A motor of 2 % of the inertia between two stiff flanks."""
    small = 0.02 * plant.inertia
    stiff = small * 500.0**2
    twist, rate = memory["motor"] - q, memory["motor_rate"] - v
    deep = np.sign(twist) * np.maximum(np.abs(twist) - 0.5 * gap, 0.0)
    passed = stiff * deep + np.where(deep != 0.0, 0.4 * np.sqrt(stiff * small) * rate, 0.0)
    passed = np.where(passed * deep > 0.0, passed, 0.0)
    memory["motor_rate"] = memory["motor_rate"] + STEP_S * (effort - passed) / small
    memory["motor"] = memory["motor"] + STEP_S * memory["motor_rate"]
    return passed


def _passive(plant, h, memory, q, v):
    """Torque of everything smooth that is not a drive."""
    torque = -_gravity(plant, h, q) - (plant.damping * (1.0 + h("damping_share")) + h("viscous")) * v
    torque = torque - h("spring") * (q - h("rest"))
    if np.max(h("stop_stiffness")) > 0.0:
        deep = np.maximum(q - h("stop_at"), 0.0)
        torque = torque - np.maximum(h("stop_stiffness") * deep**1.5 * (1.0 + 0.3 * v), 0.0)
    if np.max(h("absorber")) > 0.0:
        pull = plant.inertia * np.max(h("absorber")) * 15.0**2 * (memory["absorber"] - q)
        memory["absorber_rate"] = memory["absorber_rate"] + STEP_S * 15.0**2 * (q - memory["absorber"])
        memory["absorber"] = memory["absorber"] + STEP_S * memory["absorber_rate"]
        torque = torque + pull
    return torque


def _friction(plant, h, memory, q, v):
    level = plant.friction * (1.0 + h("friction_share")) + h("coulomb") + np.zeros_like(q)
    level = level + h("stribeck") / (1.0 + (v / 0.15) ** 2)
    if np.max(h("load_radius")) > 0.0:
        weight = plant.mass * GRAVITY
        inward = weight * np.cos(q) + plant.mass * plant.lever * v**2
        level = level + h("load_radius") * np.hypot(inward, weight * np.sin(q))
    if not level.any():
        return level
    way = np.sign(v)
    memory["bristle"] = way + (memory["bristle"] - way) * np.exp(-np.abs(v) * STEP_S / _BRISTLE)
    bent = memory["bristle"]
    level = np.maximum(level + h("asymmetry") * np.sign(bent), 0.0)
    calm = 0.6 * np.sqrt(level / _BRISTLE * plant.inertia) * np.exp(-((v / 0.01) ** 2)) * v
    return level * bent + calm


def _disturbance(hidden: Hidden, trials: int, steps: int, joints: int) -> np.ndarray:
    """Torque (k, steps, j) that no state explains: a hum, kicks, gusts; the same for the same seed."""
    rng = np.random.default_rng(int(np.max(hidden.get("seed", 0))))
    t = np.arange(steps) * STEP_S
    phase = rng.uniform(0.0, 2.0 * np.pi, (trials, 1))
    push = np.zeros((trials, steps, joints))
    first = push[:, :, 0]
    first += float(np.max(hidden.get("hum", 0.0))) * np.sin(2.0 * np.pi * 3.7 * t + phase)
    when = rng.uniform(0.2, max(t[-1] - 0.2, 0.3), (trials, 3))
    signs = rng.choice([-1.0, 1.0], (trials, 3))
    pulses = np.exp(-(((t[None, None] - when[:, :, None]) / 0.04) ** 2))
    first += float(np.max(hidden.get("kicks", 0.0))) * (signs[:, :, None] * pulses).sum(axis=1)
    if np.max(hidden.get("gusts", 0.0)) > 0.0:
        noise = rng.normal(size=(trials, steps // 100 + 2))
        knots = np.arange(noise.shape[1]) * 0.05
        first += float(np.max(hidden["gusts"])) * np.stack([np.interp(t, knots, row) for row in noise])
    return push
