"""Samples judged in batches, in a given number of processes."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from functools import cache
from multiprocessing import get_context
from pathlib import Path

from rich.progress import Progress

from runtime_plan import Plan, load, read_samples, sample
from runtime_plan.verify import Judge, Row
from schemas.scene.plan_report import PlanVerdict, SampleViolation

VERIFIED_AT_ONCE = 8192
MOST_LISTED_VIOLATIONS = 1000


def judge_file(plan: Path, samples: Path) -> PlanVerdict:
    """The verdict on a file of samples. Raises InvalidInput for a plan or a file that cannot be used."""
    ready = load(plan)
    indices, read = read_samples(samples, ready)
    return _verdict(len(indices), list(Judge(ready).violations(read, indices)))


def judge_drawn(plan: Path, n: int, seed: int, jobs: int, progress: Progress) -> PlanVerdict:
    """The verdict on the first n samples of a stream, which are drawn again by each process that judges them."""
    load(plan)  # a plan that cannot be used is refused here, not in a process of its own
    batches = [(plan, seed, start, min(VERIFIED_AT_ONCE, n - start)) for start in range(0, n, VERIFIED_AT_ONCE)]
    task = progress.add_task("judging", total=n)
    violations: list[Row] = []
    pool = ProcessPoolExecutor(jobs, get_context("spawn")) if jobs > 1 else nullcontext()
    with pool as workers:
        verdicts: Iterable[list[Row]] = workers.map(_judged, batches) if workers else map(_judged, batches)
        for batch, rows in zip(batches, verdicts, strict=True):
            violations += rows
            progress.update(task, advance=batch[3])
    return _verdict(n, violations)


def _judged(batch: tuple[Path, int, int, int]) -> list[Row]:
    path, seed, start, n = batch
    plan, judge = _judge(path)
    return list(judge.violations(sample(plan, n, seed, start)))


@cache
def _judge(path: Path) -> tuple[Plan, Judge]:
    plan = load(path)
    return plan, Judge(plan)


def _verdict(checked: int, rows: list[Row]) -> PlanVerdict:
    listed = tuple(SampleViolation.model_validate(row) for row in rows[:MOST_LISTED_VIOLATIONS])
    return PlanVerdict(checked=checked, invalid=len({row["index"] for row in rows}), violations=listed)
