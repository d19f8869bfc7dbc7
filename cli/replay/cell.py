"""Check variants in a process of its own: the entry point of a cell, and what is made of its answer."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from jobs.cell import Limits
from jobs.json_cell import answer, ask
from replay.verification.check_output import check_output
from schemas.diagnostics import Diagnostic, InvalidInput
from schemas.replay.documents import VariantCheck

LIMITS = Limits(seconds=4 * 3600.0, memory_mb=16384)


def checked(
    out: Path, packages: Path | None, clearance_m: float | None, meshes: Path | None, settle: bool
) -> list[VariantCheck]:
    """The check of every variant below `out`. Raises InvalidInput, also where a library crashes (`replay/stopped`)."""
    paths = {"out": str(out), "packages": packages and str(packages), "meshes": meshes and str(meshes)}
    reply = ask(
        "cli.replay.cell",
        {**paths, "clearance_m": clearance_m, "settle": settle},
        LIMITS,
        out.name,
        stopped="replay/stopped",
    )
    if "refused" in reply:
        raise InvalidInput(Diagnostic.model_validate(reply["refused"]))
    return [VariantCheck.model_validate(row) for row in reply["checks"]]


def check(given: dict[str, Any]) -> dict[str, Any]:
    """`checks`, one for each variant below `out`."""
    from sim.bullet.scene import settle_scene  # PyBullet prints when it is imported.

    packages, meshes = (Path(p) if p else None for p in (given["packages"], given["meshes"]))
    settle = settle_scene if given["settle"] else None
    rows = check_output(Path(given["out"]), packages, settle, given["clearance_m"], meshes)
    return {"checks": [row.model_dump() for row in rows]}


if __name__ == "__main__":
    answer(check, *sys.argv[1:3])
