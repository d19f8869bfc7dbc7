"""What a failed suite means for roles: promises lead to review, guesses are withdrawn, the rest stays."""

from __future__ import annotations

from assetkit.acceptance.suites.common import CommonSuite
from assetkit.acceptance.suites.fixture import FixtureSuite
from assetkit.acceptance.suites.manipulated import ManipulatedSuite
from assetkit.acceptance.suites.roles import judge_roles
from assetkit.acceptance.suites.run import SuiteResult, run_suite, suites_for
from assetkit.acceptance.suites.suite import Suite
from assetkit.acceptance.suites.table import SUITES
from schemas.acceptance import SuiteSection
from schemas.codes import CODES
from schemas.diagnostics import finding
from schemas.evidence import declared, inferred
from sim.fake import FakeSimulator
from tests.assetkit.acceptance.suites.subjects import subject
from tests.assetkit.affordances.test_grasps import THINGS, body_of, box

GUESS = inferred("manipulated", "usual for a mug", 0.8)
PROMISE = declared("manipulated", "--role")
OTHER = inferred("receptacle", "usual for a mug", 0.8)


def result(suite: Suite, outcome: str) -> SuiteResult:
    findings = (finding(suite.codes[0], "it fails"),) if outcome == "failed" else ()
    return SuiteResult(suite, SuiteSection.model_validate({"name": suite.name, "outcome": outcome}), findings)


def test_a_guess_that_fails_is_withdrawn_with_the_reason() -> None:
    verdict = judge_roles((GUESS, OTHER), (result(ManipulatedSuite(), "failed"),))
    assert verdict.withdrawn == ("manipulated",)
    assert [f.code for f in verdict.findings] == ["asset/role-withdrawn"]
    assert [f.code for f in verdict.findings[0].because] == ["asset/handling-no-grasp"]
    assert not verdict.review


def test_roles_that_one_suite_fails_are_withdrawn_by_one_finding() -> None:
    guesses = tuple(inferred(role, "usual", 0.8) for role in ("fixture", "openable", "receptacle"))
    verdict = judge_roles(guesses, (result(FixtureSuite(), "failed"),))
    assert verdict.withdrawn == ("fixture", "openable")
    assert [f.headline.split(" not borne")[0] for f in verdict.findings] == ["the roles 'fixture' and 'openable' are"]


def test_a_promise_that_fails_stays_and_a_person_looks() -> None:
    verdict = judge_roles((PROMISE,), (result(ManipulatedSuite(), "failed"),))
    assert verdict.withdrawn == ()
    assert [f.code for f in verdict.findings] == ["asset/handling-no-grasp"]
    assert verdict.review


def test_what_every_object_does_is_reported() -> None:
    verdict = judge_roles((OTHER,), (result(CommonSuite(), "failed"),))
    assert (verdict.withdrawn, verdict.review) == ((), False)
    assert [f.code for f in verdict.findings] == ["asset/slope-astray"]


def test_suites_that_pass_or_cannot_run_change_nothing() -> None:
    for outcome in ("passed", "not_run"):
        verdict = judge_roles((GUESS,), (result(ManipulatedSuite(), outcome), result(CommonSuite(), outcome)))
        assert (verdict.withdrawn, verdict.findings, verdict.review) == ((), (), False)


def test_suites_run_for_the_roles_that_name_them_and_for_all() -> None:
    body = THINGS["box"]
    assert {s.name for s in suites_for(subject(body, "manipulated"), SUITES)} == {"common", "manipulated"}
    assert {s.name for s in suites_for(subject(body), SUITES)} == {"common"}


def test_names_of_suites_differ_and_their_codes_are_in_the_table() -> None:
    assert len({suite.name for suite in SUITES}) == len(SUITES)
    codes = [code for suite in SUITES for code in suite.codes]
    assert len(set(codes)) == len(codes)
    assert set(codes) <= set(CODES)


def test_a_section_has_the_outcome_and_varies_only_what_passed() -> None:
    suite = ManipulatedSuite()
    good = run_suite(suite, subject(THINGS["box"], "manipulated"), FakeSimulator())
    assert good.section.outcome == "passed"
    assert len(good.section.repeats) == 2
    wide = body_of(box(0.5, 0.5, 0.5), centre_m=(0.0, 0.0, 0.25))
    bad = run_suite(suite, subject(wide, "manipulated"), FakeSimulator())
    assert bad.section.outcome == "failed"
    assert bad.section.repeats == ()
    tiny = run_suite(suite, subject(body_of(box(0.005, 0.005, 0.005)), "manipulated"), FakeSimulator())
    assert tiny.section.outcome == "not_run"
    assert tiny.section.reason
