"""Runs the suites of acceptance on packages that lie on disk, each in a cell of its own; also those of other makers."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from pathlib import Path

from assetkit.batch.item_cells import DEFAULT_LIMITS, ENVIRONMENT, LOST_CODES, PRELOAD
from assetkit.library.acceptance_request import AcceptanceReport, AcceptanceRequest
from jobs.cell import Limits
from jobs.warm import run_module, warm_cells
from schemas.diagnostics import Location, finding

_CELL = "assetkit.library.accept_worker"


def accept_files(
    requests: Sequence[AcceptanceRequest], *, limits: Limits = DEFAULT_LIMITS
) -> Iterator[tuple[Path, AcceptanceReport]]:
    """Each main file with its report, in order: a package that hangs or crashes the engine affects no other."""
    warm = warm_cells(PRELOAD, env=ENVIRONMENT) if len(requests) > 1 else nullcontext()
    with warm, tempfile.TemporaryDirectory(prefix="mana") as folder:
        for request in requests:
            asked, answered = Path(folder) / "request.json", Path(folder) / "report.json"
            answered.unlink(missing_ok=True)
            asked.write_text(request.model_dump_json())
            result = run_module(_CELL, [os.fspath(asked), os.fspath(answered)], limits, env=ENVIRONMENT)
            file = Path(request.main_file)
            if answered.is_file():
                yield file, AcceptanceReport.model_validate_json(answered.read_bytes())
                continue
            code = LOST_CODES.get(result.status, "asset/worker-crashed")
            headline = "the suites did not come to an end on this package"
            lost = finding(code, headline, where=Location(file=file.name), value=round(result.seconds, 1), unit="s")
            yield file, AcceptanceReport(findings=(lost,))
