"""The list of tosses: boxes that fly or slide, with a cause, level and log by a rule from a number."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.bodies import GRAVITY, Box, HiddenInBox, move
from tests.suites.gap2.generate.cases import ROUND, SEED, CaseFiles, family_of
from tests.suites.gap2.generate.logs import csv_bytes
from tests.suites.gap2.generate.power import LEVELS, strength_for
from tests.suites.gap2.generate.rivals import CLOSE, SAME, gauss_newton
from tests.suites.gap2.generate.truth import Family, HiddenEffect, Truth

_HORIZON_S = 0.1
_NAMES = ("px", "py", "pz", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz")
_CONTROLS = ("none", "nuisance", "noise")
_ROUNDS = 6
_TRIALS_REFITTED, _ROWS_REFITTED = 6, 60  # of which rivals are refitted; noncentralities are scaled to all
Make = Callable[[Array, Box], HiddenInBox]


@dataclass(frozen=True)
class TossCause:
    """A cause: how it is made from a strength and a way (unit vector (3,)), and its library parameters."""

    name: str
    slides: bool | None
    make: Callable[[float, Array, Box], HiddenInBox]
    checked: Callable[[HiddenInBox], Mapping[str, float]] = lambda hidden: {}
    most: float = 1.0


_LIBRARY: tuple[TossCause, ...] = (
    TossCause(
        "world.gravity_magnitude",
        False,
        lambda s, way, box: HiddenInBox(gravity=GRAVITY * (1.0 + np.sign(way[0]) * s)),
        lambda h: {"gravity_mps2": h.gravity},
        0.5,
    ),
    TossCause("world.gravity_tilt", None, lambda s, way, box: HiddenInBox(tilt=(s * way[0], s * way[1])), most=0.2),
    TossCause(
        "world.linear_drag",
        False,
        lambda s, way, box: HiddenInBox(drag=s * box.mass_kg * 3.0),
        lambda h: {"drag_Nspm": h.drag},
    ),
    TossCause(
        "world.quadratic_drag",
        False,
        lambda s, way, box: HiddenInBox(square_drag=s * box.mass_kg * 2.0),
        lambda h: {"drag_Ns2pm2": h.square_drag},
    ),
    TossCause(
        "world.constant_force",
        None,
        lambda s, way, box: HiddenInBox(force=_vector(s * box.mass_kg * GRAVITY * way * [1, 1, 0])),
        most=0.2,
    ),
    TossCause(
        "contact.friction",
        True,
        lambda s, way, box: HiddenInBox(mu=box.mu * (1.0 + np.sign(way[0]) * s)),
        lambda h: {"mu": h.mu or 0.0},
        0.6,
    ),
    TossCause(
        "body.com_offset",
        False,
        lambda s, way, box: HiddenInBox(com=_vector(0.3 * s * box.size_m * way)),
        lambda h: dict(zip(("x_m", "y_m", "z_m"), h.com, strict=True)),
    ),
    TossCause(
        "sensor.scale",
        None,
        lambda s, way, box: HiddenInBox(scale=1.0 + np.sign(way[0]) * s),
        lambda h: {"factor": h.scale},
        0.3,
    ),
    TossCause(
        "sensor.clock_skew",
        None,
        lambda s, way, box: HiddenInBox(clock=1.0 + np.sign(way[0]) * s),
        lambda h: {"factor": h.clock},
        0.3,
    ),
)
_OUTSIDE: tuple[TossCause, ...] = (
    TossCause("outside.lift", False, lambda s, way, box: HiddenInBox(lift=s * box.mass_kg)),
    TossCause("outside.gusts", False, lambda s, way, box: HiddenInBox(gust=5.0 * s * box.mass_kg * GRAVITY)),
    TossCause("outside.friction_by_place", True, lambda s, way, box: HiddenInBox(rough=s, rough_count=25.0), most=0.9),
    TossCause("outside.friction_fades", True, lambda s, way, box: HiddenInBox(fading=s), most=0.9),
)
# What each twin is hidden as; whether it is one follows from the data.
_TWINS = (
    ("world.gravity_magnitude", False),
    ("sensor.scale", False),
    ("sensor.clock_skew", False),
    ("world.gravity_tilt", True),
    ("world.constant_force", True),
    ("contact.friction", True),
)
_TWO = (
    ("world.quadratic_drag", "body.com_offset", False),
    ("contact.friction", "world.gravity_tilt", True),
    ("world.linear_drag", "world.gravity_tilt", False),
)
_RIVALS: dict[str, tuple[Make, int, bool | None]] = {
    "world.gravity_magnitude": (lambda x, box: HiddenInBox(gravity=GRAVITY * (1.0 + x[0])), 1, False),
    "world.gravity_tilt": (lambda x, box: HiddenInBox(tilt=(x[0], x[1])), 2, None),
    "world.linear_drag": (lambda x, box: HiddenInBox(drag=x[0] * box.mass_kg), 1, None),
    "world.quadratic_drag": (lambda x, box: HiddenInBox(square_drag=x[0] * box.mass_kg), 1, None),
    "world.constant_force": (lambda x, box: HiddenInBox(force=_vector(x * box.mass_kg * GRAVITY)), 3, None),
    "contact.friction": (lambda x, box: HiddenInBox(mu=box.mu * (1.0 + x[0])), 1, True),
    "body.com_offset": (lambda x, box: HiddenInBox(com=_vector(x * box.size_m)), 3, False),
    "sensor.scale": (lambda x, box: HiddenInBox(scale=1.0 + x[0]), 1, None),
    "sensor.clock_skew": (lambda x, box: HiddenInBox(clock=1.0 + x[0]), 1, None),
}


def _vector(values: Array) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])


@dataclass(frozen=True)
class _Tracked:
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


def toss_case(number: int) -> CaseFiles:
    """The toss of that number; the same number gives the same bytes."""
    family = family_of(number)
    turn = number // len(ROUND) * ROUND.count(family) + ROUND[: number % len(ROUND)].count(family)
    rng = np.random.default_rng([SEED, 1, number])
    causes, slides, level, control = _chosen(family, turn)
    tracked = _drawn(slides, rng)
    way = _way(rng)
    if control == "noise":
        tracked = replace(tracked, sigma_m=5.0 * tracked.sigma_m, sigma_rad=5.0 * tracked.sigma_rad)
    actual = tracked.box
    if control == "nuisance":
        off = rng.uniform(0.97, 1.03, 2)
        actual = replace(actual, mass_kg=actual.mass_kg * off[0], mu=actual.mu * off[1])
    hidden, effects, reached = HiddenInBox(), [], True
    for cause in causes:
        strength, cause_reached = strength_for(
            lambda s, cause=cause: tracked.miss(
                move(tracked.box, cause.make(s, way, tracked.box), tracked.t_s, tracked.start), _HORIZON_S
            ),
            LEVELS[level],
            1e-4,
            cause.most,
        )
        one = cause.make(strength, way, tracked.box)
        plain = HiddenInBox()
        hidden = replace(
            hidden, **{n: getattr(one, n) for n in one.__dataclass_fields__ if getattr(one, n) != getattr(plain, n)}
        )
        reached = reached and cause_reached
        effects.append(HiddenEffect(cause.name, "", dict(cause.checked(one)), strength))
    readings = move(actual, hidden, tracked.t_s, tracked.start)
    truth = Truth(
        number,
        "",
        family,
        "free_body",
        "slide" if slides else "flight",
        tuple(effects),
        level=level,
        level_reached=reached,
        miss=tracked.miss(readings, _HORIZON_S),
        miss_whole=tracked.miss(readings, float("inf")),
        horizon_s=_HORIZON_S,
        sigma=tracked.sigma_m,
        left_out=(causes[0].name,) if family == "left_out" else (),
        control=control,
    )
    if len(effects) == 1:
        truth = _labelled(truth, tracked, readings)
    return _files(truth, tracked, readings, rng)


def _chosen(family: Family, turn: int) -> tuple[list[TossCause], bool, str, str]:
    """(causes, slides, level, kind of control)."""
    levels = ("gross", "large")
    if family == "control":
        return [], bool(turn % 2), "", _CONTROLS[turn // 2 % len(_CONTROLS)]
    if family == "outside":
        cause = _OUTSIDE[turn % len(_OUTSIDE)]
        return [cause], bool(cause.slides), levels[turn // len(_OUTSIDE) % 2], ""
    by_name = {c.name: c for c in _LIBRARY}
    if family == "two":
        first, second, slides = _TWO[turn % len(_TWO)]
        return [by_name[first], by_name[second]], slides, levels[turn // len(_TWO) % 2], ""
    if family == "twin":
        name, slides = _TWINS[turn % len(_TWINS)]
        return [by_name[name]], slides, levels[turn // len(_TWINS) % 2], ""
    cause = _LIBRARY[(turn * 2 + (family == "left_out")) % len(_LIBRARY)]
    slides = bool(turn % 2) if cause.slides is None else cause.slides
    return [cause], slides, levels[(turn + turn // len(_LIBRARY)) % 2], ""


def _way(rng: np.random.Generator) -> Array:
    way = rng.normal(size=3)
    return way / np.linalg.norm(way)


def _drawn(slides: bool, rng: np.random.Generator) -> _Tracked:
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
    return _Tracked(box, t, start, sigma, float(rng.uniform(2e-3, 8e-3)), rate)


def _labelled(truth: Truth, tracked: _Tracked, readings: Array) -> Truth:
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
    return replace(
        truth,
        visible=visible,
        rivals=near,
        accept=tuple(n for n, left in near.items() if left < SAME),
        near=tuple(n for n, left in near.items() if SAME <= left < CLOSE),
    )


def _left(make: Make, count: int, tracked: _Tracked, readings: Array) -> float:
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


def _files(truth: Truth, tracked: _Tracked, readings: Array, rng: np.random.Generator) -> CaseFiles:
    box, with_rates, declares = tracked.box, bool(rng.random() < 0.5), bool(rng.random() < 0.5)
    dropped = float(rng.choice([0.0, 0.0, 0.02]))
    files = {}
    for k, (t, true) in enumerate(zip(tracked.t_s, readings, strict=True)):
        read = true.copy()
        read[:, :3] += rng.normal(0.0, tracked.sigma_m, (len(t), 3))
        shake = Rotation.from_rotvec(rng.normal(0.0, tracked.sigma_rad, (len(t), 3)))
        read[:, 3:7] = np.roll((Rotation.from_quat(np.roll(true[:, 3:7], -1, axis=1)) * shake).as_quat(), 1, axis=1)
        read[:, 7:10] += rng.normal(0.0, 20.0 * tracked.sigma_m, (len(t), 3))
        read[:, 10:] += rng.normal(0.0, 20.0 * tracked.sigma_rad, (len(t), 3))
        rows = rng.random(len(t)) >= dropped
        rows[[0, -1]] = True
        names = _NAMES if with_rates else _NAMES[:7]
        table = {"t": t[rows], **{n: read[rows, i] for i, n in enumerate(names)}}
        files[f"trajectories/r{k:02d}.csv"] = csv_bytes(table, list(table))
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(name.encode() + files[name])
    measurement = digest.hexdigest()[:16]
    columns: dict[str, object] = {"t": "t", "p": list(_NAMES[:3]), "q_wxyz": list(_NAMES[3:7])}
    if with_rates:
        columns |= {"v": list(_NAMES[7:10]), "w_body": list(_NAMES[10:])}
    height_m = 0.0 if box.slides else -6.0
    spec: dict[str, object] = {
        "schema_version": 1,
        "name": measurement,
        "kind": "free_body",
        "rate_hz": round(tracked.rate_hz, 3),
        "columns": columns,
        "subject": {
            "box": {"size_m": _short(box.size_m)},
            "mass_kg": _short([box.mass_kg])[0],
            "inertia_kgm2": _short(box.inertia_kgm2),
            "contact": {"friction": _short([box.mu])[0], "restitution": 0.0},
        },
        "world": {
            "gravity_mps2": [0.0, 0.0, -GRAVITY],
            "support": {"plane": {"height_m": height_m}},
        },
    }
    if declares:
        spec["sensor_noise"] = {"p_m": _short([tracked.sigma_m])[0], "rotation_rad": _short([tracked.sigma_rad])[0]}
    files["measurement.yaml"] = (json.dumps(spec, indent=1) + "\n").encode()
    log = {"rate_hz": tracked.rate_hz, "trials": len(tracked.t_s), "rows": int(tracked.t_s.size)}
    return CaseFiles(files, replace(truth, measurement=measurement, log=log))


def _short(values: Sequence[float] | Array) -> list[float]:
    return [float(f"{v:.9g}") for v in values]
