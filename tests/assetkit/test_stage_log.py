"""The outcome of an object follows from what its stages logged."""

from __future__ import annotations

from assetkit.stage_log import Entry, StageLog
from schemas.diagnostics import finding
from schemas.outcome import ItemOutcome, Repair


def test_outcome_of_a_journal():
    assert StageLog().outcome is ItemOutcome.ACCEPTED
    repair = Repair(name="hole_fill", code="asset/small-holes", stage="canonicalize")
    assert StageLog({"a": Entry(repairs=(repair,))}).outcome is ItemOutcome.REPAIRED
    assert StageLog({"a": Entry(repairs=(repair,)), "b": Entry(review=True)}).outcome is ItemOutcome.REVIEW
    refused = finding("asset/path-escape", "out")
    assert StageLog({"a": Entry((refused,), review=True)}).outcome is ItemOutcome.REJECTED
