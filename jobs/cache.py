"""Content-addressed result store: keys are hashes of all inputs, so results are found or rebuilt, never stale."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from jobs.durable import sync


def content_key(*parts: Any) -> str:
    """A SHA-256 hex key over JSON-serialisable parts; equal parts give equal keys in every process."""
    text = json.dumps(parts, sort_keys=True, default=str, ensure_ascii=False)
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()  # File names need not be UTF-8.


def file_sha256(path: Path) -> str:
    """SHA-256 of a file's bytes."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def changed_files(folder: Path, hashes: Mapping[str, str]) -> list[str]:
    """Names of files below a folder that are absent or do not match their SHA-256, in the given order.

    A name that leads out of the folder counts as absent, unopened.
    """
    return [name for name, sha in hashes.items() if not _is_below(folder, name) or file_sha256(folder / name) != sha]


def _is_below(folder: Path, name: str) -> bool:
    path = PurePosixPath(name)
    return not path.is_absolute() and ".." not in path.parts and (folder / path).is_file()


@dataclass(frozen=True)
class Cache:
    """A folder of results, two levels deep so that no folder grows past a few thousand entries."""

    folder: Path

    def path(self, kind: str, key: str, suffix: str) -> Path:
        """The path of the result of `kind` under `key`, whether it exists or not; creates its folder."""
        path = self.folder / kind / key[:2] / f"{key}{suffix}"
        path.parent.mkdir(parents=True, exist_ok=True)
        return path


def write_atomically(path: Path, data: bytes, *, durable: bool = False) -> None:
    """Write `data` so that a reader sees the old file or the whole new one, never a part; `durable`: also after a power
    cut. A file that could not be written whole does not stay.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        temporary.write_bytes(data)
        if durable:
            sync(temporary)
        temporary.replace(path)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise
