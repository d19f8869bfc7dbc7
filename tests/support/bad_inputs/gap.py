"""The smallest measurement folder for every `gap/` code: `SAMPLES[code](folder)` writes it and returns the folder.

All start from one sound measurement, a spinning box in free flight or a swinging hinge, with one thing changed. Codes
that no measurement can trigger are in `NOT_FROM_A_FOLDER`, with the test that triggers them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

Columns = dict[str, np.ndarray]
Writer = Callable[[Path], Path]

RATE_HZ = 100.0
FREE = """\
schema_version: 1
name: box
kind: free_body
columns: {t: t, p: [px, py, pz], q_wxyz: [qw, qx, qy, qz], v: [vx, vy, vz], w_body: [wx, wy, wz]}
subject:
  box: {size_m: [0.1, 0.06, 0.04]}
  mass_kg: 0.3
"""
HINGE = """\
schema_version: 1
name: hinge
kind: mechanism
columns: {t: t, q_hinge: angle, qd_hinge: rate}
subject:
  joints: [{name: hinge, inertia_kgm2: 0.01, gravity_load: {mass_kg: 0.2, com_distance_m: 0.1}}]
"""
IMPACT = """\
schema_version: 1
name: disc
kind: impact
columns:
  velocity_before: [ux, uy, uw]
  velocity_after: [vx, vy, vw]
  normal_jacobian: [nx, ny, nw]
  tangent_jacobian: [tx, ty, tw]
subject: {mass_kg: 0.1, inertia_kgm2: [1e-4, 1e-4, 1e-4]}
"""
PUSH = """\
schema_version: 1
name: block
kind: push
columns: {p: [x, y, z], q_wxyz: [qw, qx, qy, qz], tip_t: t, tip_p: [x, y, z], force_t: t, force: [fx, fy]}
subject: {box: {size_m: [0.1, 0.1, 0.02]}, mass_kg: 1.0}
"""


def flight(seed: int, rows: int = 60, noise: bool = True, late_s: np.ndarray | float = 0.0) -> Columns:
    """A box in free flight, turning at a constant rate in body axes, with readings noise; sampled late."""
    rng = np.random.default_rng(seed)
    t = np.arange(rows) / RATE_HZ + late_s
    v0, w_B = rng.normal([0.0, 0.0, 3.0], 1.0), rng.normal(0.0, 4.0, 3)
    g = np.array([0.0, 0.0, -9.81])
    p = rng.normal(0.0, 0.3, 3) + t[:, None] * v0 + 0.5 * t[:, None] ** 2 * g
    turn = Rotation.random(rng=np.random.default_rng(seed)) * Rotation.from_rotvec(t[:, None] * w_B)
    quats = np.roll(turn.as_quat(), 1, axis=1)
    v = v0 + t[:, None] * g
    w = np.tile(w_B, (rows, 1))
    if noise:
        p, v, w = (a + rng.normal(0.0, s, a.shape) for a, s in ((p, 2e-5), (v, 3e-3), (w, 2e-2)))
    return (
        columns_of("t", t)
        | columns_of("px py pz", p)
        | columns_of("qw qx qy qz", one_sign(quats))
        | (columns_of("vx vy vz", v) | columns_of("wx wy wz", w))
    )


def swing(seed: int, rows: int = 200) -> Columns:
    """A hinge that swings with slowly falling amplitude."""
    rng = np.random.default_rng(seed)
    t = np.arange(rows) / RATE_HZ
    phase, w = rng.uniform(0.0, 6.0), rng.uniform(4.0, 6.0)
    envelope = 1.2 * np.exp(-0.2 * t)
    angle = envelope * np.sin(w * t + phase)
    rate = envelope * (w * np.cos(w * t + phase) - 0.2 * np.sin(w * t + phase))
    return {"t": t, "angle": angle + rng.normal(0.0, 1e-4, rows), "rate": rate + rng.normal(0.0, 1e-2, rows)}


def events(seed: int, rows: int = 50) -> Columns:
    """A disc that bounces with restitution 0.5 and sticks."""
    rng = np.random.default_rng(seed)
    before = np.column_stack([rng.normal(0.0, 1.0, rows), rng.uniform(-3.0, -1.0, rows), rng.normal(0.0, 5.0, rows)])
    after = before * [0.6, -0.5, 0.6]
    one, zero = np.ones(rows), np.zeros(rows)
    return (
        columns_of("ux uy uw", before)
        | columns_of("vx vy vw", after)
        | columns_of("nx ny nw", np.column_stack([zero, one, zero]))
        | columns_of("tx ty tw", np.column_stack([one, zero, 0.03 * one]))
    )


def pushed(seed: int) -> dict[str, Columns]:
    """A block pushed 2 cm along x: pose, tip and force tables."""
    y = 0.01 * seed
    t = np.arange(30) / 30.0
    tip = np.column_stack([-0.06 + 0.02 * t, np.full(30, y), np.full(30, 0.01)])
    poses = np.array([[0.0, y, 0.01], [0.02, y, 0.01]])
    force = np.column_stack([np.full(60, 2.0), np.zeros(60)])
    return {
        "pose": columns_of("x y z", poses) | columns_of("qw qx qy qz", np.tile([1.0, 0.0, 0.0, 0.0], (2, 1))),
        "tip": {"t": t} | columns_of("x y z", tip),
        "force": {"t": np.arange(60) / 60.0} | columns_of("fx fy", force),
    }


def columns_of(names: str, values: np.ndarray) -> Columns:
    return dict(zip(names.split(), np.atleast_2d(values.T), strict=True))


def one_sign(quats: np.ndarray) -> np.ndarray:
    flips = np.cumsum((quats[1:] * quats[:-1]).sum(axis=1) < 0.0) % 2
    return quats * np.concatenate([[1.0], np.where(flips, -1.0, 1.0)])[:, None]


def csv(columns: Mapping[str, np.ndarray]) -> str:
    rows = zip(*columns.values(), strict=True)
    return "\n".join([",".join(columns), *(",".join(f"{x:.9g}" for x in row) for row in rows)]) + "\n"


def folder_of(folder: Path, spec: str, tables: Mapping[str, Columns | str]) -> Path:
    (folder / "trajectories").mkdir(parents=True, exist_ok=True)
    (folder / "measurement.yaml").write_text(spec)
    for name, table in tables.items():
        path = (
            folder
            / "trajectories"
            / (name if "." in name and not name.endswith((".pose", ".tip", ".force")) else f"{name}.csv")
        )
        path.write_text(table if isinstance(table, str) else csv(table))
    return folder


Edit = Callable[[Columns], Columns]


def tossed(
    edit: Edit = lambda c: c, spec: str = FREE, trials: int = 4, only_first: bool = False, more: str = ""
) -> Writer:
    """Four flights through `edit`."""

    def write(folder: Path) -> Path:
        tables = {f"t{k}": flight(k) if only_first and k else edit(flight(k)) for k in range(trials)}
        return folder_of(folder, spec + more, tables)

    return write


def swung(edit: Edit = lambda c: c, spec: str = HINGE) -> Writer:
    """Four swings through `edit`."""
    return lambda folder: folder_of(folder, spec, {f"t{k}": edit(swing(k)) for k in range(4)})


def struck(edit: Edit = lambda c: c) -> Writer:
    return lambda folder: folder_of(folder, IMPACT, {"events": edit(events(0))})


def pushes(edit: Callable[[dict[str, Columns]], dict[str, Columns]] = lambda t: t) -> Writer:
    """Four pushes; `edit` changes the tables of the first."""

    def write(folder: Path) -> Path:
        tables: dict[str, Columns | str] = {}
        for k in range(4):
            parts = pushed(k) if k else edit(pushed(k))
            tables |= {f"p{k}.{part}": table for part, table in parts.items()}
        return folder_of(folder, PUSH, tables)

    return write


def scaled(names: str, factor: float) -> Edit:
    return lambda c: c | {n: c[n] * factor for n in names.split()}


def with_value(name: str, row: int, value: float) -> Edit:
    def edit(columns: Columns) -> Columns:
        changed = columns[name].copy()
        changed[row] = value
        return columns | {name: changed}

    return edit


def rows(pick: Callable[[int], np.ndarray]) -> Edit:
    return lambda c: {n: v[pick(len(v))] for n, v in c.items()}


def without(name: str) -> Edit:
    return lambda c: {n: v for n, v in c.items() if n != name}


def swapped(columns: Columns) -> Columns:
    """Quaternions in xyzw order under wxyz names."""
    w, x, y, z = (columns[n] for n in ("qw", "qx", "qy", "qz"))
    return columns | {"qw": x, "qx": y, "qy": z, "qz": w}


def world_rate(columns: Columns) -> Columns:
    turn = Rotation.from_quat(np.column_stack([columns[n] for n in ("qx", "qy", "qz", "qw")]))
    return columns | columns_of("wx wy wz", turn.apply(np.column_stack([columns[n] for n in ("wx", "wy", "wz")])))


def flipped(columns: Columns) -> Columns:
    sign = np.where(np.arange(len(columns["t"])) >= 30, -1.0, 1.0)
    return columns | {n: columns[n] * sign for n in ("qw", "qx", "qy", "qz")}


def jittered(columns: Columns) -> Columns:
    late = np.random.default_rng(1).uniform(0.0, 0.003, len(columns["t"]))
    return columns | {"t": columns["t"] + late}


def older(columns: Columns) -> Columns:
    """Velocity of one frame earlier."""
    return columns | {n: np.concatenate([columns[n][:1], columns[n][:-1]]) for n in ("vx", "vy", "vz")}


def copied(folder: Path) -> Path:
    """The second toss is the first one, turned about the vertical and moved."""
    a = flight(0)
    turn = Rotation.from_rotvec([0.0, 0.0, 1.0])
    p = turn.apply(np.column_stack([a["px"] + 1.0, a["py"] + 2.0, a["pz"]]))
    v = turn.apply(np.column_stack([a[n] for n in ("vx", "vy", "vz")]))
    q = (turn * Rotation.from_quat(np.column_stack([a[n] for n in ("qx", "qy", "qz", "qw")]))).as_quat()
    b = (
        a
        | columns_of("px py pz", p)
        | columns_of("vx vy vz", v)
        | columns_of("qw qx qy qz", one_sign(np.roll(q, 1, 1)))
    )
    return folder_of(folder, FREE, {"t0": a, "t1": b, "t2": flight(2), "t3": flight(3), "t4": flight(4)})


def linked(folder: Path) -> Path:
    """A trajectory that is a link to a file outside."""
    outside = folder / "outside.csv"
    inner = tossed()(folder / "measurement")
    outside.write_text(csv(flight(9)))
    (inner / "trajectories" / "t9.csv").symlink_to(outside)
    return inner


def spec_text(text: str | bytes) -> Writer:
    def write(folder: Path) -> Path:
        tossed()(folder)
        (folder / "measurement.yaml").write_bytes(text if isinstance(text, bytes) else text.encode())
        return folder

    return write


def file_in(name: str, text: str, base: Writer | None = None) -> Writer:
    """A sound measurement with one more or another file in `trajectories/`."""

    def write(folder: Path) -> Path:
        (base or tossed())(folder)
        (folder / "trajectories" / name).write_text(text)
        return folder

    return write


def no_folder(folder: Path) -> Path:
    return folder / "absent"


SPLIT = "split: {train: [%s], test: [%s]}\n"

SAMPLES: dict[str, Writer] = {
    "gap/missing-file": no_folder,
    "gap/path-escape": linked,
    "gap/yaml-syntax": spec_text(FREE.replace("{size_m: [0.1, 0.06, 0.04]}", "{size_m: [0.1, 0.06")),
    "gap/file-too-large": spec_text(FREE + "#" * 1_000_001),
    "gap/unknown-key": spec_text(FREE.replace("mass_kg", "mass")),
    "gap/missing-key": spec_text(FREE.replace("  mass_kg: 0.3\n", "")),
    "gap/inertia-below-load": spec_text(HINGE.replace("inertia_kgm2: 0.01", "inertia_kgm2: 0.001")),
    "gap/invalid-value": spec_text(FREE.replace("mass_kg: 0.3", "mass_kg: -0.3")),
    "gap/unreadable-subject": lambda folder: file_in(
        "../box.urdf", "<robot>", tossed(spec=FREE.replace("  box: {size_m: [0.1, 0.06, 0.04]}", "  urdf: box.urdf"))
    )(folder),
    "gap/unknown-column": spec_text(FREE.replace("w_body", "omega_body")),
    "gap/missing-column": tossed(without("vx")),
    "gap/unreadable-table": file_in("t1.csv", "1.0,2.0,3.0\n4.0,5.0,6.0\n"),
    "gap/unreadable-cells": file_in("t1.csv", csv(flight(1)).replace("\n", "\n0.005,corrupt\n", 1)),
    "gap/trial-id-twice": file_in("t1.CSV", csv(flight(9))),
    "gap/no-clock": spec_text(FREE.replace("t: t, ", "")),
    "gap/empty-trial": file_in("t1.csv", ",".join(flight(1)) + "\n"),
    "gap/non-finite-rows": tossed(with_value("py", 20, np.nan), only_first=True),
    "gap/corrupted-rows": tossed(with_value("px", 20, 5.0), only_first=True),
    "gap/time-not-increasing": tossed(rows(lambda n: np.r_[0:20, 21, 20, 22:n])),
    "gap/clock-restarts": tossed(lambda c: c | {"t": np.where(c["t"] < 0.3, c["t"], c["t"] - 0.2003)}, only_first=True),
    "gap/time-unit": tossed(scaled("t", 1e3), more="rate_hz: 100.0\n"),
    "gap/rate-mismatch": tossed(more="rate_hz: 90.0\n"),
    "gap/dropped-frames": tossed(rows(lambda n: np.r_[0:20, 24:n])),
    "gap/stamp-jitter": tossed(jittered),
    "gap/quaternion-not-unit": tossed(scaled("qw qx qy qz", 1.01)),
    "gap/quaternion-sign": tossed(flipped),
    "gap/quaternion-order": tossed(swapped),
    "gap/angle-wrapped": swung(lambda c: c | {"angle": (c["angle"] + 0.5 + 2 * np.pi) % (2 * np.pi)}),
    "gap/degrees": swung(scaled("rate", 180.0 / np.pi)),
    "gap/degrees-suspected": swung(scaled("angle rate", 180.0 / np.pi)),
    "gap/millimetres": tossed(scaled("px py pz", 1e3)),
    "gap/millimetres-suspected": tossed(
        scaled("px py pz", 1e3),
        FREE.replace(", v: [vx, vy, vz]", "") + "world: {gravity_mps2: [0, 0, 0]}\n",
    ),
    "gap/velocity-frame": tossed(world_rate),
    "gap/velocity-inconsistent": tossed(scaled("vx vy vz", 2.0)),
    "gap/velocity-age": tossed(older),
    "gap/gravity-axis": spec_text(FREE + "world: {gravity_mps2: [0, -9.81, 0]}\n"),
    "gap/duplicate-trials": copied,
    "gap/split-leak": tossed(more=SPLIT % ("t0, t1", "t1, t2")),
    "gap/unknown-trial": tossed(more=SPLIT % ("t0, t1", "t2, toss_3")),
    "gap/unused-trials": tossed(more=SPLIT % ("t0, t1", "t2")),
    "gap/too-few-trials": tossed(trials=2),
    "gap/noise-estimated": tossed(),
    "gap/impact-inconsistent": struck(lambda c: c | {"ny": -c["ny"]}),
    "gap/push-inconsistent": pushes(lambda t: t | {"pose": {n: v[[0, 0]] for n, v in t["pose"].items()}}),
}

NOT_FROM_A_FOLDER: dict[str, str] = {
    "gap/kind-unsupported-yet": "tests/acceptance/test_gap.py",
    "gap/subject-unsupported-yet": "tests/acceptance/test_gap.py",
    "gap/unknown-effect": "tests/simgap/extension/test_extension.py",
    "gap/unknown-place": "tests/acceptance/test_gap.py",
    "gap/missing-report": "tests/acceptance/test_gap_plan.py",
    "gap/stopped": "tests/simgap/test_find_many.py",
    "gap/invalid-extension": "tests/simgap/extension/test_extension.py",
}
