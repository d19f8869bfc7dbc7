"""The best grasps are tried; the record says what became of each, and USD lists no refuted one."""

from __future__ import annotations

from assetkit.affordances.find import refuted_grasp_findings
from assetkit.affordances.grasp_trials import ENOUGH, TRIED, grasp_lines, try_grasps
from assetkit.affordances.grasps import propose_grasps
from sim.fake import FakeSimulator
from tests.assetkit.affordances.test_grasps import THINGS

BODY = THINGS["box"]
GRASPS = propose_grasps(BODY, ()).grasps


def test_the_best_are_tried_and_the_others_said_to_be_untried():
    tried = try_grasps(GRASPS, BODY, (), FakeSimulator())
    assert [e.value.trial for e in tried] == ["held"] * ENOUGH + ["untried"] * (len(GRASPS) - ENOUGH)
    assert {e.source for e in tried[:ENOUGH]} == {"measured"}
    assert {e.source for e in tried[ENOUGH:]} == {"inferred"}
    assert min(e.confidence for e in tried[:ENOUGH]) > max(e.confidence for e in tried[ENOUGH:])
    assert refuted_grasp_findings(tried) == ()


def test_no_more_than_a_few_are_tried_when_none_holds():
    weak = [g.model_copy(update={"force_n": 1e-3}) for g in GRASPS]
    trials = [e.value.trial for e in try_grasps(weak, BODY, (), FakeSimulator())]
    assert trials == ["not_held"] * TRIED + ["untried"] * (len(GRASPS) - TRIED)


def test_a_grasp_that_slips_is_refuted_told_and_left_out_of_the_lines():
    weak = GRASPS[0].model_copy(update={"force_n": 1e-3})
    tried = try_grasps((weak, *GRASPS[1:]), BODY, (), FakeSimulator())
    assert tried[0].value.trial == "not_held"
    assert tried[0].confidence == 0.0
    assert [d.code for d in refuted_grasp_findings(tried)] == ["asset/grasp-not-held"]
    lines = grasp_lines(tried)
    assert len(lines) == len(GRASPS) - 1
    assert lines[0] == GRASPS[1].contacts_m
