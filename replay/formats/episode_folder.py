"""Our own folder: `episode.parquet` and `episode.json`, as docs/reference/episode-folder.md describes them."""

from __future__ import annotations

from pathlib import Path

from replay.described import Described, read_description, renamed
from replay.episode import Episode
from replay.formats.tables import read_columns
from schemas.episode import EPISODE_FILE

TABLE = "episode.parquet"


def is_episode_folder(path: Path) -> bool:
    """Whether a path is such a folder."""
    return (path / EPISODE_FILE).is_file() and (path / TABLE).is_file()


def read_episode_folder(path: Path, meshes: Path | None = None) -> Episode:
    """The episode of a folder. Raises InvalidInput."""
    description = read_description(path / EPISODE_FILE)
    columns = renamed(read_columns(path / TABLE), description.columns, TABLE)
    return Described(description, path, columns, TABLE, meshes).episode(description.name or path.name, path)
