"""Recordings of every format as episodes."""

from __future__ import annotations

from pathlib import Path

from replay.episode import Episode
from replay.formats.robomimic import is_robomimic, read_robomimic
from replay.formats.staged_folder import is_staged_folder, read_staged_folder
from replay.recorded import stop


def read_episodes(path: Path, meshes: Path | None = None) -> tuple[Episode, ...]:
    """All episodes of a file or folder, in its order. `meshes`: where mesh files named by a model are looked for.

    Raises InvalidInput.
    """
    if not path.exists():
        raise stop("replay/missing-file", f"'{path.name}' is absent", path.name)
    if is_staged_folder(path):
        return (read_staged_folder(path),)
    if is_robomimic(path):
        return read_robomimic(path, meshes)
    raise stop("replay/unknown-format", f"'{path.name}' is no recording in a format that Mana reads", path.name)


def read_episode(path: Path, meshes: Path | None = None) -> Episode:
    """The first episode of a file or folder. Raises InvalidInput."""
    return read_episodes(path, meshes)[0]
