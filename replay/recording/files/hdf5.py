"""Read HDF5 files with care: no link out of the file, no data set beyond a bound on memory, no endless reading."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from jobs.cache import file_sha256
from jobs.cell import Limits
from jobs.warm import run_module
from replay.recording.recorded_numbers import invalid_recording
from schemas.arrays import FloatArray

MAX_VALUES = 100_000_000
MOST_LINKS = 16  # soft links one after the other; as many as libhdf5 follows
PATIENCE_S = 60.0  # and a second for each MB, to read a file once
_faults: dict[str, str] = {}  # by digest of what was read


def open_hdf5(path: Path) -> h5py.File:
    """The file, to be closed by the caller. Raises InvalidInput.

    A cell has read it to its end before: on a damaged file libhdf5 may crash, or never come to an end.
    """
    try:
        fault = _fault(path)
        if not fault:
            return h5py.File(path, "r")
    except OSError as error:
        fault = str(error)
    raise invalid_recording("replay/unreadable", f"{path.name}: {fault}", path.name)


def _fault(path: Path) -> str:
    """The fault of a file, empty for none; a cell determines it once for the same content."""
    found = path.stat()
    digest = _digest(path, found.st_size, found.st_mtime_ns)
    if digest not in _faults:
        limits = Limits(seconds=PATIENCE_S + found.st_size / 1e6)
        result = run_module("replay.recording.files.hdf5_probe", [str(path)], limits)
        ended = {"ok": "", "failed": result.output[-300:].strip()}
        _faults[digest] = ended.get(result.status, f"reading it ended by {result.status} after {result.seconds:.0f} s")
    return _faults[digest]


@cache
def _digest(path: Path, _size: int, _mtime_ns: int) -> str:
    return file_sha256(path)


def child(group: Any, name: str, file: str) -> Any:
    """A group or data set that lies in the same file, None where there is none. Raises InvalidInput for one outside.

    Soft links are followed here, a step at a time, because libhdf5 would open another file on the way.
    """
    words, followed = name.split("/"), 0
    while words:
        word, *words = words
        if not word or word == ".":
            continue
        link = group.get(word, getlink=True) if isinstance(group, h5py.Group) else None
        if link is None:
            return None
        if isinstance(link, h5py.ExternalLink):
            raise invalid_recording("replay/path-escape", f"'{name}' is a link to another file", file)
        if isinstance(link, h5py.SoftLink):
            followed += 1
            if followed > MOST_LINKS:
                raise invalid_recording("replay/unreadable", f"'{name}' is a link that leads in a circle", file)
            group = group.file if link.path.startswith("/") else group
            words = [*link.path.split("/"), *words]
            continue
        group = group[word]
    if isinstance(group, h5py.Dataset) and (group.external or group.is_virtual):
        raise invalid_recording("replay/path-escape", f"'{name}' is stored in another file", file)
    return group


def values(group: Any, name: str, file: str) -> FloatArray:
    """A numeric data set as float64. Raises InvalidInput where it is absent, too large or damaged."""
    data = child(group, name, file)
    if not isinstance(data, h5py.Dataset):
        raise invalid_recording("replay/missing-column", f"no data set '{name}' in '{group.name}'", file)
    if data.size is None or data.size > MAX_VALUES or data.dtype.kind not in "fiub":
        raise invalid_recording("replay/unreadable", f"'{data.name}': {data.size} values of type {data.dtype}", file)
    try:
        return np.asarray(data[()], dtype=np.float64)
    except OSError as error:
        raise invalid_recording("replay/unreadable", f"'{data.name}': {error}", file) from None


def numbered(group: Any, prefix: str) -> list[str]:
    """Names `<prefix><number>` in a group, by number."""
    names = [name for name in group if re.fullmatch(re.escape(prefix) + r"\d+", name)]
    return sorted(names, key=lambda name: int(name[len(prefix) :]))


def text(attribute: Any) -> str:
    """An attribute as text; bytes that are no UTF-8, which h5py keeps as surrogates, become question marks."""
    raw = attribute if isinstance(attribute, bytes) else str(attribute).encode("utf-8", "surrogateescape")
    return raw.decode("utf-8", "replace")
