"""Entry point of an asset cell, `python -m assetkit.batch.worker REQUEST.json`: one source asset becomes packages.

The request names the source, the options, the folders and the engine (`sim.named_engine`). The result is written where
the request says, as a `StoredResult` that the batch reads.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from assetkit.batch import result_store
from assetkit.batch.item_cells import candidate_of, rejected
from assetkit.options import Options
from assetkit.pipeline import process_source
from assetkit.storage import finding_from_exception
from jobs.cell import peak_memory_mb
from jobs.network import leave_network
from sim.named_engine import load_engine


def main(request_file: str) -> None:
    """Carry out the request in the file, without network unless its options name a model. For a process of its own."""
    request = json.loads(Path(request_file).read_text())
    if not Options.model_validate(request["options"]).calls_a_model:
        leave_network()  # Before anything of the source is read. Where the system forbids it, limits are what is left.
    process_request(request)


def process_request(request: dict[str, Any]) -> None:
    """Process the source named by the request and write its result where the request says."""
    candidate = candidate_of(request)
    out, options = Path(request["out"]), Options.model_validate(request["options"])
    with load_engine(request["engine"])() as simulator:
        item = process_source(
            candidate,
            options=options,
            simulator=simulator,
            out=out,
            work_dir=Path(request["work_dir"]),
            fresh=request["fresh"],
        )
    item = item.model_copy(update={"peak_memory_mb": round(peak_memory_mb(), 1)})
    try:
        stored = result_store.stored_from(item, candidate, out)
    except OSError as error:  # A file that the verdict rests on has vanished: it is no verdict on the source.
        cause = finding_from_exception(error, candidate.file, (out,))
        stored = result_store.StoredResult(item=rejected(candidate, cause), main_sha256="")
    result_store.write_stored(Path(request["note"]), stored)


if __name__ == "__main__":
    main(sys.argv[1])
