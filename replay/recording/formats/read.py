"""Read recordings of every format as episodes; the format is recognised by the layout of file or folder."""

from __future__ import annotations

from pathlib import Path

from replay.recording.episode import Episode
from replay.recording.formats.episode_folder import is_episode_folder, is_table, read_episode_folder
from replay.recording.formats.lerobot import is_lerobot, read_lerobot
from replay.recording.formats.maniskill import is_maniskill, read_maniskill
from replay.recording.formats.robomimic import is_robomimic, read_robomimic
from replay.recording.formats.staged_folder import is_staged_folder, read_staged_folder
from replay.recording.recorded_numbers import invalid_recording
from schemas.diagnostics import InvalidInput


def is_recording(path: Path) -> bool:
    """Whether a file or folder is a recording in one of the formats, by its layout; a damaged file counts as one."""
    if leads_out(path):
        return True
    kinds = (is_lerobot, is_table, is_staged_folder, is_robomimic, is_maniskill)
    try:
        return path.exists() and any(of_kind(path) for of_kind in kinds)
    except InvalidInput:
        return True


def read_episodes(path: Path, meshes: Path | None = None, scene: Path | None = None) -> tuple[Episode, ...]:
    """All episodes of a file or folder, in its order.

    `meshes` is where mesh files that a model names are looked for, `scene` the `episode.json` of a recording that does
    not state itself what moved (LeRobot, ManiSkill). Raises InvalidInput.
    """
    if not path.exists():
        raise invalid_recording("replay/missing-file", f"'{path.name}' is absent", path.name)
    if leads_out(path):
        raise invalid_recording("replay/path-escape", f"'{path.name}' is a link out of its folder", path.name)
    if is_lerobot(path):
        return read_lerobot(path, scene, meshes)
    if is_table(path) and (scene or is_episode_folder(path) or not is_staged_folder(path)):
        return (read_episode_folder(path, scene, meshes),)
    if is_staged_folder(path):
        return (read_staged_folder(path),)
    if is_robomimic(path):
        return read_robomimic(path, meshes)
    if is_maniskill(path):
        return read_maniskill(path, scene, meshes)
    raise invalid_recording(
        "replay/unknown-format", f"'{path.name}' is no recording in a format that Mana reads", path.name
    )


def leads_out(path: Path) -> bool:
    """Whether a file is a link to one outside of its folder; links to whole folders may lead anywhere."""
    try:
        return path.is_file() and not path.resolve().is_relative_to(path.parent.resolve())
    except (OSError, RuntimeError):  # a circle of links
        return False


def read_episode(path: Path, meshes: Path | None = None, scene: Path | None = None) -> Episode:
    """The first episode of a file or folder. Raises InvalidInput."""
    return read_episodes(path, meshes, scene)[0]
