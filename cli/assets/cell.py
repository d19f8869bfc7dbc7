"""The entry point of a cell: one request file, one source asset. Chooses PyBullet as the simulator."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from assetkit.batch import result_store
from assetkit.batch.ingest import candidate_of, rejected
from assetkit.options import Options
from assetkit.pipeline import process_source
from assetkit.storage import finding_of
from jobs.cell import peak_memory_mb
from sim.bullet.simulator import BulletSimulator


def main(request_file: str) -> None:
    """Process the source named by the request and leave its note where the request says."""
    request = json.loads(Path(request_file).read_text())
    candidate = candidate_of(request)
    out = Path(request["out"])
    with BulletSimulator() as simulator:
        item = process_source(
            candidate,
            options=Options.model_validate(request["options"]),
            simulator=simulator,
            out=out,
            work_dir=Path(request["work_dir"]),
            fresh=request["fresh"],
        )
    item = item.model_copy(update={"peak_memory_mb": round(peak_memory_mb(), 1)})
    try:
        stored = result_store.stored_from(item, candidate, out)
    except OSError as error:  # A file that the verdict rests on has vanished: it is no verdict on the source.
        cause = finding_of(error, candidate.file, (out,))
        stored = result_store.Stored(item=rejected(candidate, cause), main_sha256="")
    result_store.remember(Path(request["note"]), stored)


if __name__ == "__main__":
    main(sys.argv[1])
