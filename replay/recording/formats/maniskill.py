"""ManiSkill trajectories (.h5): `traj_<k>/env_states/actors|articulations/<name>`; a description names the models.

An actor is a row [position 3, quaternion wxyz 4, velocities 6], an articulation [root like an actor 13, qpos, qvel].
There are no stamps: sample i is at i / control frequency, from the JSON file beside or the description. Layout:
maniskill.readthedocs.io, user guide, demonstrations.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from replay.recording.description.from_description import DescribedRecording, pose_columns, read_description
from replay.recording.episode import Episode
from replay.recording.files.hdf5 import child, numbered, open_hdf5, values
from replay.recording.files.tables import Columns
from replay.recording.recorded_numbers import invalid_recording
from schemas.files.regular_file import read_regular
from schemas.replay.episode import EPISODE_FILE, EpisodeDescription

ROOT = 13


def is_maniskill(path: Path) -> bool:
    """Whether a path is an HDF5 file of trajectories with states."""
    if not (path.is_file() and h5py.is_hdf5(path)):
        return False
    with open_hdf5(path) as file:
        return any(child(file, f"{name}/env_states", path.name) is not None for name in numbered(file, "traj_")[:1])


def read_maniskill(path: Path, scene: Path | None = None, meshes: Path | None = None) -> tuple[Episode, ...]:
    """One episode for each trajectory; `scene` is the description, else `episode.json` beside. Raises InvalidInput."""
    beside = scene or path.parent / EPISODE_FILE
    if not beside.is_file():
        message = "nothing says which robot moved: put episode.json beside the file, or name it with --scene"
        raise invalid_recording("replay/missing-file", message, EPISODE_FILE)
    description = read_description(beside)
    rate_hz = _control_hz(path, description)
    episodes = []
    with open_hdf5(path) as file:
        for name in numbered(file, "traj_"):
            columns = _columns(child(file, f"{name}/env_states", path.name), description, path.name)
            n = len(next(iter(columns.values()), []))
            columns["t"] = np.arange(n) / rate_hz
            described = DescribedRecording(description, beside.parent, columns, path.name, meshes)
            episode = described.episode(f"{path.stem}_{name}", path, name)
            episodes.append(replace(episode, description=beside))
    return tuple(episodes)


def json_of_part(path: Path, part: str) -> bytes | None:
    """The JSON file beside with the one entry of trajectory `part`, as ManiSkill's tools expect it, or None.

    They walk `episodes` and open `traj_<episode_id>` of each (`mani_skill/trajectory/merge_trajectory.py`).
    """
    try:
        about: dict[str, Any] = json.loads(read_regular(path.with_suffix(".json")))
        mine = [entry for entry in about["episodes"] if f"traj_{entry['episode_id']}" == part]
        return (json.dumps(about | {"episodes": mine}, indent=2) + "\n").encode()
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _control_hz(path: Path, description: EpisodeDescription) -> float:
    if description.control_hz is not None:
        return description.control_hz
    try:
        info: dict[str, Any] = json.loads(read_regular(path.with_suffix(".json")))["env_info"]
        return float(info["env_kwargs"]["sim_config"]["control_freq"])
    except (OSError, ValueError, KeyError, TypeError):
        message = "the control frequency is not known: give `control_hz` in episode.json"
        raise invalid_recording("replay/missing-column", message, path.name) from None


def _columns(states: Any, description: EpisodeDescription, file: str) -> Columns:
    columns: Columns = {}
    for entry in description.objects:
        columns |= pose_columns(
            f"obj.{entry.name}", _rows_of_width(values(states, f"actors/{entry.name}", file), 7, file)
        )
    for robot in description.robots:
        row = _rows_of_width(values(states, f"articulations/{robot.name}", file), ROOT, file)
        columns |= pose_columns(f"base.{robot.name}", row)
        dofs = (row.shape[1] - ROOT) // 2
        if len(robot.joints) != dofs or row.shape[1] != ROOT + 2 * dofs:
            message = f"articulation '{robot.name}' has rows of {row.shape[1]} for {len(robot.joints)} `joints`"
            raise invalid_recording("replay/state-size", message, file)
        for k, joint in enumerate(robot.joints):
            columns[f"q.{robot.name}.{joint}"] = row[:, ROOT + k]
            columns[f"qd.{robot.name}.{joint}"] = row[:, ROOT + dofs + k]
    return columns


def _rows_of_width(rows: np.ndarray, least: int, file: str) -> np.ndarray:
    if rows.ndim != 2 or rows.shape[1] < least:
        raise invalid_recording(
            "replay/state-size", f"states of shape {rows.shape}, with at least {least} columns expected", file
        )
    return rows
