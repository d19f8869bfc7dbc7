"""Tables of our own columns: a folder with `episode.parquet`, or a Parquet file (docs/reference/episode-folder.md).

`episode.json` beside the table, or a description that the user names, maps columns to robots and bodies: so a log of a
real robot needs nothing else.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from replay.recording.description.from_description import DescribedRecording, read_description, rename_columns
from replay.recording.episode import Episode
from replay.recording.files.tables import read_columns
from replay.recording.recorded_numbers import invalid_recording
from schemas.replay.episode import EPISODE_FILE

TABLE = "episode.parquet"


def is_table(path: Path) -> bool:
    """Whether a path is such a folder or file, described or not."""
    return (path / TABLE).is_file() or (path.suffix == ".parquet" and path.is_file())


def is_episode_folder(path: Path) -> bool:
    """Whether a path is such a folder or file with its description beside it."""
    return is_table(path) and (_folder(path) / EPISODE_FILE).is_file()


def read_episode_folder(path: Path, scene: Path | None = None, meshes: Path | None = None) -> Episode:
    """The episode of a folder or a file; `scene` is the description, if it is not beside. Raises InvalidInput."""
    table = path if path.is_file() else path / TABLE
    file = scene or _folder(path) / EPISODE_FILE
    if not file.is_file():
        message = f"nothing says which robot moved: put {EPISODE_FILE} beside '{table.name}', or name it with --scene"
        raise invalid_recording("replay/missing-file", message, EPISODE_FILE)
    description = read_description(file)
    columns = rename_columns(read_columns(table), description.columns, table.name)
    described = DescribedRecording(description, file.parent, columns, table.name, meshes)
    name = description.name if not scene else ""
    return replace(described.episode(name or path.stem, path), description=file if path.is_file() else scene)


def _folder(path: Path) -> Path:
    return path.parent if path.is_file() else path
