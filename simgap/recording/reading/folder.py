"""Finds the files of a measurement folder, names them, keeps paths inside the folder, hashes contents."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable
from pathlib import Path

from schemas.diagnostics import InvalidInput, Location, finding
from simgap.recording.reading.tables import SUFFIXES

SPEC_FILE = "measurement.yaml"
TRAJECTORIES = "trajectories"


def inside(root: Path, relative: str, where: Location) -> Path:
    """The regular file or folder `relative` below `root`.

    Raises InvalidInput: `gap/path-escape` when it lies outside (links followed), `gap/missing-file` when it is absent
    or a pipe.
    """
    try:
        path = (root / relative.replace("\\", "/")).resolve()
        escapes = not path.is_relative_to(root.resolve())
    except (ValueError, OSError, RuntimeError):  # RuntimeError: a circle of links
        path, escapes = root / "absent", False
    if escapes:
        raise InvalidInput(
            finding("gap/path-escape", f"'{relative}' leads out of the measurement folder", where=where, value=relative)
        )
    if not (path.is_file() or path.is_dir()):
        raise InvalidInput(finding("gap/missing-file", f"there is no '{relative}' in the folder", where=where))
    return path


def trajectory_files(root: Path) -> tuple[Path, ...]:
    """Tables in `trajectories/`, in natural order of their names (`t2` before `t10`).

    Raises InvalidInput: `gap/missing-file` without any, `gap/path-escape` for a link that leaves the folder.
    """
    folder = root / TRAJECTORIES
    paths = sorted(_tables(folder), key=lambda p: natural_key(p.name)) if folder.is_dir() else []
    if not paths:
        text = f"no {', '.join(SUFFIXES)} in {TRAJECTORIES}/"
        raise InvalidInput(finding("gap/missing-file", text, where=Location(file=TRAJECTORIES)))
    for path in paths:
        if path.is_symlink() or folder.is_symlink():
            inside(root, f"{TRAJECTORIES}/{path.name}", Location(file=f"{TRAJECTORIES}/{path.name}"))
    return tuple(paths)


def natural_key(name: str) -> list[tuple[int, int, str]]:
    """Sorts digits by value and letters as text."""
    return [(0, int(part), part) if part.isdigit() else (1, 0, part) for part in re.split(r"([0-9]+)", name) if part]


def content_hash(root: Path, files: Iterable[Path]) -> str:
    """SHA-256 over names and bytes of the files, in order of their names."""
    total = hashlib.sha256()
    for path in sorted(set(files)):
        with path.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        total.update(f"{path.relative_to(root).as_posix()}\0{digest}\n".encode())
    return total.hexdigest()


def _tables(folder: Path) -> Iterable[Path]:
    return (p for p in folder.iterdir() if p.suffix.lower() in SUFFIXES and not p.name.startswith(".") and p.is_file())
