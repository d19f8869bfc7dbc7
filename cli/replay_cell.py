"""Check variants in a process of its own: the entry point of a cell, and what is made of its answer."""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path

from jobs.cache import write_atomically
from jobs.cell import Limits
from jobs.warm import run_module
from replay.check_output import check_output
from schemas.diagnostics import Diagnostic, InvalidInput
from schemas.replay import VariantCheck

LIMITS = Limits(seconds=4 * 3600.0, memory_mb=16384)


def checked(
    out: Path, packages: Path | None, clearance_m: float | None, meshes: Path | None, settle: bool
) -> list[VariantCheck]:
    """The check of every variant below `out`. Raises InvalidInput, and RuntimeError when a library crashes."""
    with tempfile.TemporaryDirectory(prefix="mana") as folder:
        note = Path(folder) / "checks.json"
        options = {"out": out, "packages": packages, "clearance_m": clearance_m, "meshes": meshes, "settle": settle}
        result = run_module("cli.replay_cell", [json.dumps(options, default=str), str(note)], LIMITS)
        if result.status != "ok":
            raise RuntimeError(f"checking {result.status}: {result.output[-1500:]}")
        answer = json.loads(note.read_bytes())
    if "refused" in answer:
        raise InvalidInput(Diagnostic.model_validate(answer["refused"]))
    return [VariantCheck.model_validate(row) for row in answer["checks"]]


def main(options: str, note: str) -> None:
    """Check, and leave rows or the reason for refusing in `note`."""
    from sim.bullet_scene import settle_scene  # PyBullet prints when it is imported.

    given = json.loads(options)
    packages, meshes = (Path(p) if p else None for p in (given["packages"], given["meshes"]))
    settle = settle_scene if given["settle"] else None
    try:
        rows = check_output(Path(given["out"]), packages, settle, given["clearance_m"], meshes)
        answer = {"checks": [row.model_dump() for row in rows]}
    except InvalidInput as refused:
        answer = {"refused": refused.diagnostic.model_dump(mode="json")}
    write_atomically(Path(note), json.dumps(answer).encode())


if __name__ == "__main__":
    main(*sys.argv[1:3])
