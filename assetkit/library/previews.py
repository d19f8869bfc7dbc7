"""Renders pictures (PNG), or a GIF of moving joints, of any readable file or package, in a cell; makes no package."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path

from assetkit.batch.item_cells import DEFAULT_LIMITS, ENVIRONMENT, LOST_CODES
from assetkit.library.validate import main_usd_files
from jobs.cell import Limits
from jobs.warm import run_module
from render.camera import STANDARD_VIEWS
from render.modes.request import Mode
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding


def pictures(
    path: Path,
    out: Path,
    modes: Sequence[Mode],
    *,
    views: int = len(STANDARD_VIEWS),
    size_px: int = 512,
    limits: Limits = DEFAULT_LIMITS,
) -> list[Path]:
    """Draw the first object of a source file, or a package, in these modes; returns the PNGs written.

    Reading and drawing run in a cell, because the file may be anything. Raises InvalidInput when the file cannot be
    read or takes its cell down, and FileNotFoundError when a folder holds no USD file.
    """
    return _drawn(path, out, ("modes", str(views), str(size_px), *modes), limits)


def animation(
    path: Path, out: Path, *, frames: int, joints: Sequence[str] = (), limits: Limits = DEFAULT_LIMITS
) -> Path:
    """Draw the GIF `out` of a source file or package whose joints (all, or those named) move there and back.

    `frames` pictures lead from one end to the other. Raises as `pictures`, and InvalidInput (`asset/missing-joint`) for
    a rigid object or an unknown joint.
    """
    return _drawn(path, out, ("joints", str(frames), *joints), limits)[0]


def _drawn(path: Path, out: Path, what: Sequence[str], limits: Limits) -> list[Path]:
    if path.is_dir() and not main_usd_files(path):
        raise FileNotFoundError(path)
    with tempfile.TemporaryDirectory(prefix="mana") as folder:
        note = Path(folder) / "note.json"
        arguments = [os.fspath(path.absolute()), os.fspath(out), os.fspath(note), *what]
        result = run_module("assetkit.library.preview_worker", arguments, limits, env=ENVIRONMENT)
        reply = json.loads(note.read_text()) if note.is_file() else {}
    if "refused" in reply:
        raise InvalidInput(Diagnostic.model_validate(reply["refused"]))
    if "written" not in reply:
        code = LOST_CODES.get(result.status, "asset/worker-crashed")
        last = (result.output.strip().splitlines() or ["no output"])[-1]
        headline = f"drawing {result.status.replace('_', ' ')}: {last[:200]}"
        raise InvalidInput(finding(code, headline, where=Location(file=path.name), value=result.returncode))
    return [Path(p) for p in reply["written"]]
