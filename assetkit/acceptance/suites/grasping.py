"""What the suites that pick an object up share: when they cannot run, and the choice among several grasps."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from assetkit.acceptance.suites.suite import CheckList, Subject, SuiteRun, at_least
from geom.convex.support_function import diagonal
from schemas.affordances import Grasp
from schemas.diagnostics import Location
from sim.port import SMALLEST_M


def tiny(subject: Subject) -> str:
    """That contacts of engines are too coarse for the subject, in words; "" where they are not."""
    if diagonal(subject.body.shapes) < SMALLEST_M:
        return f"it is smaller than {1000 * SMALLEST_M:.0f} mm, too small for contacts of engines"
    return ""


def not_picked_up(subject: Subject) -> str:
    """Why nothing picks the subject up, in words: it has joints, or is too small; "" where something does."""
    return "it has joints, and is held by its base" if subject.is_articulated else tiny(subject)


def best_grasp(
    subject: Subject, grasps: Sequence[Grasp], reason: str, code: str, attempt: Callable[[Grasp], SuiteRun]
) -> SuiteRun:
    """Of several grasps the run of the first that passes, else of the one with the most checks passed.

    Without any, a run that fails with `code` for the `reason`.
    """
    if not grasps:
        checks = CheckList(Location(file=subject.main_file.name))
        checks.add(code, f"no gripper can hold it: {reason}", at_least("grasps", 0, 1, ""))
        return checks.run()
    runs: list[SuiteRun] = []
    for grasp in grasps:
        runs.append(attempt(grasp))
        if runs[-1].passes:
            break
    return max(runs, key=lambda run: sum(check.passed for check in run.checks))
