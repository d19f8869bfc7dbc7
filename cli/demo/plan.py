"""The plan of the demo's scene: some thousand samples judged, six of them drawn."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from cli import text
from cli.plan.sheet import draw_sheet
from runtime_plan import load, sample
from runtime_plan.verify import Judge

SHEET = "samples.png"
_JUDGED, _SAMPLED, _SHEET_CASES = 10_000, 4096, 6


@dataclass(frozen=True)
class PlanDemo:
    """How many cases the plan has, how many samples were judged, how many were invalid, scenes per CPU second."""

    cases: int
    judged: int
    invalid: int
    rate: int


def plan_demo(file: Path) -> PlanDemo:
    """Sample the plan `file`, judge the samples, and write `samples.png` beside it."""
    plan = load(file)
    sample(plan, _SAMPLED, 1)
    since = time.process_time()
    sample(plan, _SAMPLED, 2)
    seconds = time.process_time() - since
    wrong = {row["index"] for row in Judge(plan).violations(sample(plan, _JUDGED, 0))}
    with text.progress(quiet=True) as progress:
        draw_sheet(plan, file.parent, _SHEET_CASES, 0, file.parent / SHEET, progress)
    cases = sum(len(pool.cases) for one in plan.document.combinations for pool in one.pools)
    return PlanDemo(cases, _JUDGED, len(wrong), int(_SAMPLED / seconds))
