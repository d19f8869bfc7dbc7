"""Writes the inputs that no installed package has: meshes, broken files, a broken scene, an episode and recordings.

Every function takes a folder that exists and writes the same bytes each time (fixed seeds, no clock).
"""

from __future__ import annotations

import json
import shutil
import struct
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import trimesh
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation
from trimesh.visual.color import ColorVisuals

GRAVITY_MPS2 = 9.81
Columns = Mapping[str, np.ndarray]

_USD = """\
#usda 1.0
(
    defaultPrim = "step"
    metersPerUnit = 0.01
    upAxis = "Y"
)
def Xform "step"
{
    def Mesh "block"
    {
        int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
        int[] faceVertexIndices = [0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7]
        point3f[] points = [(0, 0, 0), (12, 0, 0), (12, 4, 0), (0, 4, 0), (0, 0, 7), (12, 0, 7), (12, 4, 7), (0, 4, 7)]
        color3f[] primvars:displayColor = [(0.7, 0.2, 0.1)]
        uniform token subdivisionScheme = "none"
    }
}
"""


def meshes(folder: Path) -> None:
    """Formats that no installed package has a mesh of: GLB and glTF of several parts, USD in centimetres, OFF."""
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.cylinder(0.03, 0.1, sections=24), node_name="cup")
    handle = trimesh.creation.box((0.02, 0.01, 0.06))
    handle.visual = ColorVisuals(handle, face_colors=(40, 90, 200, 255))
    scene.add_geometry(handle, node_name="handle", transform=trimesh.transformations.translation_matrix((0.035, 0, 0)))
    scene.export(folder / "two_parts.glb")
    (folder / "torus").mkdir()
    trimesh.Scene(trimesh.creation.torus(0.05, 0.015, 24, 12)).export(folder / "torus" / "torus.gltf")
    (folder / "step.usda").write_text(_USD)
    trimesh.creation.icosphere(2, 0.04).export(folder / "ball.off")


def rod_in_millimetres(path: Path) -> None:
    """A rod that lies along y, as STL, 8 mm thick and 120 mm long."""
    rod = trimesh.creation.cylinder(4.0, 120.0, sections=16)
    rod.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0)))
    rod.export(path)


def broken_meshes(folder: Path) -> None:
    """Files that are to be refused, or taken with findings."""
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    glb = trimesh.Scene(box).export(file_type="glb")
    assert isinstance(glb, bytes)
    (folder / "truncated.glb").write_bytes(glb[: len(glb) // 2])
    (folder / "page.glb").write_bytes(b"<!doctype html><title>404</title>")
    (folder / "empty.obj").write_bytes(b"")
    (folder / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "not_finite.obj").write_text("v 0 0 0\nv 1 0 nan\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n")
    (folder / "index.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
    (folder / "short.stl").write_bytes(bytes(80) + struct.pack("<I", 500) + bytes(100))
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "../../outside.bin", "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    (folder / "outside.gltf").write_text(json.dumps(document))
    (folder / "broken.dae").write_text("<?xml version='1.0'?><COLLADA><library_geometries>")
    (folder / "broken.usda").write_text(_USD.replace("point3f[] points = [", "point3f[] points = [[["))
    (folder / "notes.xyz").write_text("0 0 0\n")


def broken_scene(path: Path) -> None:
    """A scene program with several mistakes at once."""
    path.write_text(
        "scene: broken\n"
        "background: {asset: {type: box, size_m: [1.2, 0.8, 0.04]}}\n"
        "anchors: {tabletop: {object: background, surface: auto}}\n"
        "objects:\n"
        "  - {id: a, asset: {type: box, size_m: [0.1, -0.1, 0.1]}}\n"
        "  - {id: a, asset: {type: cylinder, radius_m: 0.1, height_m: 0.1}, colour: red}\n"
        "layout:\n"
        "  nodes:\n"
        "    a: {object: a, placement: {type: surface, surface: table}}\n"
        "    b: {object: nothing, placement: {type: surface, surface: tabletop, ranges: {yaw_deg: [20, -20]}}}\n"
        "relations:\n"
        "  - {left_of: [a, c]}\n"
    )


def episode(folder: Path, arm: Path) -> None:
    """The arm `panda.urdf` of `arm` passes over a table on a smooth path; 160 rows with irregular stamps."""
    waypoints = np.array(
        [
            (0.0, 0.3, 0.0, -2.2, 0.0, 2.5),
            (0.5, 0.55, 0.0, -2.0, 0.0, 2.55),
            (0.5, 0.8, 0.0, -1.95, 0.0, 2.75),
            (-0.6, 0.6, 0.0, -1.9, 0.0, 2.5),
            (-0.6, 0.82, 0.0, -1.85, 0.0, 2.7),
            (0.0, 0.3, 0.0, -2.2, 0.0, 2.5),
        ]
    )
    t_s = np.cumsum(np.random.default_rng(0).uniform(0.03, 0.07, 160))
    path = CubicSpline(np.linspace(t_s[0], t_s[-1], len(waypoints)), waypoints, bc_type="clamped")
    rows = {"t": t_s}
    for k in range(waypoints.shape[1]):
        rows |= {f"q.panda_joint{k + 1}": path(t_s)[:, k], f"qd.panda_joint{k + 1}": path(t_s, 1)[:, k]}
    for joint, angle in (("panda_joint7", 0.8), ("panda_finger_joint1", 0.04), ("panda_finger_joint2", 0.04)):
        rows |= {f"q.{joint}": np.full(len(t_s), angle), f"qd.{joint}": np.zeros(len(t_s))}
    pq.write_table(pa.table(rows), folder / "episode.parquet")
    shutil.copyfile(arm / "panda.urdf", folder / "panda.urdf")
    top = {"type": "box", "name": "tabletop", "size_m": [0.7, 1.0, 0.04]}
    eye = {"name": "front", "fovy_deg": 45, "position_m": [1.6, 0, 0.9], "quat_wxyz": [0.6124, 0.3536, 0.3536, 0.6124]}
    scene = {
        "robots": [{"name": "panda", "model": "panda.urdf"}],
        "objects": [],
        "fixtures": [{"name": "table", "position_m": [0.55, 0, -0.08], "shapes": [top]}],
        "cameras": [eye],
    }
    (folder / "episode.json").write_text(json.dumps(scene, indent=1))


def mechanism(folder: Path) -> None:
    """A door on a vertical axis that is pushed and let go; Coulomb friction is hidden from the declared model."""
    friction_Nm, inertia_kgm2, noise_rad = 0.008, 0.01, 5e-4
    _measurement(
        folder,
        "name: door\nkind: mechanism\ncolumns: {t: t, q_door: angle}\n"
        f"subject:\n  joints:\n    - {{name: door, inertia_kgm2: {inertia_kgm2}}}\n",
    )
    rng, t_s = np.random.default_rng(0), np.arange(0.0, 3.0, 0.01)
    slowing_radps2 = friction_Nm / inertia_kgm2
    for k in range(10):
        rate_radps = rng.uniform(0.8, 3.0) * (-1) ** k
        moving_s = np.minimum(t_s, abs(rate_radps) / slowing_radps2)
        angle = rate_radps * moving_s - 0.5 * np.sign(rate_radps) * slowing_radps2 * moving_s**2
        _table(folder, f"push_{k}", {"t": t_s, "angle": angle + noise_rad * rng.normal(size=len(t_s))})


def free_body(folder: Path) -> None:
    """Tosses of a box; drag linear in the velocity (0.15 N s/m) is hidden from the declared model."""
    mass_kg, drag_Nspm = 0.1, 0.15
    _measurement(
        folder,
        "name: box\nkind: free_body\ncolumns: {t: t, p: [px, py, pz], q_wxyz: [qw, qx, qy, qz]}\n"
        f"subject:\n  box: {{size_m: [0.1, 0.06, 0.04]}}\n  mass_kg: {mass_kg}\n",
    )
    rng, t_s = np.random.default_rng(1), np.arange(60) * 0.01
    span_s = mass_kg / drag_Nspm
    end_mps = np.array([0.0, 0.0, -GRAVITY_MPS2 * span_s])
    for k in range(12):
        start_mps = rng.normal([1.5, 0.0, 3.0], 0.5)
        p = (start_mps - end_mps) * span_s * (1.0 - np.exp(-t_s / span_s))[:, None] + end_mps * t_s[:, None]
        rate_radps = np.array([0.0, 0.0, rng.normal(0.0, 4.0)])
        quats = np.roll(Rotation.from_rotvec(t_s[:, None] * rate_radps).as_quat(canonical=False), 1, axis=1)
        readings = np.column_stack([p + rng.normal(0.0, 5e-4, p.shape), quats + rng.normal(0.0, 5e-4, quats.shape)])
        columns = dict(zip(("px", "py", "pz", "qw", "qx", "qy", "qz"), readings.T, strict=True))
        _table(folder, f"toss_{k:02d}", {"t": t_s, **columns})


def impact(folder: Path) -> None:
    """Impacts of a disc with restitution 0.5; the tangential velocity and the turn lose 40 %."""
    names = ("ux", "uy", "uw", "vx", "vy", "vw", "nx", "ny", "nw", "tx", "ty", "tw")
    _measurement(
        folder,
        "name: disc\nkind: impact\ncolumns:\n  velocity_before: [ux, uy, uw]\n  velocity_after: [vx, vy, vw]\n"
        "  normal_jacobian: [nx, ny, nw]\n  tangent_jacobian: [tx, ty, tw]\n"
        "subject: {mass_kg: 0.1, inertia_kgm2: [1.0e-4, 1.0e-4, 1.0e-4]}\n",
    )
    rng, rows = np.random.default_rng(2), 120
    before = np.column_stack([rng.normal(0.0, 1.0, rows), rng.uniform(-3.0, -1.0, rows), rng.normal(0.0, 5.0, rows)])
    after = before * [0.6, -0.5, 0.6] + rng.normal(0.0, 0.01, before.shape)
    one, zero = np.ones(rows), np.zeros(rows)
    values = np.column_stack([before, after, zero, one, zero, one, zero, 0.03 * one])
    _table(folder, "events", dict(zip(names, values.T, strict=True)))


def push(folder: Path) -> None:
    """Straight pushes of a block through its mass centre, with a friction of 0.3 that is not declared."""
    _measurement(
        folder,
        "name: block\nkind: push\n"
        "columns: {p: [x, y, z], q_wxyz: [qw, qx, qy, qz], tip_t: t, tip_p: [x, y, z], force_t: t, force: [fx, fy]}\n"
        "subject: {box: {size_m: [0.1, 0.1, 0.02]}, mass_kg: 1.0}\n",
    )
    rng, t_s = np.random.default_rng(3), np.linspace(0.0, 1.0, 50)
    for k in range(16):
        yaw_rad, way_m = rng.uniform(-3.0, 3.0), rng.uniform(0.02, 0.06)
        along = np.array([np.cos(yaw_rad), np.sin(yaw_rad), 0.0])
        quat = np.array([np.cos(yaw_rad / 2), 0.0, 0.0, np.sin(yaw_rad / 2)])
        places = np.array([[0.0, 0.0, 0.01], way_m * along + [0.0, 0.0, 0.01]]) + rng.normal(0.0, 2e-4, (2, 3))
        tip = (way_m * t_s - 0.05)[:, None] * along + [0.0, 0.0, 0.01]
        force_N = 0.3 * GRAVITY_MPS2 * along[:2] + rng.normal(0.0, 0.05, (len(t_s), 2))
        turned = {f"q{axis}": np.full(2, part) for axis, part in zip("wxyz", quat, strict=True)}
        _table(folder, f"p{k:02d}.pose", dict(zip("xyz", places.T, strict=True)) | turned)
        _table(folder, f"p{k:02d}.tip", {"t": t_s, **dict(zip("xyz", tip.T, strict=True))})
        _table(folder, f"p{k:02d}.force", {"t": t_s, "fx": force_N[:, 0], "fy": force_N[:, 1]})


def broken_measurement(folder: Path) -> None:
    """A measurement with an unknown key and a column that no table has."""
    text = "name: door\nkind: mechanism\ncolour: red\ncolumns: {t: t, q_door: tilt}\nsubject: {joints: []}\n"
    _measurement(folder, text)
    _table(folder, "push_0", {"t": np.arange(5.0), "angle": np.zeros(5)})


MEASUREMENTS: dict[str, Callable[[Path], None]] = {
    "mechanism": mechanism,
    "free_body": free_body,
    "impact": impact,
    "push": push,
    "broken": broken_measurement,
}


def _measurement(folder: Path, text: str) -> None:
    (folder / "trajectories").mkdir()
    (folder / "measurement.yaml").write_text("schema_version: 1\n" + text)


def _table(folder: Path, name: str, columns: Columns) -> None:
    values = np.column_stack(list(columns.values()))
    path = folder / "trajectories" / f"{name}.csv"
    np.savetxt(path, values, fmt="%.10g", delimiter=",", header=",".join(columns), comments="")
