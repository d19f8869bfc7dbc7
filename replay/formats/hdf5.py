"""HDF5 files read with care: no link out of the file, no data set larger than the memory."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from replay.recorded import stop
from schemas.model import FloatArray

MAX_VALUES = 100_000_000


def opened(path: Path) -> h5py.File:
    """The file, to be closed by the caller. Raises InvalidInput."""
    try:
        return h5py.File(path, "r")
    except OSError as error:
        raise stop("replay/unreadable", f"{path.name}: {error}", path.name) from None


def child(group: Any, name: str, file: str) -> Any:
    """A group or data set that lies in the same file, None where there is none. Raises InvalidInput for one outside."""
    for word in name.split("/"):
        link = group.get(word, getlink=True) if isinstance(group, h5py.Group) else None
        if link is None:
            return None
        if isinstance(link, h5py.ExternalLink):
            raise stop("replay/path-escape", f"'{name}' is a link to another file", file)
        group = group.get(word)
    if isinstance(group, h5py.Dataset) and (group.external or group.is_virtual):
        raise stop("replay/path-escape", f"'{name}' is stored in another file", file)
    return group


def values(group: Any, name: str, file: str) -> FloatArray:
    """A numeric data set as float64. Raises InvalidInput where it is absent, too large or damaged."""
    data = child(group, name, file)
    if not isinstance(data, h5py.Dataset):
        raise stop("replay/missing-column", f"no data set '{name}' in '{group.name}'", file)
    if data.size is None or data.size > MAX_VALUES or data.dtype.kind not in "fiub":
        raise stop("replay/unreadable", f"'{data.name}': {data.size} values of type {data.dtype}", file)
    try:
        return np.asarray(data[()], dtype=np.float64)
    except OSError as error:
        raise stop("replay/unreadable", f"'{data.name}': {error}", file) from None


def numbered(group: Any, prefix: str) -> list[str]:
    """Names `<prefix><number>` in a group, by number."""
    found = [name for name in group if re.fullmatch(re.escape(prefix) + r"\d+", name)]
    return sorted(found, key=lambda name: int(name[len(prefix) :]))


def text(attribute: Any) -> str:
    """An attribute as text."""
    return attribute.decode("utf-8", "replace") if isinstance(attribute, bytes) else str(attribute)
