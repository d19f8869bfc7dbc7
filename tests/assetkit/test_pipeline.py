"""The one loop of the pipeline: stages repeat as their step says, with reasons in the log, and never without end."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from assetkit.options import Options
from assetkit.pipeline import STAGES, run_stages
from assetkit.sources.discover import discover
from assetkit.stage import Appearance, Canonical, Draft, Frame, MissingResult, Semantics, Stage, StageResult, Tools
from assetkit.stage_log import StageLog
from assetkit.stages.appearance import NormalizeAppearance
from assetkit.stages.canonicalize import Canonicalize
from assetkit.stages.intake import ReadSource
from assetkit.steps import Pipeline, Refinement, Revision, Step
from jobs.cache import Cache
from schemas.asset import RepeatReason, StageEntry
from schemas.diagnostics import Severity, finding
from schemas.outcome import ItemOutcome, Outcome
from sim.fake import FakeSimulator
from tests.support.bad_inputs.assets import CUBE, LYING_CUP, obj_text

FIRST = STAGES.steps[0]
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


class Counted(Stage):
    """A stage of the pipeline that counts its runs."""

    def __init__(self, stage: Stage) -> None:
        self.name, self.version, self.result, self.reads = stage.name, stage.version, stage.result, stage.reads
        self.stage, self.runs = stage, 0

    def run(self, draft: Draft, tools: Tools) -> Outcome[StageResult]:
        """The result of the stage."""
        self.runs += 1
        return self.stage.run(draft, tools)


def source(folder: Path, name: str = "part.obj", text: str = "") -> Draft:
    (folder / name).write_text(text or obj_text(CUBE))
    return Draft("part", name, ReadSource().run(discover([folder / name])[0], Options()).objects[0])


def run(draft: Draft, pipeline: Pipeline, folder: Path) -> tuple[Draft, StageLog]:
    log, tools = StageLog(), Tools(FakeSimulator(), folder, Options())
    done = run_stages(draft, tools, log, Cache(folder / "store"), "key", pipeline)
    assert done is not None
    return done, log


def turned_again(draft: Draft) -> Revision:
    """A frame a quarter turn further, whatever the draft: a loop that never ends by itself."""
    return Revision(Frame(QUARTER @ draft[Canonical].R_AS), {RepeatReason.FRONT: {"turn_deg": 90.0}})


@pytest.mark.parametrize("at_most", [1, 3])
def test_a_loop_that_would_not_end_is_stopped_and_goes_to_a_person(tmp_path: Path, at_most: int) -> None:
    stage = Counted(Canonicalize())
    loop = Refinement(("canonicalize",), turned_again, at_most)
    draft, log = run(source(tmp_path), Pipeline((FIRST, Step(stage, loop))), tmp_path)
    assert stage.runs == 1 + at_most
    assert (np.linalg.matrix_power(QUARTER.astype(int), at_most) == draft[Canonical].R_AS).all()
    (unsettled,) = [d for d in log.diagnostics if d.code == "asset/frame-unsettled"]
    assert (unsettled.value, unsettled.bound, unsettled.unit) == (at_most + 1, at_most, "repeated passes")
    assert log.outcome is ItemOutcome.REVIEW
    assert [repeated.stages for repeated in log.entries["canonicalize"].repeats] == [("canonicalize",)] * at_most


def test_a_lying_mug_in_millimetres_is_observed_again_and_the_history_says_why(tmp_path: Path) -> None:
    text = obj_text(LYING_CUP.copy().apply_scale(1000.0))
    draft, log = run(source(tmp_path, "mug.obj", text), STAGES.up_to("semantics"), tmp_path)
    (repeated,) = log.entries["semantics"].repeats
    assert repeated.stages == ("canonicalize",)
    assert set(repeated.reasons) == {RepeatReason.UNIT, RepeatReason.WAY_UP}
    assert repeated.reasons[RepeatReason.UNIT]["meters_per_unit_after"] == pytest.approx(0.001)
    assert repeated.reasons[RepeatReason.WAY_UP] == {"turn_deg": 90.0}
    assert draft.frame == draft[Semantics].frame
    (entry,) = [e for e in log.history if e.repeats]
    assert (entry.name, StageEntry.model_validate_json(entry.model_dump_json())) == ("semantics", entry)


def test_what_stays_in_its_frame_repeats_nothing_and_its_history_is_as_before(tmp_path: Path) -> None:
    _, log = run(source(tmp_path, text="# units: m\n" + obj_text(CUBE)), STAGES.up_to("semantics"), tmp_path)
    assert [e.repeats for e in log.entries.values()] == [()] * 3
    assert [set(e.model_dump()) for e in log.history] == [{"name", "version", "key"}] * 3


def test_the_reasons_are_the_same_from_the_store(tmp_path: Path) -> None:
    draft = source(tmp_path, "mug.obj", obj_text(LYING_CUP.copy().apply_scale(1000.0)))
    _, first = run(draft, STAGES.up_to("semantics"), tmp_path)
    _, second = run(draft, STAGES.up_to("semantics"), tmp_path)
    assert all(entry.cached for entry in second.entries.values())
    assert second.history == first.history


class FailsInAnotherFrame(Counted):
    """Gives a value with an error wherever the frame is not that of the file."""

    def run(self, draft: Draft, tools: Tools) -> Outcome[StageResult]:
        """The result of the stage, with an error in another frame."""
        error = finding("asset/no-faces", "none here", severity=Severity.ERROR)
        return replace(super().run(draft, tools), diagnostics=() if draft.frame is None else (error,))


def test_a_stage_that_fails_in_its_new_frame_ends_the_object(tmp_path: Path) -> None:
    step = Step(FailsInAnotherFrame(Canonicalize()), Refinement(("canonicalize",), turned_again, 1))
    after = Counted(NormalizeAppearance())
    _, log = run(source(tmp_path), Pipeline((FIRST, step, Step(after))), tmp_path)
    assert log.rejected
    assert after.runs == 0
    assert log.entries["canonicalize"].repeats[0].reasons == {RepeatReason.FRONT: {"turn_deg": 90.0}}


def test_a_result_that_a_stage_does_not_declare_is_refused_in_every_run(tmp_path: Path) -> None:
    class Undeclared(NormalizeAppearance):
        reads = ()

        def run(self, draft: Draft, tools: Tools) -> Outcome[Appearance]:
            draft[Canonical]
            return super().run(draft, tools)

    with pytest.raises(MissingResult, match="holds no Canonical here"):
        run(source(tmp_path), Pipeline((FIRST, Step(Canonicalize()), Step(Undeclared()))), tmp_path)
