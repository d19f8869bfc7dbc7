"""SHA-256 digests of the recorded streams of a source, by which a copy is verified bit for bit."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow.parquet as pq

from replay.recording.files.hdf5 import child, open_hdf5
from replay.recording.formats.lerobot import INFO, info_without_videos, is_lerobot
from replay.recording.recorded_numbers import invalid_recording

DEEPEST_GROUP = 32  # groups within groups: a hard link to a group above has no end


def stream_digests(source: Path, part: str = "") -> dict[str, str]:
    """Digests by stream: of each data set below the group `part` of an HDF5 file, else of the bytes of each file."""
    if source.is_dir():
        files = recording_files(source, part)
        return {p.relative_to(source).as_posix(): _of_bytes(recording_bytes(source, p)) for p in files}
    if not h5py.is_hdf5(source):
        return {source.name: _of_bytes(source.read_bytes())}
    digests: dict[str, str] = {}
    with open_hdf5(source) as file:
        _collect(child(file, part, source.name) if part else file, part, source.name, digests)
    return digests


def recording_files(folder: Path, part: str = "") -> list[Path]:
    """The regular files below a folder that belong to a recording; no links, nothing hidden.

    Of a LeRobot data set those of `meta/`, the tables that hold episode `part` and the description; no videos, which
    show the scene as it was.
    """
    files = (p for p in sorted(folder.rglob("*")) if p.is_file() and not p.is_symlink())
    visible = [p for p in files if not any(name.startswith(".") for name in p.relative_to(folder).parts)]
    if not is_lerobot(folder):
        return visible
    return [p for p in visible if _belongs(p, p.relative_to(folder), part)]


def recording_bytes(folder: Path, file: Path) -> bytes:
    """A file of `recording_files` as a copy has it: the same, but a LeRobot data set names no videos any more."""
    videos = is_lerobot(folder) and file == folder / INFO
    return info_without_videos(folder) if videos else file.read_bytes()


def _belongs(path: Path, relative: Path, part: str) -> bool:
    if relative.parts[0] == "data" and path.suffix == ".parquet":
        return int(part) in pq.read_table(path, columns=["episode_index"])["episode_index"].to_pylist()
    return relative.parts[0] not in ("data", "videos", "images")


def _collect(group: Any, at: str, file: str, digests: dict[str, str]) -> None:
    if at.count("/") > DEEPEST_GROUP:
        raise invalid_recording("replay/unreadable", f"groups within groups without end: '{at[:80]}...'", file)
    for name in sorted(group):
        item = child(group, name, file)
        if isinstance(item, h5py.Group):
            _collect(item, f"{at}/{name}", file, digests)
        elif isinstance(item, h5py.Dataset):
            data = item[()]
            head = f"{item.dtype.str}{item.shape}"
            texts = item.dtype.kind == "O"  # in full: NumPy leaves out the middle of long arrays
            body = repr(np.asarray(data).tolist()).encode() if texts else np.ascontiguousarray(data).tobytes()
            digests[f"{at}/{name}"] = _of_bytes(head.encode() + body)


def _of_bytes(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
