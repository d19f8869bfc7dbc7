"""The whole order of the pipeline, in one place: one source file in, packages and a report item out."""

from __future__ import annotations

import errno
import time
import traceback
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from assetkit.acceptance.targeted_repair import repair_until_accepted
from assetkit.annotate.multimodal import UNREACHABLE
from assetkit.batch.decisions import decision_findings
from assetkit.batch.human_acceptance import accepted_by_person
from assetkit.geometry.reference_frame import frame_to_front
from assetkit.options import Options
from assetkit.package import release
from assetkit.sources.discover import Candidate
from assetkit.stage import Draft, Intake, Stage, Tools
from assetkit.stage_log import Entry, Journal
from assetkit.stages import intake
from assetkit.stages.acceptance import AcceptPackage
from assetkit.stages.appearance import NormalizeAppearance
from assetkit.stages.canonicalize import Canonicalize
from assetkit.stages.interaction import ProposeParts
from assetkit.stages.physics import AuthorPhysics
from assetkit.stages.previews import RenderPreviews
from assetkit.stages.semantics import DescribeObject
from assetkit.storage import finding_of, storage_failed
from assetkit.versions import library_versions
from jobs.cache import Cache, content_key, write_atomically
from schemas import array_files
from schemas.diagnostics import Diagnostic
from schemas.outcome import EndpointUse, ItemOutcome, Outcome, Repair
from schemas.report import ReportItem
from sim.port import Simulator

# Intake turns one file into objects; then every object passes these, in this order; release follows.
STAGES: tuple[Stage, ...] = (
    Canonicalize(),
    NormalizeAppearance(),
    DescribeObject(),
    ProposeParts(),
    AuthorPhysics(),
    RenderPreviews(),
    AcceptPackage(),
)


_MARK = "in-work"  # A file in the work folder; when it is gone, others may be gone too.
_LOST = "the work folder was removed while the asset was made"


@dataclass(frozen=True)
class Noted:
    """What is stored beside a stage's value."""

    diagnostics: tuple[Diagnostic, ...]
    repairs: tuple[Repair, ...]
    review: bool


def process_source(
    candidate: Candidate, *, options: Options, simulator: Simulator, out: Path, work_dir: Path, fresh: bool = False
) -> ReportItem:
    """Take one source through every stage and publish its packages in `out`.

    With `fresh` stored stage results are ignored. Never raises for what the file holds, except MemoryError. Files of
    Mana's own that vanish or cannot be written become `asset/storage-failed`, and nothing made from then on is stored.
    Any other exception in a stage is a bug: it becomes `asset/internal-error` with its traceback in the report.
    """
    started = time.monotonic()
    mark = work_dir / _MARK
    write_atomically(mark, b"")
    trace = ""
    try:
        taken = intake.take_in(candidate, options.of_object(0))
    except MemoryError:
        raise  # The cell reports it as what it is.
    except Exception as error:  # A reader's bug; everything a file can do wrong comes back as findings.
        taken = intake.IntakeResult((), (finding_of(error, candidate.file, (work_dir, out)),), (), review=False)
        trace = traceback.format_exc()
    entry = Entry(taken.diagnostics, taken.repairs, taken.review, time.monotonic() - started)
    journals: list[Journal] = []
    packages: list[str] = []
    for number, item in enumerate(taken.objects, start=1):
        asset_id = f"{candidate.asset_id}-{number:02d}" if len(taken.objects) > 1 else candidate.asset_id
        journal = Journal({intake.NAME: replace(entry, seconds=entry.seconds if number == 1 else 0.0)})
        if told := decision_findings(options, number):
            journal.entries["decisions"] = Entry(told)
        tools = Tools(simulator, work_dir / asset_id, options.of_object(number), mark=mark)
        try:
            lost = any(d.code == UNREACHABLE for j in journals for d in j.diagnostics)
            tools = replace(tools, endpoint_lost=lost)
            journal, published = _process_object(
                Draft(asset_id, candidate.file.path.name, item),
                tools,
                journal,
                out,
                work_dir if fresh else out / ".cache",
            )
            packages += published
        except MemoryError:
            raise
        except Exception as error:  # A bug must not take the batch down; it is reported as what it is.
            known = finding_of(error, candidate.file, (work_dir, out))
            unexpected = known if mark.is_file() else storage_failed(_LOST)
            journal.entries["bug"] = Entry((unexpected,))
            trace = traceback.format_exc()
        journals.append(journal)
    return _report(candidate, journals or [Journal({intake.NAME: entry})], packages, trace)


def _require_intact(tools: Tools) -> None:
    """Raises FileNotFoundError when files have been removed from the work folder: no result made there counts then."""
    if tools.mark is not None and not tools.mark.is_file():
        raise FileNotFoundError(errno.ENOENT, _LOST, str(tools.mark))


def _process_object(draft: Draft, tools: Tools, journal: Journal, out: Path, store: Path) -> tuple[Journal, list[str]]:
    """The journal that stands in the end, and the published package folders of one object (none or one)."""
    cache = Cache(store / "stages")
    tools = replace(tools, answers=Cache(store))
    key = content_key(intake.NAME, intake.VERSION, _identity(draft.intake), draft.asset_id)
    journal.entries[intake.NAME] = replace(journal.entries[intake.NAME], version=intake.VERSION, key=key)

    def rerun(attempt: Draft, notes: Journal, first_stage: str) -> Draft | None:
        position = [s.name for s in STAGES].index(first_stage)
        before = notes.entries[STAGES[position - 1].name].key if position else key
        return run_stages(attempt, tools, notes, cache, before, STAGES[position:])

    finished = run_stages(draft, tools, journal, cache, key, STAGES)
    if finished is not None:
        finished, journal = repair_until_accepted(finished, journal, rerun)
        journal = accepted_by_person(journal, tools.options)
    if finished is None or journal.rejected:
        return journal, []
    folder = release.finish(finished, journal, tools.work_dir)
    _require_intact(tools)
    occupied = release.publish(folder, out / draft.asset_id)
    if occupied is not None:
        journal.entries["release"] = Entry((occupied,))
        return journal, []
    return journal, [draft.asset_id]


def run_stages(
    draft: Draft, tools: Tools, journal: Journal, cache: Cache, key: str, stages: tuple[Stage, ...]
) -> Draft | None:
    """The draft as far as `stages` took it, None when one gave no value; `key` chains over the stages."""
    for stage in stages:
        key = content_key(key, stage.name, stage.version, tools.options.model_dump(), draft.excluded_colliders)
        key = content_key(key, library_versions())
        started = time.monotonic()
        outcome, cached = _from_store_or_made(stage, draft, tools, cache, key)
        before = journal.entries.get(stage.name)  # Of a stage that runs again: both count.
        if outcome.outside is not None:
            key = content_key(key, outcome.outside.digest)
        journal.entries[stage.name] = Entry(
            outcome.diagnostics,
            outcome.repairs,
            outcome.review,
            time.monotonic() - started + (before.seconds if before else 0.0),
            cached,
            stage.version,
            key,
            outcome.outside.use if outcome.outside else None,
        )
        if outcome.value is None:
            return None
        draft = replace(draft, **{stage.name: outcome.value})
        if outcome.failed:
            break
        if draft.frame is None and draft.semantics is not None and draft.semantics.frame is not None:
            # Meaning gave another scale or pose: the geometry is observed once more, and never again.
            known = replace(draft, frame=draft.semantics.frame)
            observed = run_stages(known, tools, journal, cache, key, (Canonicalize(),))
            if observed is None:
                return None
            draft = observed
        if stage.name == ProposeParts.name and (frame := frame_to_front(draft)) is not None:
            again = (Canonicalize(), ProposeParts())
            turned = run_stages(replace(draft, frame=frame), tools, journal, cache, key, again)
            if turned is None:
                return None
            draft, key = turned, journal.entries[ProposeParts.name].key
    return draft


def _from_store_or_made(stage: Stage, draft: Draft, tools: Tools, cache: Cache, key: str) -> tuple[Outcome[Any], bool]:
    """The stage's outcome and whether it came from the store. A damaged entry is made again."""
    value_file, note_file = (cache.path(stage.name, key, suffix) for suffix in (".npz", ".note.npz"))
    if value_file.exists() and note_file.exists():
        try:
            note = array_files.load(Noted, note_file)
            value = array_files.load(stage.result, value_file)
        except (OSError, ValueError, KeyError):
            value_file.unlink(missing_ok=True)
        else:
            return Outcome(value, note.diagnostics, note.repairs, note.review), True
    findings = stage.accepts(draft)
    outcome = stage.run(draft, tools) if not findings else Outcome(None, tuple(findings))
    _require_intact(tools)
    if outcome.value is not None and outcome.outside is None:
        array_files.save(outcome.value, stage.result, value_file)
        array_files.save(Noted(outcome.diagnostics, outcome.repairs, outcome.review), Noted, note_file)
    return outcome, False


def _identity(item: Intake) -> list[Any]:
    """What the object is made from, for the store's key: files, which part of them, and what is said about them."""
    shapes = [(m.name, len(m.points), len(m.triangles), m.points.min(), m.points.max()) for m in item.model.meshes]
    return [[f.model_dump() for f in item.files], item.format, item.folders, item.model.hints, shapes]


def _report(candidate: Candidate, journals: list[Journal], packages: list[str], trace: str) -> ReportItem:
    """One report row over all objects of a source; its outcome is the worst of theirs."""
    order = (ItemOutcome.REJECTED, ItemOutcome.REVIEW, ItemOutcome.REPAIRED, ItemOutcome.ACCEPTED)
    unique = dict.fromkeys(d.model_dump_json() for j in journals for d in j.diagnostics)
    findings = tuple(Diagnostic.model_validate_json(d) for d in unique)
    repairs = dict.fromkeys(r.model_dump_json() for j in journals for r in j.repairs)
    seconds: dict[str, float] = {}
    for name, entry in (pair for j in journals for pair in j.entries.items()):
        seconds[name] = round(seconds.get(name, 0.0) + entry.seconds, 3)
    uses = [e.endpoint for j in journals for e in j.entries.values() if e.endpoint is not None]
    return ReportItem(
        source=candidate.given,
        outcome=min((j.outcome for j in journals), key=order.index),
        codes=tuple(dict.fromkeys(d.code for d in findings)),
        packages=tuple(packages),
        repairs=tuple(Repair.model_validate_json(r) for r in repairs),
        diagnostics=findings,
        seconds=seconds,
        cached=tuple(sorted({name for j in journals for name, e in j.entries.items() if e.cached})),
        traceback=trace,
        endpoint=sum(uses, EndpointUse()) if uses else None,
    )
