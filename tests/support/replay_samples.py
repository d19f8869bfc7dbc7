"""Small recordings for tests: an arm of one hinge and one slide that pushes a cube over a table."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import trimesh

MODEL = """<mujoco model="arm">
  <compiler angle="radian"/>
  <asset><mesh name="tip" file="tip.stl"/></asset>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 0.1"/>
    <body name="table" pos="0.5 0 0.2"><geom name="top" type="box" size="0.4 0.6 0.02"/></body>
    <body name="arm" pos="0 0 0.3">
      <geom type="cylinder" size="0.05 0.08"/>
      <body name="upper">
        <joint name="turn" axis="0 0 1"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03"/>
        <body name="lower" pos="0.3 0 0">
          <joint name="reach" type="slide" axis="1 0 0"/>
          <geom type="mesh" mesh="tip"/>
          <camera name="wrist" pos="0 0 0.1" fovy="60"/>
        </body>
      </body>
    </body>
    <body name="cube"><freejoint/><geom name="cube" type="box" size="0.02 0.02 0.02"/></body>
  </worldbody>
</mujoco>
"""
CAMERA = {"front": {"fovy_deg": 45.0, "pose_xyz_qxyzw": [1.5, 0.0, 0.8, 0.5, 0.5, 0.5, 0.5]}}
TIP = trimesh.creation.box((0.1, 0.04, 0.04))
Columns = dict[str, np.ndarray]


def stamps(n: int = 12) -> np.ndarray:
    """Irregular, with one repeat."""
    t = np.cumsum(np.random.default_rng(3).uniform(0.01, 0.07, n))
    t[5] = t[4]
    return t


def columns(n: int = 12) -> Columns:
    s = np.linspace(0.0, 1.0, n)
    zero = np.zeros(n)
    return {
        "t": stamps(n),
        "q.turn": 1.2 * s - 0.6,
        "qd.turn": np.full(n, 1.2),
        "q.reach": 0.2 * s**2,
        "qd.reach": 0.4 * s,
        **{f"obj.cube.p{c}": v for c, v in zip("xyz", (0.5 + 0.1 * s, -0.1 * s, zero + 0.24), strict=True)},
        **{f"obj.cube.q{c}": v for c, v in zip("xyzw", (zero, zero, np.sin(s), np.cos(s)), strict=True)},
    }


def write(path: Path, rows: Columns) -> None:
    pq.write_table(pa.table(rows), path)


def staged(folder: Path, rows: Columns | None = None, model: str = MODEL, meshes: bool = True) -> Path:
    """A folder in the layout of the staged recordings."""
    (folder / "raw").mkdir(parents=True, exist_ok=True)
    write(folder / "episode.parquet", columns() if rows is None else rows)
    (folder / "scene.json").write_text(json.dumps({"cameras": CAMERA}))
    (folder / "raw" / "model.xml").write_text(model)
    if meshes:
        arrays = {"lower|geom4|v": TIP.vertices, "lower|geom4|f": TIP.faces}
        np.savez(folder / "meshes_body_frame.npz", **arrays, allow_pickle=True)
    return folder


def states(rows: Columns) -> np.ndarray:
    """Rows [time, qpos, qvel] of MODEL."""
    cube = [rows[f"obj.cube.{c}"] for c in ("px", "py", "pz", "qw", "qx", "qy", "qz")]
    rates = [rows["qd.turn"], rows["qd.reach"], *np.zeros((6, len(rows["t"])))]
    return np.stack([rows["t"], rows["q.turn"], rows["q.reach"], *cube, *rates], axis=1)


def robomimic(path: Path, model: str = MODEL, demos: int = 2) -> Path:
    """An HDF5 file as robomimic has them, and its mesh beside."""
    path.parent.mkdir(parents=True, exist_ok=True)
    TIP.export(path.parent / "tip.stl")
    with h5py.File(path, "w") as file:
        for k in range(demos):
            group = file.create_group(f"data/demo_{9 + k}")
            group.attrs["model_file"] = model
            group["states"] = states(columns(12 + k))
            group["actions"] = np.random.default_rng(k).normal(size=(11 + k, 7))
    return path
