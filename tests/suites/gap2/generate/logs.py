"""Logs as users have them: noise, quantisation, corrupted rows, zero-phase filters, other rates, any column names."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import Plant
from tests.suites.gap2.generate.power import Readings
from tests.suites.gap2.generate.scenes import Recording

Tables = Mapping[str, Mapping[str, Array]]

_JOINTS = (("main", "second", "third"), ("axis1", "axis2", "axis3"), ("shoulder", "elbow", "wrist"), ("a", "b", "c"))
_STYLES = ("q_{0}", "{0}_pos", "{0}.position", "pos_{0}")
_FINE_ENOUGH = 40.0  # rows per period of the mechanism, where rows between rows may be interpolated
_ORDER = 4  # of the Butterworth filter, applied forwards and backwards


@dataclass(frozen=True)
class LogStyle:
    """How the log was written; drawn without regard to what is hidden.

    colour       share of an error that stays to the next row.
    count        quantisation step, 0: none.
    resampled_hz, cutoff_hz   of the uniform rows and the low-pass; 0: rows as they were read.
    corrupted    (trial, row share, kind) of damaged rows: 0 not a number, 1 far away.
    """

    joints: tuple[str, ...]
    column: str
    with_rates: bool
    rate_sigma: float
    colour: float
    count: float
    resampled_hz: float
    cutoff_hz: float
    corrupted: tuple[tuple[int, float, int], ...]
    declares_noise: bool
    declares_rate: bool
    with_split: bool
    epoch_s: float


def draw_style(plant: Plant, recording: Recording, rng: np.random.Generator, *, colour: float = 0.0) -> LogStyle:
    """A style for a recording."""
    rate, period = recording.rate_hz, recording.period_s
    kind = (
        rng.choice(["plain", "resampled", "filtered"], p=[0.6, 0.2, 0.2]) if rate * period > _FINE_ENOUGH else "plain"
    )
    slower = max(rng.uniform(0.4, 0.95) * rate, 0.6 * _FINE_ENOUGH / period, 30.0)
    cutoff = max(12.0 / period, 0.1 * rate) if kind == "filtered" else 0.0
    damaged = int(rng.integers(1, 5)) if rng.random() < 0.15 else 0
    return LogStyle(
        joints=_JOINTS[int(rng.integers(len(_JOINTS)))][: plant.joints],
        column=_STYLES[int(rng.integers(len(_STYLES)))],
        with_rates=bool(rng.random() < 0.4),
        rate_sigma=recording.sigma * 2.0 * np.pi / period * float(rng.uniform(2.0, 6.0)),
        colour=colour,
        count=recording.sigma * float(rng.uniform(1.0, 2.8)) if rng.random() < 0.4 else 0.0,
        resampled_hz=0.0 if kind == "plain" else float(slower if kind == "resampled" else 0.98 * rate),
        cutoff_hz=float(min(cutoff, 0.4 * rate)),
        corrupted=tuple(
            (int(rng.integers(len(recording.trials))), float(rng.uniform(0.1, 0.9)), int(rng.integers(2)))
            for _ in range(damaged)
        ),
        declares_noise=bool(rng.random() < 0.5),
        declares_rate=bool(rng.random() < 0.6),
        with_split=bool(rng.random() < 0.4),
        epoch_s=1.7e9 + float(rng.integers(10**6)) if rng.random() < 0.08 else 0.0,
    )


def written(
    plant: Plant, recording: Recording, readings: Readings, style: LogStyle, rng: np.random.Generator
) -> tuple[Tables, float]:
    """(tables of columns by trial id, the noise of positions that stays in them)."""
    tables: dict[str, dict[str, Array]] = {}
    left = []
    for k, ((q, v), trial) in enumerate(zip(readings, recording.trials, strict=True)):
        t, inputs, supply = trial.stamps_s, trial.inputs, trial.supply[:, None]
        error = _errors(q.shape, recording.sigma, style, rng)
        noisy = q + error
        if style.count:
            noisy = np.round(noisy / style.count) * style.count
        rates = v + rng.normal(0.0, style.rate_sigma, v.shape)
        if style.resampled_hz:
            even = np.round(np.arange(t[0], t[-1], 1.0 / style.resampled_hz), 6)
            low_pass = _low_pass(style)
            left.append(low_pass(_at(t, noisy - q, even)))
            noisy, rates = low_pass(_at(t, noisy, even)), low_pass(_at(t, rates, even))
            inputs, supply = _means(t, inputs, even), _means(t, supply, even)
            t = even
        else:
            left.append(noisy - q)
        columns = {"t": np.round(t - recording.trials[k].stamps_s[0], 6) + style.epoch_s}
        for j, name in enumerate(style.joints):
            columns[style.column.format(name)] = noisy[:, j].copy()
            if style.with_rates:
                columns[f"{style.column.format(name)}_rate"] = rates[:, j]
            if plant.drive != "none":
                columns[f"{name}_in"] = inputs[:, j]
        if plant.drive != "none" and np.ptp(np.concatenate([x.supply for x in recording.trials])) > 0.0:
            columns["u_batt"] = 24.0 * supply[:, 0]
        tables[f"r{k:02d}"] = columns
    reach = max(float(np.abs(q).max()) for q, _ in readings)
    for k, share, kind in style.corrupted:
        column = tables[f"r{k:02d}"][style.column.format(style.joints[0])]
        column[int(share * len(column))] = np.nan if kind == 0 else 30.0 * reach
    return tables, float(np.concatenate([e.ravel() for e in left]).std())


def _errors(shape: tuple[int, ...], sigma: float, style: LogStyle, rng: np.random.Generator) -> Array:
    white = rng.normal(0.0, np.sqrt(max(sigma**2 - style.count**2 / 12.0, 0.01 * sigma**2)), shape)
    for k in range(1, len(white) if style.colour else 0):
        white[k] = style.colour * white[k - 1] + np.sqrt(1.0 - style.colour**2) * white[k]
    return white


def _at(t: Array, values: Array, when: Array) -> Array:
    return np.asarray(CubicSpline(t, values, axis=0)(when))


def _low_pass(style: LogStyle):
    if not style.cutoff_hz:
        return lambda values: values
    sections = butter(_ORDER, style.cutoff_hz, fs=style.resampled_hz, output="sos")
    return lambda values: np.asarray(sosfiltfilt(sections, values, axis=0, padlen=min(len(values) - 1, 30)))


def _means(t: Array, held: Array, when: Array) -> Array:
    """Means of held inputs from each new row to the next, so that their impulse stays."""
    ends = np.append(when, when[-1] + np.median(np.diff(when)))
    total = np.concatenate([np.zeros((1, held.shape[1])), np.cumsum(held[:-1] * np.diff(t)[:, None], axis=0)])
    beyond = np.maximum(ends - t[-1], 0.0)[:, None] * held[-1]
    sums = np.stack([np.interp(ends, t, total[:, j]) for j in range(held.shape[1])], axis=1) + beyond
    return np.diff(sums, axis=0) / np.diff(ends)[:, None]


def declared(
    plant: Plant,
    recording: Recording,
    style: LogStyle,
    tables: Tables,
    sigma: float,
    name: str,
    rng: np.random.Generator,
) -> dict[str, object]:
    """What the owner writes into `measurement.yaml`."""
    columns: dict[str, str] = {"t": "t"}
    driven = {"effort": "effort", "position_pd": "command"}.get(plant.drive)
    for joint in style.joints:
        columns[f"q_{joint}"] = style.column.format(joint)
        if style.with_rates:
            columns[f"qd_{joint}"] = f"{style.column.format(joint)}_rate"
        if driven:
            columns[f"{driven}_{joint}"] = f"{joint}_in"
    spec: dict[str, object] = {
        "schema_version": 1,
        "name": name,
        "kind": "mechanism",
        "rate_hz": round(style.resampled_hz or recording.rate_hz, 3) if style.declares_rate else None,
        "columns": columns,
        "subject": {"joints": [_joint(plant, j, joint) for j, joint in enumerate(style.joints)]},
        "actuation": {"type": plant.drive},
    }
    if "u_batt" in next(iter(tables.values())):
        spec["aux"] = {"supply_V": "u_batt"}
    if plant.drive == "position_pd":
        gains = {"kp": Number.KP, "kd": Number.KD}
        spec["actuation"] = {
            "type": plant.drive,
            **{key: [float(f"{plant.numbers[j, n]:.9g}") for j in range(plant.joints)] for key, n in gains.items()},
        }
    if style.declares_noise:
        noise = {"q": float(f"{sigma:.3g}")}
        if style.with_rates and not style.cutoff_hz:
            noise["qd"] = float(f"{style.rate_sigma:.3g}")
        spec["sensor_noise"] = noise
    if style.with_split:
        ids = list(tables)
        test = sorted(rng.choice(ids, max(2, round(0.3 * len(ids))), replace=False).tolist())
        spec["split"] = {"train": [i for i in ids if i not in test], "test": test}
    return spec


def _joint(plant: Plant, j: int, name: str) -> dict[str, object]:
    def short(value: float) -> float:
        return float(f"{value:.9g}")

    joint: dict[str, object] = {"name": name, "type": "prismatic" if plant.slides else "revolute"}
    if plant.slides:
        joint["mass_kg"] = short(plant.mass[j])
    else:
        joint["inertia_kgm2"] = short(plant.inertia[j])
    if plant.upright:
        joint["gravity_load"] = {"mass_kg": short(plant.mass[j]), "com_distance_m": short(plant.lever[j])}
    if j:
        joint["parent_offset_m"] = short(plant.offset_m[j])
    numbers = plant.numbers[j]
    return joint | {"friction": short(numbers[Number.COULOMB]), "damping": short(numbers[Number.VISCOUS])}


def csv_bytes(table: Mapping[str, Array], names: Sequence[str]) -> bytes:
    """A table as a spreadsheet exports it: 9 significant digits, microseconds."""
    columns = [table[n] for n in names]
    formats = [("{:.6f}" if n == "t" else "{:.9g}").format for n in names]
    rows = (
        ",".join("" if np.isnan(x) else f(x) for f, x in zip(formats, row, strict=True))
        for row in zip(*columns, strict=True)
    )
    return ("\n".join([",".join(names), *rows]) + "\n").encode()


def digest_of(files: Mapping[str, bytes]) -> str:
    """The name of a measurement with these files: it shows nothing of the case."""
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(name.encode() + files[name])
    return digest.hexdigest()[:16]
