"""Acceptance failures: one bounded edit at a time, the first draft kept when nothing helps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest

from assetkit.acceptance.repairs import (
    COLLIDER_FAILURES,
    MORE_GRASPS,
    REPAIRS,
    RepairRule,
    another_collider,
    finer_collider,
    friction_within_bounds,
    more_grasps,
)
from assetkit.acceptance.suites.table import SUITES
from assetkit.acceptance.targeted_repair import repair_until_accepted
from assetkit.affordances.grasps import propose_grasps
from assetkit.colliders.choose import CUTS_FINE, METHODS
from assetkit.pipeline import STAGES
from assetkit.stage import Draft, Edits
from assetkit.stage_log import Entry, StageLog
from cli.codes import all_codes
from schemas.acceptance import Check, SuiteSection
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence, declared, inferred
from schemas.outcome import ItemOutcome
from schemas.physics import Contact
from tests.assetkit.affordances.test_grasps import THINGS

UNSTABLE = finding("asset/unstable-settling", "keeps moving")
LOST = finding("asset/handling-lost", "falls")
WITHDRAWN = finding("asset/role-withdrawn", "'manipulated' is not borne out", because=(LOST,))
COLLIDERS = (RepairRule("another_collider", COLLIDER_FAILURES, "physics", another_collider),)
GRASPS = propose_grasps(THINGS["box"], ()).grasps[:5]
SLICK = Contact(static_friction=0.3, dynamic_friction=0.2, restitution=0.0)
ROUGH = Contact(static_friction=1.2, dynamic_friction=0.8, restitution=0.0)


def draft(
    collider: str = "box", *, friction: Evidence[Contact] | None = None, trials: Sequence[str] = (), slip: float = 0.5
) -> Draft:
    """A draft as repair sees it: which collider, which friction, which grasps, which figures."""
    contact = friction or inferred(SLICK, "plastic", 0.6, bounds=(SLICK, ROUGH))
    section = SimpleNamespace(collision_method=collider, contacts=(contact,))
    check = Check(name="settle_drift", value=slip, bound=0.1, unit="of diagonal", passed=collider == "hull")
    suite = SuiteSection(name="manipulated", outcome="failed", checks=(check,))
    grasps = [
        inferred(grasp.model_copy(update={"trial": trial}), "tried", 0.5)
        for grasp, trial in zip(GRASPS, trials, strict=False)
    ]
    acceptance = SimpleNamespace(section=SimpleNamespace(checks=(check,), suites=(suite,)), affordances=grasps)
    physics = SimpleNamespace(section=section, links=(), surfaces=())
    empty = Draft("x", "x.obj", cast(Any, None))
    return replace(empty, physics=cast(Any, physics), acceptance=cast(Any, acceptance))


class Rerun:
    """Gives the colliders in turn; only `good` settles."""

    def __init__(self, *colliders: str, good: str = "") -> None:
        self.colliders = list(colliders)
        self.good = good
        self.edits: list[Edits] = []

    def __call__(self, attempt: Draft, notes: StageLog, stage: str) -> Draft:
        assert stage == "physics"
        self.edits.append(attempt.edits)
        collider = self.colliders.pop(0)
        notes.entries["acceptance"] = Entry(() if collider == self.good else (UNSTABLE,))
        return replace(draft(collider), edits=attempt.edits)


def failing(*findings: Diagnostic) -> StageLog:
    return StageLog({"acceptance": Entry(findings or (UNSTABLE,))})


def test_nothing_to_do_changes_nothing():
    log = StageLog({"acceptance": Entry()})
    first = draft()
    assert repair_until_accepted(first, log, COLLIDERS, 2, Rerun()) == (first, log)
    assert log.outcome is ItemOutcome.ACCEPTED


def test_a_repair_that_helps_is_recorded_with_figures_and_its_findings_replace_the_old():
    rerun = Rerun("coacd", "hull", good="hull")
    repaired, log = repair_until_accepted(draft("box"), failing(), COLLIDERS, 2, rerun)
    assert [edits.excluded_colliders for edits in rerun.edits] == [("box",), ("box", "coacd")]
    assert repaired.physics is not None
    assert repaired.physics.section.collision_method == "hull"
    assert log.outcome is ItemOutcome.REPAIRED
    assert log.diagnostics == ()
    assert [(r.name, r.code, r.stage) for r in log.repairs] == [
        ("another_collider", "asset/unstable-settling", "physics")
    ]
    before, after = log.repairs[0].before, log.repairs[0].after
    assert (before["collider"], after["collider"]) == ("box", "hull")
    assert before["settle_drift"] == before["manipulated/settle_drift"] == 0.5


def test_when_nothing_helps_the_first_draft_goes_to_review():
    first = draft()
    kept, log = repair_until_accepted(first, failing(), COLLIDERS, 2, Rerun("coacd", "hull"))
    assert kept is first
    assert log.outcome is ItemOutcome.REVIEW
    assert log.repairs == ()
    assert [d.code for d in log.diagnostics] == ["asset/unstable-settling"]


def test_rounds_are_bounded():
    rerun = Rerun(*"abcdef")
    repair_until_accepted(draft(), failing(), COLLIDERS, 2, rerun)
    assert len(rerun.edits) == 2


def test_a_collider_that_comes_again_ends_the_attempts():
    rerun = Rerun("box", "box", "box")
    repair_until_accepted(draft("box"), failing(), COLLIDERS, 5, rerun)
    assert [edits.excluded_colliders for edits in rerun.edits] == [("box",)]


def test_a_role_that_was_withdrawn_is_tried_again_and_alone_needs_no_person():
    tried: list[tuple[str, Edits]] = []

    def rerun(attempt: Draft, notes: StageLog, stage: str) -> Draft:
        tried.append((stage, attempt.edits))
        return replace(draft(trials=["not_held"] * 5), edits=attempt.edits)

    first = draft(trials=["not_held", "not_held", "not_held", "untried", "untried"])
    kept, log = repair_until_accepted(first, failing(WITHDRAWN), REPAIRS, 3, rerun)
    assert [stage for stage, _ in tried] == ["acceptance", "physics"]
    assert tried[0][1].tried_grasps == MORE_GRASPS
    assert tried[1][1].tried_grasps == MORE_GRASPS  # Edits accumulate.
    assert tried[1][1].friction_gain == pytest.approx(2.0)  # The root of 0.8 over 0.2.
    assert kept is first
    assert log.outcome is ItemOutcome.ACCEPTED
    assert [d.code for d in log.diagnostics] == ["asset/role-withdrawn"]


def test_friction_stays_as_declared_and_within_what_is_known():
    assert friction_within_bounds(draft(friction=declared(SLICK, "file"))) is None
    assert friction_within_bounds(draft(friction=inferred(SLICK, "plastic", 0.6))) is None
    assert friction_within_bounds(draft(friction=inferred(ROUGH, "rubber", 0.6, bounds=(SLICK, ROUGH)))) is None
    assert friction_within_bounds(replace(draft(), edits=Edits(friction_gain=2.0))) is None


@pytest.mark.parametrize(
    ("trials", "edits", "helps"),
    [
        (["not_held"] * 3 + ["untried"] * 2, Edits(), True),
        (["not_held"] * 5, Edits(), False),
        (["untried"] * 3, Edits(), False),
        (["not_held"] * 3 + ["untried"] * 2, Edits(tried_grasps=MORE_GRASPS), False),
    ],
)
def test_more_grasps_are_tried_where_there_are_more(trials: list[str], edits: Edits, helps: bool) -> None:
    assert (more_grasps(replace(draft(trials=trials), edits=edits)) is not None) == helps


def vessel(collider: str, edits: Edits = Edits(), kind: str = "volume") -> Draft:
    """A draft whose visible surface has an anchor of that kind."""
    interaction = SimpleNamespace(anchors=(SimpleNamespace(kind=kind),))
    return replace(draft(collider), edits=edits, interaction=cast(Any, interaction))


def test_where_things_fall_through_gaps_only_the_finest_decomposition_is_left() -> None:
    edits = finer_collider(vessel("cuts"))
    assert edits is not None
    assert {*METHODS} - {*edits.excluded_colliders} == {CUTS_FINE}
    assert finer_collider(vessel(CUTS_FINE)) is None
    assert finer_collider(vessel("cuts", Edits(excluded_colliders=(CUTS_FINE,)))) is None
    assert finer_collider(vessel("cuts", kind="surface")) is None
    assert finer_collider(draft("cuts")) is None


def test_every_failure_of_the_table_is_a_code_and_its_stage_exists():
    names = {step.name for step in STAGES.steps}
    for rule in REPAIRS:
        assert rule.failures <= set(all_codes())
        assert rule.first_stage in names
    of_suites = {code for suite in SUITES for code in suite.codes}
    edit: Callable[[Draft], Edits | None] = more_grasps
    assert next(rule for rule in REPAIRS if rule.edit is edit).failures <= of_suites
