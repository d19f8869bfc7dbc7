"""Run a module in a cell with a JSON request and a JSON result: the calling and the called side."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from jobs.cache import write_atomically
from jobs.cell import Limits
from jobs.warm import run_module
from schemas.diagnostics import InvalidInput, finding

ONE_THREAD = {"OMP_NUM_THREADS": "1", "JE_ARROW_MALLOC_CONF": "background_thread:false"}  # Else forks are not sound.


def ask(
    module: str, given: dict[str, Any], limits: Limits, name: str, *, stopped: str, scratch: Path | None = None
) -> dict[str, Any]:
    """The result that `python -m MODULE GIVEN NOTE` writes to NOTE; `refused` with a diagnostic if it stops.

    `stopped` is the code of that diagnostic. The note lies below `scratch`, which the machine of the cell has to see;
    by default where temporary files lie.
    """
    with tempfile.TemporaryDirectory(prefix=".mana", dir=scratch) as folder:
        note = Path(folder) / "answer.json"
        result = run_module(module, [json.dumps(given), str(note)], limits)
        if result.status != "ok":
            ended = finding(stopped, f"'{name}': {result.status}: {result.output[-300:].strip()}")
            return {"refused": ended.model_dump(mode="json")}
        return json.loads(note.read_bytes())


def answer(work: Callable[[dict[str, Any]], dict[str, Any]], given: str, note: str) -> None:
    """Do the work, and write its result, or the reason for refusing, to `note`."""
    try:
        found = work(json.loads(given))
    except InvalidInput as refused:
        found = {"refused": refused.diagnostic.model_dump(mode="json")}
    write_atomically(Path(note), json.dumps(found).encode())
