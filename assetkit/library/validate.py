"""Finds the USD assets at a path and validates each in a cell of its own, also assets that Mana did not make."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from pathlib import Path

from assetkit.batch.item_cells import ENVIRONMENT, LOST_CODES
from jobs.cell import CellResult, Limits
from jobs.warm import run_module, warm_cells
from schemas.diagnostics import Diagnostic, Location, finding
from usdio.read.root_layers import root_files

DEFAULT_LIMITS = Limits(seconds=120.0, memory_mb=8192)
_USD = {".usd", ".usda", ".usdc", ".usdz"}
_CELL, _PRELOAD = "assetkit.library.judge_file", "gate.preload"


def main_usd_files(path: Path) -> list[Path]:
    """The asset files at `path`: itself, those of a folder or package, or those of every package of a library.

    Of files in one folder that are layers of each other only the root layers count. Hidden folders are left out.
    """
    if path.is_file():
        return [path]
    for pattern in ("*", "*/*", "*/*/*"):
        layers = sorted(p for p in path.glob(pattern) if p.suffix in _USD and p.is_file() and not _hidden(p, path))
        if layers:
            return root_files(layers)
    return []


def _hidden(file: Path, folder: Path) -> bool:
    return any(part.startswith(".") for part in file.relative_to(folder).parts)


def validate_files(
    files: Sequence[Path], *, external: bool = True, limits: Limits = DEFAULT_LIMITS
) -> Iterator[tuple[Path, tuple[Diagnostic, ...]]]:
    """Each file with its findings (`judge_file.validate_file`), computed in a cell: a file that hangs or crashes its
    validators affects no other.
    """
    warm = warm_cells(_PRELOAD, env=ENVIRONMENT) if len(files) > 1 else nullcontext()
    with warm, tempfile.TemporaryDirectory(prefix="mana") as folder:
        for file in files:
            note = Path(folder) / "findings.json"
            note.unlink(missing_ok=True)
            arguments = [os.fspath(file.absolute()), os.fspath(note), "outside" if external else "gate"]
            result = run_module(_CELL, arguments, limits, env=ENVIRONMENT)
            if note.is_file():
                yield file, tuple(Diagnostic.model_validate(d) for d in json.loads(note.read_text()))
            else:
                yield file, (_lost(file, result, limits),)


def _lost(file: Path, result: CellResult, limits: Limits) -> Diagnostic:
    bound = {"timeout": (limits.seconds, "s"), "out_of_memory": (limits.memory_mb, "MiB")}
    limit, unit = bound.get(result.status, (0, "exit status"))
    value = round(result.seconds, 1) if result.status == "timeout" else result.returncode
    headline = "the validators did not come to an end on this file"
    code = LOST_CODES.get(result.status, "asset/worker-crashed")
    return finding(code, headline, where=Location(file=file.name), value=value, bound=limit, unit=unit)
