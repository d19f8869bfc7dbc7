"""LeRobot data sets, v2.1 and v3: `meta/info.json` and Parquet tables; a description maps numbers to bodies.

v2.1 has one table for each episode (`data_path` of info.json), v3 several episodes in one; rows carry `episode_index`
and `timestamp`. The description is `episode.json` beside `meta/`, or named by the user; `columns` in it maps joints
to them, e.g. `{"q.joint1": "observation.state[0]"}`. Layout: huggingface/lerobot, `datasets/utils.py`.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from replay.recording.description.from_description import DescribedRecording, read_description, rename_columns
from replay.recording.episode import Episode
from replay.recording.files.tables import Columns, read_columns
from replay.recording.recorded_numbers import invalid_recording
from schemas.files.regular_file import read_regular
from schemas.replay.episode import EPISODE_FILE

INFO = "meta/info.json"
VERSIONS = ("v2.0", "v2.1", "v3.0")
SOURCE_TIME = "source_timestamp"


def is_lerobot(path: Path) -> bool:
    """Whether a path is such a data set."""
    return (path / INFO).is_file() and (path / "data").is_dir()


def read_lerobot(path: Path, scene: Path | None = None, meshes: Path | None = None) -> tuple[Episode, ...]:
    """One episode for each `episode_index`; `scene` is the description. Raises InvalidInput."""
    info = read_info(path)
    file = scene or path / EPISODE_FILE
    if not file.is_file():
        message = "nothing says which robot moved: put episode.json beside meta/, or name it with --scene"
        raise invalid_recording("replay/missing-file", message, EPISODE_FILE)
    description = read_description(file)
    episodes = []
    for table in tables(path, info):
        columns = read_columns(table)
        for name in ("episode_index", "timestamp"):
            if name not in columns:
                raise invalid_recording("replay/missing-column", f"no column '{name}'", table.name)
        for index in np.unique(columns["episode_index"]).astype(int).tolist():
            rows = _rows(columns, index)
            rows["t"] = rows.get(SOURCE_TIME, rows["timestamp"])
            named = rename_columns(rows, description.columns, table.name)
            described = DescribedRecording(description, file.parent, named, table.name, meshes)
            episode = described.episode(f"{path.name}_{index:06d}", path, str(index))
            episodes.append(replace(episode, description=file))
    return tuple(sorted(episodes, key=lambda episode: int(episode.part)))


def read_info(path: Path) -> dict[str, Any]:
    """`meta/info.json`. Raises InvalidInput for a version that is not read."""
    try:
        info = json.loads(read_regular(path / INFO))
    except ValueError as error:
        raise invalid_recording("replay/unreadable", f"{INFO}: {error}", INFO) from None
    if info.get("codebase_version") not in VERSIONS:
        message = f"data set of version '{info.get('codebase_version')}'; read are {', '.join(VERSIONS)}"
        raise invalid_recording("replay/unknown-format", message, INFO)
    return info


def info_without_videos(path: Path) -> bytes:
    """`meta/info.json` as it is when no video comes along: the library opens every file that it names."""
    info = read_info(path)
    videos = [name for name, feature in info.get("features", {}).items() if feature.get("dtype") == "video"]
    if not videos:
        return read_regular(path / INFO)
    rest = {name: feature for name, feature in info["features"].items() if name not in videos}
    return (json.dumps(info | {"features": rest}, indent=4) + "\n").encode()


def tables(path: Path, info: dict[str, Any]) -> list[Path]:
    """The tables of a data set in the order of their names. Raises InvalidInput where there is none."""
    parquet_files = sorted(p for p in (path / "data").rglob("*.parquet") if p.is_file() and not p.is_symlink())
    if not parquet_files:
        raise invalid_recording("replay/missing-file", f"no table below data/ ({info.get('data_path', '')})", INFO)
    return parquet_files


def _rows(columns: Columns, index: int) -> Columns:
    chosen = columns["episode_index"] == index
    return {name: values[chosen] for name, values in columns.items()}
