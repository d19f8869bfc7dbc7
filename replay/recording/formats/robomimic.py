"""HDF5 files of robosuite and robomimic: `data/demo_<k>/states` are flattened MuJoCo states [time, qpos, qvel].

The model is the attribute `model_file` of a demonstration: XML text, or the name of a file beside. Meshes: the archive
`meshes_body_frame.npz` beside the file or one folder up, else the files that the model names.
"""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from replay.recording.episode import Episode
from replay.recording.files.hdf5 import child, numbered, open_hdf5, text, values
from replay.recording.files.mesh_archive import MeshArchive
from replay.recording.mjcf.bodies import RecordedBodies, is_free
from replay.recording.mjcf.cameras import model_cameras
from replay.recording.mjcf.episode_parts import episode_parts, uncovered_links
from replay.recording.mjcf.meshes import MeshFiles
from replay.recording.recorded_numbers import RecordedStates, checked_numbers, checked_stamps, invalid_recording, poses
from replay.recording.robot_files import recorded_mjcf, recorded_mjcf_text
from schemas.arrays import FloatArray

PICTURE_PX = (256, 256)


def is_robomimic(path: Path) -> bool:
    """Whether a path is an HDF5 file of demonstrations with states."""
    if not (path.is_file() and h5py.is_hdf5(path)):
        return False
    with open_hdf5(path) as file:
        data = child(file, "data", path.name)
        return isinstance(data, h5py.Group) and bool(numbered(data, "demo_"))


def read_robomimic(path: Path, meshes: Path | None = None) -> tuple[Episode, ...]:
    """One episode for each demonstration, by number. Raises InvalidInput."""
    episodes, models = [], {}
    with open_hdf5(path) as file:
        data = child(file, "data", path.name)
        for demo in numbered(data, "demo_"):
            group = child(data, demo, path.name)
            model_text = text(group.attrs.get("model_file", ""))
            if model_text not in models:
                models[model_text] = _model(model_text, path)
            episodes.append(_episode(path, demo, models[model_text], values(group, "states", path.name), meshes))
    return tuple(episodes)


def _model(text: str, path: Path) -> RecordedBodies:
    if not text:
        raise invalid_recording(
            "replay/missing-file", "no demonstration model: attribute 'model_file' is absent", path.name
        )
    if not text.lstrip().startswith("<"):
        return RecordedBodies(recorded_mjcf(path.parent / text, path.parent))
    return RecordedBodies(recorded_mjcf_text(text.encode(), path))


def _episode(path: Path, demo: str, model: RecordedBodies, states: FloatArray, meshes: Path | None) -> Episode:
    recorded = recorded_states(model, states, path.name)
    archive = MeshArchive.beside(path)
    points = archive.points if archive else MeshFiles(model, path.parent, meshes).points
    parts = episode_parts(model, recorded, points)
    cameras = model_cameras(model, parts, len(recorded.t_s), PICTURE_PX)
    notes = uncovered_links(model, parts[0])
    return Episode(f"{path.stem}_{demo}", path, recorded.t_s, *parts, cameras, f"data/{demo}", notes)


def raw_states(path: Path) -> list[FloatArray]:
    """The states (n, 1 + nq + nv) of every demonstration of a file. Raises InvalidInput."""
    with open_hdf5(path) as file:
        data = child(file, "data", path.name)
        names = numbered(data, "demo_") if isinstance(data, h5py.Group) else []
        return [values(child(data, name, path.name), "states", path.name) for name in names]


def recorded_states(model: RecordedBodies, states: FloatArray, file: str) -> RecordedStates:
    """Rows [time, qpos, qvel] (n, 1 + nq + nv) taken apart joint by joint. Raises InvalidInput."""
    joints = [joint for of_body in model.joints for joint in of_body]
    free = sum(is_free(joint) for joint in joints)
    nq, nv = len(joints) + 6 * free, len(joints) + 5 * free
    if states.ndim != 2 or states.shape[1] != 1 + nq + nv:
        message = (
            f"states of shape {states.shape}; the model has {nq} positions and {nv} rates, with time {1 + nq + nv}"
        )
        raise invalid_recording("replay/state-size", message, file)
    t_s = checked_stamps(states[:, 0], file)
    states = checked_numbers(states, "states", file)
    q, qd, X_WB = {}, {}, {}
    at_q, at_v = 1, 1 + nq
    for joint in joints:
        if is_free(joint):
            row = states[:, at_q : at_q + 7]
            X_WB[joint.child] = poses(row[:, :3], np.roll(row[:, 3:], -1, axis=1), joint.child, file)
        else:
            q[joint.name], qd[joint.name] = states[:, at_q], states[:, at_v]
        at_q, at_v = (at_q + 7, at_v + 6) if is_free(joint) else (at_q + 1, at_v + 1)
    return RecordedStates(t_s, q, qd, X_WB)
