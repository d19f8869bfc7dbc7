"""Entry point of a cell that searches one measurement folder: request and result are JSON."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from jobs.json_cell import answer
from simgap.run import find


def search_one(request: dict[str, Any]) -> dict[str, Any]:
    """The verdict of the report of one folder; report and page are below its `out`."""
    report = find(request["measurement"], Path(request["out"]), engine=request["engine"], quick=request["quick"])
    return {"verdict": report.verdict.model_dump(mode="json")}


if __name__ == "__main__":
    answer(search_one, *sys.argv[1:3])
