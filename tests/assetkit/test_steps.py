"""The order of stages is checked when a pipeline is made; a stage sees what it declares and nothing else."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from assetkit.acceptance.repairs import RepairRule, another_collider
from assetkit.geometry.reference_frame import revise_by_front
from assetkit.pipeline import STAGES
from assetkit.stage import (
    RESULT_FIELDS,
    Appearance,
    Draft,
    Intake,
    MissingResult,
    Previews,
    StageResult,
)
from assetkit.stages.appearance import NormalizeAppearance
from assetkit.stages.canonicalize import Canonicalize
from assetkit.stages.interaction import ProposeParts
from assetkit.stages.physics import AuthorPhysics
from assetkit.stages.retopology import Retopologize
from assetkit.stages.semantics import DescribeObject
from assetkit.steps import InvalidPipeline, Pipeline, Refinement, Retry, Step
from schemas.evidence import declared
from schemas.model import Model

FIRST = (Step(Retopologize()), Step(Canonicalize()), Step(NormalizeAppearance()))


def empty() -> Draft:
    model = Model((), (), (), (), declared(1.0, "test"), declared("z", "test"))
    return Draft("part", "part.obj", Intake("obj", (), model, (1.0, 1.0, 1.0)))


def loop(*repeats: str, at_most: int = 1) -> Refinement:
    return Refinement(repeats, revise_by_front, at_most)


def retry(first_stage: str, at_most: int = 1) -> Retry:
    return Retry((RepairRule("rule", frozenset(), first_stage, another_collider),), at_most)


@pytest.mark.parametrize(
    ("steps", "reason"),
    [
        ((FIRST[0], Step(NormalizeAppearance())), "'appearance' reads Canonical, which no earlier stage makes"),
        ((*FIRST, Step(ProposeParts())), "'interaction' reads Semantics"),
        ((*FIRST, Step(DescribeObject()), Step(AuthorPhysics())), "'physics' reads Interaction"),
        ((*FIRST, FIRST[1]), "'canonicalize' occurs twice"),
        ((*FIRST, Step(DescribeObject(), loop("physics"))), "sends a draft to physics, which has not run"),
        ((*FIRST, Step(DescribeObject(), loop("appearance", "canonicalize"))), "repeats stages out of their order"),
        ((*FIRST, Step(DescribeObject(), loop("canonicalize", at_most=0))), "a loop of no pass"),
        ((*FIRST, Step(DescribeObject(), retries=retry("physics"))), "retries from 'physics', which has not run"),
        ((*FIRST, Step(DescribeObject(), retries=retry("semantics", 0))), "a loop of no pass"),
    ],
)
def test_an_order_that_cannot_run_is_refused_when_it_is_made(steps: tuple[Step, ...], reason: str) -> None:
    with pytest.raises(InvalidPipeline, match=re.escape(reason)):
        Pipeline(steps)


def test_a_stage_under_another_name_than_its_field_is_refused() -> None:
    class Renamed(NormalizeAppearance):
        name = "looks"

    with pytest.raises(InvalidPipeline, match="'looks' is not the field of Appearance"):
        Pipeline((FIRST[0], Step(Renamed())))


def test_a_draft_gives_the_result_of_a_type_and_refuses_what_is_not_there() -> None:
    previews = Previews({"thumbnail": b""})
    draft = empty().with_result(previews)
    assert draft[Previews] is previews
    with pytest.raises(MissingResult, match="the draft of 'part' holds no Appearance here"):
        draft[Appearance]


@pytest.mark.parametrize("step", STAGES.steps, ids=lambda step: step.name)
def test_a_stage_sees_only_what_it_reads(step: Step) -> None:
    marks = {name: object() for name in RESULT_FIELDS.values()}
    seen = replace(empty(), **marks, frame=None).limited_to(step.stage.reads)
    visible: set[type[StageResult]] = {r for r, name in RESULT_FIELDS.items() if getattr(seen, name) is not None}
    assert visible == set(step.stage.reads)
    assert step.stage.result not in visible


def test_parts_of_the_pipeline_keep_its_order() -> None:
    names = [step.name for step in STAGES.steps]
    assert names == list(RESULT_FIELDS.values())
    assert [step.name for step in STAGES.up_to("semantics").steps] == names[:4]
    assert STAGES.from_stage("physics").start == names.index("physics") == 6
    before = STAGES.before("physics")
    assert before is not None
    assert (before.name, STAGES.before("retopology")) == ("recovery", None)
    assert np.all([stage.name in names for stage in STAGES.stages("canonicalize", "physics")])
