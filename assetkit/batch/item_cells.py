"""Runs one cell (child process) per source of a batch, with stored results, and yields one report item per source."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

from assetkit.batch import ownership, result_store
from assetkit.batch.decisions import read_decisions, with_decisions
from assetkit.options import Options
from assetkit.sources.discover import SourceAsset
from assetkit.sources.source_file import SourceFile, refusal
from assetkit.storage import finding_from_exception, is_storable, storage_failed
from jobs.cache import content_key, file_sha256, write_atomically
from jobs.cell import CellResult, Limits, run_cell
from jobs.placement import ONE_CELL, Placement, cells_at
from jobs.schedule import run_all
from jobs.warm import run_module
from schemas.decision import Decision
from schemas.diagnostics import Diagnostic, finding
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem

LOST_CODES = {
    "timeout": "asset/worker-timeout",
    "out_of_memory": "asset/worker-out-of-memory",
    "crashed": "asset/worker-crashed",
    "lost": "asset/worker-crashed",
    "failed": "asset/worker-crashed",
}
ENDPOINT_CODES = ("asset/annotator-unreachable", "asset/annotator-failed")
# One core per asset, the batch fills the others; and USD starts no threads, which could not be forked.
ENVIRONMENT = {"OMP_NUM_THREADS": "1", "PXR_WORK_THREAD_LIMIT": "1", "PYTHONHASHSEED": "0"}
_IMPORT_OUTPUT = "#"  # How a line begins that OpenUSD prints on import, given a thread limit.
READY_STUDIO_FROM = 6  # sources; a ready studio takes the processor time that so many assets save with it
WORKER, PRELOAD = "assetkit.batch.worker", "assetkit.batch.preload"
WORK = ".work"  # below the output folder: files of the running batch
DEFAULT_LIMITS = Limits(seconds=300.0, memory_mb=8192)


@dataclass(frozen=True)
class Batch:
    """One run over sources: output folder, options, worker, where its cells run and their limits.

    `engine` names the simulator that the caller chooses (`sim.named_engine`). `worker` runs one request file, given as
    its last argument: a Python module, or any command. `preload` names a module that imports what a worker module
    needs: it is imported once, and every worker starts as a fork of that process. `given` are the files and folders
    that hold the sources, which machines of a cluster have to see.
    """

    out: Path
    options: Options
    engine: str
    worker: str | tuple[str, ...] = WORKER
    preload: str = PRELOAD
    placement: Placement = ONE_CELL
    limits: Limits = DEFAULT_LIMITS
    resume: bool = False
    fresh: bool = False
    given: tuple[Path, ...] = ()


class Sources(Protocol):
    """Sources in order, perhaps read from a file one after another."""

    def __len__(self) -> int: ...

    def __iter__(self) -> Iterator[SourceAsset]: ...


def run_items(candidates: Sources, batch: Batch) -> Iterator[ReportItem]:
    """The items of `numbered_items` alone."""
    for _, item in numbered_items(candidates, batch):
        yield item


def numbered_items(candidates: Sources, batch: Batch) -> Iterator[tuple[int, ReportItem]]:
    """Yield position and report item of each source as it finishes; every item is on disk before it is yielded.

    A source whose files, options, libraries and code are unchanged and whose packages are intact is taken from the
    store (`cached = ("item",)`). Crashes and time-outs are tried again unless `resume` is set. Verdicts that do not
    follow from the source (`assetkit.storage.NEVER_STORED`) are never stored: the next run tries again. Stopping the
    iteration (Ctrl-C) ends the running cells and stores nothing of them. Decisions of people in the output folder are
    replayed. The caller holds the lock of the output folder (`jobs.lock`). Raises InvalidInput when the file of
    decisions cannot be read.
    """
    batch.out.mkdir(parents=True, exist_ok=True)
    decisions = read_decisions(batch.out)
    studio = {"MANA_STUDIO": "ready"} if len(candidates) >= READY_STUDIO_FROM else {}
    env = ENVIRONMENT | {"MANA_ENGINE": batch.engine} | studio
    with cells_at(batch.placement, batch.preload, env=env, shared=[batch.out], needed=batch.given) as jobs:
        for (position, _), item in run_all(lambda n: _item(n[1], batch, decisions), enumerate(candidates), jobs=jobs):
            yield position, item


def _item(candidate: SourceAsset, batch: Batch, decisions: Sequence[Decision]) -> ReportItem:
    """The item of one source: from the store, or made in a cell. An error affects this item only."""
    try:
        candidate = ownership.resolve_asset_id(candidate, batch.out)
        if (unusable := refusal(candidate.file)) is not None:
            return rejected(candidate, unusable)
        batch = replace(batch, options=with_decisions(batch.options, candidate, decisions))
        note = result_store.result_file(candidate, batch.out, batch.options)
        stored = None if batch.fresh else result_store.read_stored(note)
        if stored is not None and result_store.is_current(stored, candidate, batch.out):
            transient = set(stored.item.codes) & {*LOST_CODES.values(), *ENDPOINT_CODES}
            if batch.resume or not transient:
                return stored.item.model_copy(update={"cached": ("item",)})
        return _in_cell(candidate, batch, note)
    except OSError as error:
        return rejected(candidate, finding_from_exception(error, candidate.file, (batch.out,)))


def _in_cell(candidate: SourceAsset, batch: Batch, note: Path) -> ReportItem:
    main_sha256 = file_sha256(candidate.file.path)
    work = batch.out / WORK / content_key(str(candidate.file.path.absolute()), candidate.asset_id)[:16]
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    request = work / "request.json"
    handed_over = work / "note.json"  # Where the worker leaves its note; only this process writes into the store.
    write_atomically(request, json.dumps(_request(candidate, batch, handed_over, work)).encode())
    note.unlink(missing_ok=True)
    result = _run_worker(batch, request)
    stored = result_store.read_stored(handed_over)
    if stored is None:
        stored = result_store.StoredResult(item=_lost(candidate, result, batch.limits), main_sha256=main_sha256)
    if result.status != "cancelled":
        follows = is_storable(stored.item) and result.status != "lost"  # A machine that died says nothing of a source.
        ownership.record_ownership(candidate, stored.item.packages, batch.out, complete=follows)
        # A source that was written to meanwhile has another hash, and which content was read is not known.
        if follows and stored.main_sha256 == main_sha256:
            result_store.write_stored(note, stored)
    shutil.rmtree(work, ignore_errors=True)
    return stored.item


def _run_worker(batch: Batch, request: Path) -> CellResult:
    if isinstance(batch.worker, str):
        return run_module(batch.worker, [str(request)], batch.limits, env=ENVIRONMENT)
    return run_cell([*batch.worker, str(request)], batch.limits, env=ENVIRONMENT)


def _request(candidate: SourceAsset, batch: Batch, note: Path, work: Path) -> dict[str, object]:
    return {
        "given": candidate.given,
        "path": str(candidate.file.path.absolute()),
        "root": str(candidate.file.root.absolute()),
        "format": candidate.format,
        "asset_id": candidate.asset_id,
        "engine": batch.engine,
        "options": batch.options.model_dump(),
        "out": str(batch.out.absolute()),
        "fresh": batch.fresh,
        "work_dir": str(work.absolute()),
        "note": str(note.absolute()),
    }


def candidate_of(request: dict[str, str]) -> SourceAsset:
    """The candidate that a request file describes."""
    source = SourceFile(Path(request["path"]), Path(request["root"]))
    return SourceAsset(request["given"], source, request["format"], request["asset_id"])


def _lost(candidate: SourceAsset, result: CellResult, limits: Limits) -> ReportItem:
    """The item of a source whose worker ended without a result."""
    bound = {"timeout": (result.seconds, limits.seconds, "s"), "out_of_memory": (None, limits.memory_mb, "MiB")}
    value, limit, unit = bound.get(result.status, (result.returncode, 0, "exit status"))
    if result.os_error is not None:
        return _with_output(rejected(candidate, storage_failed(f"worker failed: {result.os_error[:200]}")), result)
    lines = [line for line in result.output.strip().splitlines() if not line.startswith(_IMPORT_OUTPUT)]
    tail = lines[-1:] or ["no output"]
    diagnostic = finding(
        LOST_CODES.get(result.status, "asset/worker-crashed"),
        f"worker {result.status.replace('_', ' ')}: {tail[0][:200]}",
        value=None if value is None else round(value, 1),
        bound=limit,
        unit=unit,
    )
    return _with_output(rejected(candidate, diagnostic), result)


def _with_output(item: ReportItem, result: CellResult) -> ReportItem:
    return item.model_copy(update={"seconds": {"cell": round(result.seconds, 3)}, "traceback": result.output[-2000:]})


def rejected(candidate: SourceAsset, diagnostic: Diagnostic) -> ReportItem:
    """The item of a source that one finding rejects."""
    return ReportItem(
        source=candidate.given, outcome=ItemOutcome.REJECTED, codes=(diagnostic.code,), diagnostics=(diagnostic,)
    )


def default_jobs() -> int:
    """Worker processes when the user does not say: one per core, leaving none idle."""
    return max(1, len(os.sched_getaffinity(0)))
