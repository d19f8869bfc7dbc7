"""Acceptance failures: one bounded edit at a time, the first draft kept when nothing helps."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

from assetkit.acceptance.targeted_repair import COLLIDER_FAILURES, repair_until_accepted
from assetkit.stage import Draft
from assetkit.stage_log import Entry, StageLog
from assetkit.steps import Retry
from schemas.asset import Check
from schemas.diagnostics import finding
from schemas.outcome import ItemOutcome

UNSTABLE = finding("asset/unstable-settling", "keeps moving")
RETRY = Retry("physics", COLLIDER_FAILURES, at_most=2)


def draft(collider: str) -> Draft:
    """A draft as repair sees it: which collider, which checks."""
    section = SimpleNamespace(collision_method=collider)
    check = Check(name="settle_drift", value=0.5, bound=0.1, unit="of diagonal", passed=collider == "hull")
    acceptance = SimpleNamespace(section=SimpleNamespace(checks=(check,)))
    empty = Draft("x", "x.obj", cast(Any, None))
    return replace(empty, physics=cast(Any, SimpleNamespace(section=section)), acceptance=cast(Any, acceptance))


class Rerun:
    """Gives the colliders in turn; only `good` settles."""

    def __init__(self, *colliders: str, good: str = "") -> None:
        self.colliders = list(colliders)
        self.good = good
        self.excluded: list[tuple[str, ...]] = []

    def __call__(self, attempt: Draft, notes: StageLog, stage: str) -> Draft:
        assert stage == "physics"
        self.excluded.append(attempt.excluded_colliders)
        collider = self.colliders.pop(0)
        notes.entries["acceptance"] = Entry(() if collider == self.good else (UNSTABLE,))
        return replace(draft(collider), excluded_colliders=attempt.excluded_colliders)


def failing() -> StageLog:
    return StageLog({"acceptance": Entry((UNSTABLE,))})


def test_nothing_to_do_changes_nothing():
    log = StageLog({"acceptance": Entry()})
    first = draft("box")
    assert repair_until_accepted(first, log, RETRY, Rerun()) == (first, log)
    assert log.outcome is ItemOutcome.ACCEPTED


def test_a_repair_that_helps_is_recorded_with_figures_and_its_findings_replace_the_old():
    rerun = Rerun("coacd", "hull", good="hull")
    repaired, log = repair_until_accepted(draft("box"), failing(), RETRY, rerun)
    assert rerun.excluded == [("box",), ("box", "coacd")]
    assert repaired.physics is not None
    assert repaired.physics.section.collision_method == "hull"
    assert log.outcome is ItemOutcome.REPAIRED
    assert log.diagnostics == ()
    assert [(r.name, r.code) for r in log.repairs] == [("collider_hull", "asset/unstable-settling")]
    assert log.repairs[0].before == {"collider": "box", "settle_drift": 0.5}


def test_when_nothing_helps_the_first_draft_goes_to_review():
    first = draft("box")
    kept, log = repair_until_accepted(first, failing(), RETRY, Rerun("coacd", "hull"))
    assert kept is first
    assert log.outcome is ItemOutcome.REVIEW
    assert log.repairs == ()
    assert [d.code for d in log.diagnostics] == ["asset/unstable-settling"]


def test_rounds_are_bounded():
    rerun = Rerun(*"abcdef")
    repair_until_accepted(draft("box"), failing(), RETRY, rerun)
    assert len(rerun.excluded) == RETRY.at_most
