"""Draws of a plan, judged by the independent judge."""

from __future__ import annotations

from runtime_plan import sample
from runtime_plan.plan import prepare
from runtime_plan.samples import Samples
from runtime_plan.verify import Judge, Row
from schemas.scene.runtime_plan import RuntimePlan


def drawn(plan: RuntimePlan, n: int, seed: int = 5) -> Samples:
    """The first n samples of a plan."""
    return sample(prepare(plan), n, seed)


def refused(plan: RuntimePlan, n: int, seed: int = 5) -> list[Row]:
    """The violations of the first n samples of a plan."""
    return list(Judge(prepare(plan)).violations(drawn(plan, n, seed)))
