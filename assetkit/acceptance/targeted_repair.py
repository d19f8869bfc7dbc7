"""Repairs a draft that fails acceptance: one bounded edit for a closed set of failures, then the stages run again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from assetkit.stage import Draft
from assetkit.stage_log import Entry, StageLog
from assetkit.steps import Retry
from schemas.outcome import Repair

# Findings that another collider may cure.
COLLIDER_FAILURES = frozenset(
    {"asset/render-collision-misaligned", "asset/gate-collider-displaced", "asset/unstable-settling"}
)
Rerun = Callable[[Draft, StageLog, str], Draft | None]


def repair_until_accepted(draft: Draft, log: StageLog, retry: Retry, rerun: Rerun) -> tuple[Draft, StageLog]:
    """The draft that acceptance passes after the edits that `retry` allows, or the first one, marked for review.

    `rerun(draft, journal, stage)` runs `stage` and all after it, writing to `journal`.
    """
    first, attempt, notes = (draft, log), draft, log
    original = draft.physics.section.collision_method if draft.physics else ""
    before = _figures(draft)
    for _ in range(retry.at_most):
        code = failure(notes, retry)
        if code is None or attempt.physics is None:
            break
        failed = attempt.physics.section.collision_method
        attempt = replace(attempt, excluded_colliders=(*attempt.excluded_colliders, failed))
        notes = log.copy()
        again = rerun(attempt, notes, retry.first_stage)
        if again is None or again.physics is None:
            break
        attempt = again
        if failure(notes, retry) is None and not notes.rejected and again.acceptance is not None:
            after = _figures(again)
            chosen = again.physics.section.collision_method
            repair = Repair(
                name=f"collider_{chosen}",
                code=code,
                stage=retry.first_stage,
                before={"collider": original, **{k: v for k, v in before.items() if k in after}},
                after={"collider": chosen, **{k: v for k, v in after.items() if k in before}},
            )
            notes.entries["repair"] = Entry(repairs=(repair,))
            return again, notes
    if failure(log, retry) is not None:
        log.entries["repair"] = Entry(review=True)
    return first


def failure(log: StageLog, retry: Retry) -> str | None:
    """The first finding that a repair exists for."""
    return next((d.code for d in log.diagnostics if d.code in retry.failures), None)


def _figures(draft: Draft) -> dict[str, float | int | str]:
    return {c.name: c.value for c in draft.acceptance.section.checks} if draft.acceptance else {}
