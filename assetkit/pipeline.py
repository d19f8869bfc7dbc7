"""The asset pipeline: one source file through intake and all stages, into published packages and one report item."""

from __future__ import annotations

import errno
import time
import traceback
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from assetkit.acceptance.repairs import REPAIRS
from assetkit.acceptance.targeted_repair import repair_until_accepted
from assetkit.annotate.multimodal import UNREACHABLE
from assetkit.batch.decisions import decision_findings
from assetkit.batch.human_acceptance import apply_human_acceptance
from assetkit.geometry.reference_frame import revise_by_front, revise_by_semantics
from assetkit.options import Options
from assetkit.package import release
from assetkit.sources.discover import SourceAsset
from assetkit.stage import Draft, Intake, IntakeResult, Stage, StageResult, Tools
from assetkit.stage_log import Entry, StageLog
from assetkit.stages.acceptance import AcceptPackage
from assetkit.stages.appearance import NormalizeAppearance
from assetkit.stages.canonicalize import Canonicalize
from assetkit.stages.intake import ReadSource
from assetkit.stages.interaction import ProposeParts
from assetkit.stages.physics import AuthorPhysics
from assetkit.stages.previews import RenderPreviews
from assetkit.stages.recovery import RecoverAppearance
from assetkit.stages.retopology import Retopologize
from assetkit.stages.semantics import DescribeObject
from assetkit.steps import Pipeline, Refinement, Retry, Step
from assetkit.storage import finding_from_exception, storage_failed
from jobs.cache import Cache, content_key, write_atomically
from jobs.versions import library_versions, versions_key
from schemas.asset import RepeatedPass
from schemas.diagnostics import Diagnostic, finding
from schemas.files import array_files
from schemas.outcome import EndpointUse, ItemOutcome, Outcome, Repair
from schemas.report import ReportItem
from sim.port import Simulator

INTAKE = ReadSource()
# Intake turns one file into objects; then every object passes these, in this order; release follows. What loops, how
# often at most and through which stages stands here alone: the stages themselves know no order.
STAGES = Pipeline(
    (
        Step(Retopologize()),
        Step(Canonicalize()),
        Step(NormalizeAppearance()),
        Step(DescribeObject(), refines=Refinement(("canonicalize",), revise_by_semantics, at_most=1)),
        Step(ProposeParts(), refines=Refinement(("canonicalize", "interaction"), revise_by_front, at_most=1)),
        Step(RecoverAppearance()),
        Step(AuthorPhysics()),
        Step(RenderPreviews()),
        Step(AcceptPackage(), retries=Retry(REPAIRS, at_most=3)),
    )
)


STAGE_RESULTS = "stages"  # below the store: a folder per stage, of values and notes
NOTE_SUFFIX = ".note.npz"
_MARK = "in-work"  # A file in the work folder; when it is missing, other files may be missing too.
_LOST = "the work folder was removed while the asset was made"


@dataclass(frozen=True)
class StoredNotes:
    """Findings, repairs and review flag of a stage, stored beside its value; `versions` as in `StoredResult`."""

    diagnostics: tuple[Diagnostic, ...]
    repairs: tuple[Repair, ...]
    review: bool
    versions: str = ""


def process_source(
    candidate: SourceAsset, *, options: Options, simulator: Simulator, out: Path, work_dir: Path, fresh: bool = False
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
        taken = INTAKE.run(candidate, options.of_object(0))
    except MemoryError:
        raise  # The cell reports it as what it is.
    except Exception as error:  # A reader's bug; everything a file can do wrong comes back as findings.
        taken = IntakeResult((), (finding_from_exception(error, candidate.file, (work_dir, out)),), (), review=False)
        trace = traceback.format_exc()
    entry = Entry(taken.diagnostics, taken.repairs, taken.review, time.monotonic() - started)
    logs: list[StageLog] = []
    packages: list[str] = []
    for number, item in enumerate(taken.objects, start=1):
        asset_id = f"{candidate.asset_id}-{number:02d}" if len(taken.objects) > 1 else candidate.asset_id
        log = StageLog({INTAKE.name: replace(entry, seconds=entry.seconds if number == 1 else 0.0)})
        if decision_notes := decision_findings(options, number):
            log.entries["decisions"] = Entry(decision_notes)
        tools = Tools(simulator, work_dir / asset_id, options.of_object(number), mark=mark)
        try:
            lost = any(d.code == UNREACHABLE for j in logs for d in j.diagnostics)
            tools = replace(tools, endpoint_lost=lost)
            log, published = _process_object(
                Draft(asset_id, candidate.file.path.name, item),
                tools,
                log,
                out,
                work_dir if fresh else out / ".cache",
            )
            packages += published
        except MemoryError:
            raise
        except Exception as error:  # A bug must not take the batch down; it is reported as what it is.
            known = finding_from_exception(error, candidate.file, (work_dir, out))
            unexpected = known if mark.is_file() else storage_failed(_LOST)
            log.entries["bug"] = Entry((unexpected,))
            trace = traceback.format_exc()
        logs.append(log)
    return _report(candidate, logs or [StageLog({INTAKE.name: entry})], packages, trace)


def _require_intact(tools: Tools) -> None:
    """Raises FileNotFoundError when files have been removed from the work folder: no result made there counts then."""
    if tools.mark is not None and not tools.mark.is_file():
        raise FileNotFoundError(errno.ENOENT, _LOST, str(tools.mark))


def _process_object(draft: Draft, tools: Tools, log: StageLog, out: Path, store: Path) -> tuple[StageLog, list[str]]:
    """The final log and the published package folders of one object (none or one)."""
    cache = Cache(store / STAGE_RESULTS)
    tools = replace(tools, answers=Cache(store))
    key = content_key(INTAKE.name, INTAKE.version, _identity(draft.intake), draft.asset_id)
    log.entries[INTAKE.name] = replace(log.entries[INTAKE.name], version=INTAKE.version, key=key)

    def rerun(attempt: Draft, notes: StageLog, first_stage: str) -> Draft | None:
        previous = STAGES.before(first_stage)
        before = notes.entries[previous.name].key if previous and previous.name in notes.entries else key
        return run_stages(attempt, tools, notes, cache, before, STAGES.from_stage(first_stage))

    finished = run_stages(draft, tools, log, cache, key, STAGES)
    for retry in (step.retries for step in STAGES.steps if step.retries is not None):
        if finished is not None:
            finished, log = repair_until_accepted(finished, log, retry.rules, retry.at_most, rerun)
    if finished is not None:
        log = apply_human_acceptance(log, tools.options)
    if finished is None or log.rejected:
        return log, []
    package = release.finish(finished, log, tools)
    _require_intact(tools)
    occupied = release.publish(package.folder, out / draft.asset_id)
    if occupied is not None:
        log.entries["release"] = Entry((occupied,))
        return log, []
    return log, [draft.asset_id]


def run_stages(draft: Draft, tools: Tools, log: StageLog, cache: Cache, key: str, pipeline: Pipeline) -> Draft | None:
    """The draft as far as the stages took it, None when one gave no value; `key` chains over the stages.

    Where a step refines the frame, the stages that it names run again in the new one; its log entry has the reasons.
    """
    for step in pipeline.steps[pipeline.start :]:
        if not step.stage.wanted(tools.options):
            continue
        pending: tuple[Stage, ...] = (step.stage,)
        while pending:
            for stage in pending:
                outcome = _logged_run(stage, draft, tools, log, cache, key)
                if outcome.value is None:
                    return None
                draft, key = draft.with_result(outcome.value), log.entries[stage.name].key
                if outcome.failed:
                    return draft
            draft, pending = _refined(step, draft, log, pipeline)
        key = log.entries[step.name].key
    return draft


def _refined(step: Step, draft: Draft, log: StageLog, pipeline: Pipeline) -> tuple[Draft, tuple[Stage, ...]]:
    """The draft in the frame that a step has decided, and the stages to run again in it; none when nothing changes.

    A draft that would be revised more often than its step allows keeps its frame and goes to a person.
    """
    loop = step.refines
    revision = loop.revise(draft) if loop is not None else None
    if loop is None or revision is None:
        return draft, ()
    entry = log.entries[step.name]
    if len(entry.repeats) >= loop.at_most:
        headline = f"{step.name} would turn or scale the object again after each look: {', '.join(revision.reasons)}"
        unsettled = finding(
            "asset/frame-unsettled", headline, value=len(entry.repeats) + 1, bound=loop.at_most, unit="repeated passes"
        )
        log.entries[step.name] = replace(entry, diagnostics=(*entry.diagnostics, unsettled), review=True)
        return draft, ()
    reasons = {reason: dict(values) for reason, values in revision.reasons.items()}
    repeated = RepeatedPass(stages=loop.repeats, reasons=reasons)
    log.entries[step.name] = replace(entry, repeats=(*entry.repeats, repeated))
    return replace(draft, frame=revision.frame), pipeline.stages(*loop.repeats)


def _logged_run(
    stage: Stage, draft: Draft, tools: Tools, log: StageLog, cache: Cache, key: str
) -> Outcome[StageResult]:
    """The outcome of one stage, made or from the store; its entry in the log replaces that of an earlier pass."""
    key = content_key(key, stage.name, stage.version, tools.options.model_dump(), asdict(draft.edits))
    key = content_key(key, library_versions())
    started = time.monotonic()
    outcome, cached = _load_or_run(stage, draft.limited_to(stage.reads), tools, cache, key)
    before = log.entries.get(stage.name, Entry())  # Of a stage that runs again: time and causes of both count.
    if outcome.outside is not None:
        key = content_key(key, outcome.outside.digest)
    log.entries[stage.name] = Entry(
        outcome.diagnostics,
        outcome.repairs,
        outcome.review,
        time.monotonic() - started + before.seconds,
        cached,
        stage.version,
        key,
        outcome.outside.use if outcome.outside else None,
        before.repeats,
    )
    return outcome


def _load_or_run(stage: Stage, draft: Draft, tools: Tools, cache: Cache, key: str) -> tuple[Outcome[StageResult], bool]:
    """The stage's outcome and whether it came from the store. A damaged entry is made again."""
    value_file, note_file = (cache.path(stage.name, key, suffix) for suffix in (".npz", NOTE_SUFFIX))
    if value_file.exists() and note_file.exists():
        try:
            note = array_files.load(StoredNotes, note_file)
            value = array_files.load(stage.result, value_file)
        except (OSError, ValueError, KeyError):
            value_file.unlink(missing_ok=True)
        else:
            return Outcome(value, note.diagnostics, note.repairs, note.review), True
    findings = stage.accepts(draft)
    outcome: Outcome[StageResult] = stage.run(draft, tools) if not findings else Outcome(None, tuple(findings))
    _require_intact(tools)
    if outcome.value is not None and outcome.outside is None:
        array_files.save(outcome.value, stage.result, value_file)
        array_files.save(
            StoredNotes(outcome.diagnostics, outcome.repairs, outcome.review, versions_key()), StoredNotes, note_file
        )
    return outcome, False


def _identity(item: Intake) -> list[object]:
    """The inputs of the object for the cache key: files, format, folders, hints and the size of each mesh."""
    shapes = [(m.name, len(m.points), len(m.triangles), m.points.min(), m.points.max()) for m in item.model.meshes]
    return [[f.model_dump() for f in item.files], item.format, item.folders, item.model.hints, shapes]


def _report(candidate: SourceAsset, logs: list[StageLog], packages: list[str], trace: str) -> ReportItem:
    """One report row over all objects of a source; its outcome is the worst of theirs."""
    order = (ItemOutcome.REJECTED, ItemOutcome.REVIEW, ItemOutcome.REPAIRED, ItemOutcome.ACCEPTED)
    unique = dict.fromkeys(d.model_dump_json() for j in logs for d in j.diagnostics)
    findings = tuple(Diagnostic.model_validate_json(d) for d in unique)
    repairs = dict.fromkeys(r.model_dump_json() for j in logs for r in j.repairs)
    seconds: dict[str, float] = {}
    for name, entry in (pair for j in logs for pair in j.entries.items()):
        seconds[name] = round(seconds.get(name, 0.0) + entry.seconds, 3)
    uses = [e.endpoint for j in logs for e in j.entries.values() if e.endpoint is not None]
    return ReportItem(
        source=candidate.given,
        outcome=min((j.outcome for j in logs), key=order.index),
        codes=tuple(dict.fromkeys(d.code for d in findings)),
        packages=tuple(packages),
        repairs=tuple(Repair.model_validate_json(r) for r in repairs),
        diagnostics=findings,
        seconds=seconds,
        cached=tuple(sorted({name for j in logs for name, e in j.entries.items() if e.cached})),
        traceback=trace,
        endpoint=sum(uses, EndpointUse()) if uses else None,
    )
