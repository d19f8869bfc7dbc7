"""The whole order of the pipeline, in one place: one source file in, packages and a report item out."""

from __future__ import annotations

import time
import traceback
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from assetkit import release
from assetkit.discover import Candidate
from assetkit.options import Options
from assetkit.stage import Draft, Intake, Stage, Tools
from assetkit.stages import intake
from assetkit.stages.accept_package import AcceptPackage
from assetkit.stages.appearance import NormalizeAppearance
from assetkit.stages.author_physics import AuthorPhysics
from assetkit.stages.canonicalize import Canonicalize
from assetkit.stages.interaction import ProposeParts
from assetkit.stages.previews import RenderPreviews
from assetkit.stages.semantics import DescribeObject
from assetkit.versions import library_versions
from jobs.cache import Cache, content_key
from schemas import arrays
from schemas.asset import StageEntry
from schemas.diagnostics import Diagnostic, Severity, finding
from schemas.outcome import ItemOutcome, Outcome, Repair
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
# Acceptance failure -> the one stage that is run again with the failed collider left out; dependents follow.
REPAIRS: dict[str, str] = {
    "asset/render-collision-misaligned": "physics",
    "asset/unstable-settling": "physics",
}
_MAX_REPAIR_ROUNDS = 2


@dataclass
class Journal:
    """What happened to one object: findings, repairs, stage history, timings. Written by the runner only."""

    diagnostics: list[Diagnostic] = field(default_factory=list)
    repairs: list[Repair] = field(default_factory=list)
    history: list[StageEntry] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)
    cached: list[str] = field(default_factory=list)
    review: bool = False

    @property
    def rejected(self) -> bool:
        """Whether an error-severity finding ended the object."""
        return any(d.severity is Severity.ERROR for d in self.diagnostics)

    @property
    def outcome(self) -> ItemOutcome:
        """The end of the object, as far as it is known."""
        if self.rejected:
            return ItemOutcome.REJECTED
        if self.review:
            return ItemOutcome.REVIEW
        return ItemOutcome.REPAIRED if self.repairs else ItemOutcome.ACCEPTED


@dataclass(frozen=True)
class CachedStage:
    """A stage's outcome as stored; `value` is saved beside it with the stage's own type."""

    diagnostics: tuple[Diagnostic, ...]
    repairs: tuple[Repair, ...]
    review: bool


def process_source(
    candidate: Candidate, *, options: Options, simulator: Simulator, out: Path, work_dir: Path
) -> ReportItem:
    """Take one source through every stage and publish its packages in `out`.

    Never raises for what the file holds. An exception in a stage is a bug: it becomes `asset/internal-error` with its
    traceback in the report.
    """
    started = time.monotonic()
    taken = intake.take_in(candidate, options)
    journals = [Journal(list(taken.diagnostics), list(taken.repairs), review=taken.review)]
    journals[0].seconds[intake.NAME] = time.monotonic() - started
    packages: list[str] = []
    trace = ""
    try:
        for number, item in enumerate(taken.objects, start=1):
            several = len(taken.objects) > 1
            asset_id = f"{candidate.asset_id}_{number:02d}" if several else candidate.asset_id
            journal = journals[0] if number == 1 else Journal(review=taken.review)
            if number > 1:
                journals.append(journal)
            tools = Tools(simulator, work_dir / asset_id, options)
            draft = Draft(asset_id, candidate.file.path.name, item)
            packages += _process_object(draft, tools, journal, out)
    except Exception as error:  # A bug in one stage must not take the batch down; it is reported as what it is.
        journals[-1].diagnostics.append(finding("asset/internal-error", f"{type(error).__name__}: {error}"))
        trace = traceback.format_exc()
    return _report(candidate, journals, packages, trace)


def _process_object(draft: Draft, tools: Tools, journal: Journal, out: Path) -> list[str]:
    """The published package folders of one object (none or one)."""
    cache = Cache(out / ".cache" / "stages")
    key = content_key(intake.NAME, intake.VERSION, _identity(draft.intake), draft.asset_id)
    journal.history.append(StageEntry(name=intake.NAME, version=intake.VERSION, key=key[:16]))
    finished = run_stages(draft, tools, journal, cache, key, STAGES)
    for _ in range(_MAX_REPAIR_ROUNDS):
        code = next((d.code for d in journal.diagnostics if d.code in REPAIRS), None)
        if code is None or finished is None or finished.physics is None:
            break
        finished = _repair(code, finished, tools, journal, cache, key)
    if finished is None or journal.rejected:
        return []
    journal.review = journal.review or any(d.code in REPAIRS for d in journal.diagnostics)
    folder = release.finish(finished, journal, tools.work_dir)
    release.publish(folder, out / draft.asset_id)
    return [draft.asset_id]


def run_stages(
    draft: Draft, tools: Tools, journal: Journal, cache: Cache, key: str, stages: tuple[Stage, ...]
) -> Draft | None:
    """The draft as far as `stages` took it, None when one gave no value; `key` chains over the stages."""
    for stage in stages:
        key = content_key(key, stage.name, stage.version, tools.options.model_dump(), draft.excluded_colliders)
        key = content_key(key, library_versions())
        started = time.monotonic()
        outcome = _cached(stage, draft, tools, cache, key, journal)
        journal.seconds[stage.name] = journal.seconds.get(stage.name, 0.0) + time.monotonic() - started
        journal.diagnostics += outcome.diagnostics
        journal.repairs += outcome.repairs
        journal.review = journal.review or outcome.review
        journal.history.append(StageEntry(name=stage.name, version=stage.version, key=key[:16]))
        if outcome.value is None:
            return None
        draft = replace(draft, **{stage.name: outcome.value})
        if outcome.failed:
            break
    return draft


def _cached(stage: Stage, draft: Draft, tools: Tools, cache: Cache, key: str, journal: Journal) -> Outcome[Any]:
    """The stage's outcome from the store, or made now and stored. A damaged entry is made again."""
    value_file, note_file = (cache.path(stage.name, key, suffix) for suffix in (".npz", ".json.npz"))
    if value_file.exists() and note_file.exists():
        try:
            note = arrays.load(CachedStage, note_file)
            value = arrays.load(stage.result, value_file)
        except (OSError, ValueError, KeyError):
            value_file.unlink(missing_ok=True)
        else:
            journal.cached.append(stage.name)
            return Outcome(value, note.diagnostics, note.repairs, note.review)
    findings = stage.accepts(draft)
    outcome = stage.run(draft, tools) if not findings else Outcome(None, tuple(findings))
    if outcome.value is not None:
        arrays.save(outcome.value, stage.result, value_file)
        arrays.save(CachedStage(outcome.diagnostics, outcome.repairs, outcome.review), CachedStage, note_file)
    return outcome


def _repair(code: str, draft: Draft, tools: Tools, journal: Journal, cache: Cache, key: str) -> Draft | None:
    """One round of targeted repair: leave out the collider that failed, run its stage and the dependents again."""
    failed = draft.physics.section.collision_method if draft.physics else ""
    before = {c.name: c.value for c in draft.acceptance.section.checks} if draft.acceptance else {}
    again = tuple(s for s in STAGES[[s.name for s in STAGES].index(REPAIRS[code]) :])
    retry = Journal()
    repaired = run_stages(
        replace(draft, excluded_colliders=(*draft.excluded_colliders, failed)), tools, retry, cache, key, again
    )
    for name, spent in retry.seconds.items():
        journal.seconds[name] = journal.seconds.get(name, 0.0) + spent
    journal.history += retry.history
    journal.diagnostics = [d for d in journal.diagnostics if d.code not in REPAIRS] + retry.diagnostics
    if repaired is not None and repaired.acceptance is not None and repaired.physics is not None:
        after = {c.name: c.value for c in repaired.acceptance.section.checks}
        journal.repairs.append(
            Repair(
                name=f"collider_{repaired.physics.section.collision_method}",
                code=code,
                stage=REPAIRS[code],
                before={"collider": failed, **before},
                after={"collider": repaired.physics.section.collision_method, **after},
            )
        )
    return repaired


def _identity(item: Intake) -> list[Any]:
    """What the object is made from, for the cache key: files and which part of them."""
    shapes = [(m.name, len(m.points), len(m.triangles), m.points.min(), m.points.max()) for m in item.model.meshes]
    return [[f.model_dump() for f in item.files], item.format, shapes]


def _report(candidate: Candidate, journals: list[Journal], packages: list[str], trace: str) -> ReportItem:
    """One report row over all objects of a source; its outcome is the worst of theirs."""
    order = (ItemOutcome.REJECTED, ItemOutcome.REVIEW, ItemOutcome.REPAIRED, ItemOutcome.ACCEPTED)
    outcome = min((j.outcome for j in journals), key=order.index)
    diagnostics = tuple(dict.fromkeys(d.model_dump_json() for j in journals for d in j.diagnostics))
    findings = tuple(Diagnostic.model_validate_json(d) for d in diagnostics)
    seconds: dict[str, float] = {}
    for journal in journals:
        for name, spent in journal.seconds.items():
            seconds[name] = round(seconds.get(name, 0.0) + spent, 3)
    return ReportItem(
        source=candidate.given,
        outcome=outcome,
        codes=tuple(dict.fromkeys(d.code for d in findings)),
        packages=tuple(packages),
        repairs=tuple(r for j in journals for r in j.repairs),
        diagnostics=findings,
        seconds=seconds,
        cached=tuple(sorted({c for j in journals for c in j.cached})),
        traceback=trace,
    )
