"""Folders with `episode.parquet`, `scene.json` and `meshes_body_frame.npz` beside a MuJoCo model in `raw/`.

Columns: `t` [s]; `q.<joint>`, `qd.<joint>`; `obj.<body>.px ... qw` (quaternion xyzw). Cameras: `scene.json`, and
`camera_moving.parquet` where they move. Meshes: `<body>|<geom>|v` in the frame of the body.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, Field, ValidationError

from replay.recording.episode import Camera, Episode
from replay.recording.files.mesh_archive import MESHES, MeshArchive
from replay.recording.files.tables import column_poses, read_columns
from replay.recording.formats.robomimic import raw_states, recorded_states
from replay.recording.mjcf.bodies import RecordedBodies, is_free
from replay.recording.mjcf.episode_parts import episode_parts, uncovered_links
from replay.recording.recorded_numbers import RecordedStates, checked_numbers, checked_stamps, invalid_recording, poses
from replay.recording.robot_files import recorded_mjcf
from schemas.files.regular_file import read_regular

TABLE, SCENE, CAMERAS = "episode.parquet", "scene.json", "camera_moving.parquet"


def is_staged_folder(path: Path) -> bool:
    """Whether a path is such a folder."""
    return (path / TABLE).is_file() and (path / SCENE).is_file() and (path / "raw").is_dir()


def read_staged_folder(path: Path) -> Episode:
    """The episode of a folder. Raises InvalidInput."""
    columns = read_columns(path / TABLE)
    if "t" not in columns:
        raise invalid_recording("replay/missing-column", "no column 't'", TABLE)
    t_s = checked_stamps(columns["t"], TABLE)
    names = dict.fromkeys(c.split(".")[1] for c in columns if c.startswith("obj."))
    recorded = RecordedStates(
        t_s,
        {c[2:]: checked_numbers(v, c, TABLE) for c, v in columns.items() if c.startswith("q.")},
        {c[3:]: checked_numbers(v, c, TABLE) for c, v in columns.items() if c.startswith("qd.")},
        {name: column_poses(columns, f"obj.{name}", TABLE) for name in names},
    )
    files = sorted((path / "raw").glob("*.xml"))
    if len(files) != 1:
        raise invalid_recording("replay/missing-file", f"{len(files)} model files in raw/, not one", "raw")
    model = RecordedBodies(recorded_mjcf(files[0], path))
    recorded = _completed(recorded, model, path)
    robots, objects, fixtures = episode_parts(model, recorded, MeshArchive(path / MESHES).points)
    notes = uncovered_links(model, robots)
    return Episode(path.name, path, t_s, robots, objects, fixtures, _cameras(path, len(t_s)), notes=notes)


def _completed(recorded: RecordedStates, model: RecordedBodies, path: Path) -> RecordedStates:
    """Joints and bodies that the table leaves out (doors, say), from the states in `raw/` with the very same stamps."""
    joints = {joint.name for of_body in model.joints for joint in of_body if not is_free(joint)}
    bodies = {joint.child for of_body in model.joints for joint in of_body if is_free(joint)}
    if joints <= recorded.q.keys() and bodies <= recorded.X_WB.keys():
        return recorded
    for file in sorted((path / "raw").glob("*.hdf5")):
        for states in raw_states(file):
            if len(states) == len(recorded.t_s) and np.array_equal(states[:, 0], recorded.t_s):
                raw = recorded_states(model, states, file.name)
                q, qd = {**raw.q, **recorded.q}, {**raw.qd, **recorded.qd}
                return RecordedStates(recorded.t_s, q, qd, {**raw.X_WB, **recorded.X_WB})
    return recorded


class _CameraRow(BaseModel):
    """A camera of `scene.json`."""

    fovy_deg: Annotated[float, Field(gt=0.0, lt=180.0)]
    pose_xyz_qxyzw: tuple[float, float, float, float, float, float, float] | None = None


class _Scene(BaseModel):
    """What is read of `scene.json`."""

    cameras: dict[str, _CameraRow] = {}


def _cameras(path: Path, n: int) -> tuple[Camera, ...]:
    try:
        given = _Scene.model_validate_json(read_regular(path / SCENE)).cameras
    except (ValidationError, OSError) as error:
        raise invalid_recording("replay/unreadable", f"{SCENE}: {error}", SCENE) from None
    moving = read_columns(path / CAMERAS) if (path / CAMERAS).is_file() else {}
    cameras = []
    for name, camera in given.items():
        if f"{name}.px" in moving:
            X_WC = column_poses(moving, name, CAMERAS)
        elif camera.pose_xyz_qxyzw is not None:
            row = np.array([camera.pose_xyz_qxyzw])
            X_WC = np.broadcast_to(poses(row[:, :3], row[:, 3:], name, SCENE), (n, 4, 4))
        else:
            raise invalid_recording("replay/missing-column", f"camera '{name}' has no pose", SCENE)
        if len(X_WC) != n:
            raise invalid_recording(
                "replay/state-size", f"{len(X_WC)} poses of camera '{name}' for {n} samples", CAMERAS
            )
        cameras.append(Camera(name, X_WC, float(np.radians(camera.fovy_deg))))
    return tuple(cameras)
