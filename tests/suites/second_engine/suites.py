"""Suites of acceptance in both engines, on every rigid package of a library: outcomes, figures, disagreements.

    python -m tests.suites.second_engine.suites LIBRARY [--most N]

Each suite runs at the values of the package, once in PyBullet and once in MuJoCo, on the bodies as re-read from its
USD. A disagreement is a check that passes in one engine only; its likely cause is named by rule (`likely_cause`).
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from assetkit.acceptance.suites.common import CommonSuite
from assetkit.acceptance.suites.manipulated import ManipulatedSuite, grasps_to_try
from assetkit.acceptance.suites.subject import subject_on_disk
from assetkit.acceptance.suites.suite import NOMINAL, Subject, SuiteRun
from assetkit.library.validate import main_usd_files
from geom.convex.support_function import diagonal
from schemas.acceptance import Check
from schemas.diagnostics import InvalidInput
from sim.bullet.simulator import BulletSimulator
from sim.port import LARGEST_M, SMALLEST_M, Simulator
from tests.suites.second_engine.mujoco_simulator import MujocoSimulator

NEAR = 0.25  # of the bound: a figure this close to it in the other engine is a matter of degree


@dataclass(frozen=True)
class Comparison:
    """One suite on one package in both engines; `first` is PyBullet."""

    package: str
    suite: str
    first: SuiteRun
    second: SuiteRun

    @property
    def agree(self) -> bool:
        """Whether both pass or both fail."""
        return self.first.passes == self.second.passes

    def disagreements(self) -> list[str]:
        """The checks that pass in one engine only, with both figures and the likely cause."""
        there = {check.name: check for check in self.second.checks}
        both = [(check, there[check.name]) for check in self.first.checks if check.name in there]
        return [
            f"{a.name}: {a.value:.3g} in PyBullet, {b.value:.3g} in MuJoCo, bound {a.bound:.3g} {a.unit}"
            f" ({likely_cause(a, b)})"
            for a, b in both
            if a.passed != b.passed
        ]


def likely_cause(first: Check, second: Check) -> str:
    """In words, by the figure in question."""
    if first.bound and abs(abs(first.value) - abs(second.value)) <= NEAR * abs(first.bound):
        return "a matter of degree: the figures are close and lie on both sides of the bound"
    if first.name in ("slip", "landing_turn", "landing_drift"):
        return "MuJoCo's friction is a soft constraint: what is held creeps or turns between the pads"
    if first.name == "phases_held":
        return "contact patches: PyBullet keeps up to four points per pair, MuJoCo makes them anew each step"
    if first.name.startswith("slope") or first.name.endswith(("tilt", "place")):
        return "rolling and tipping amplify the first contact, which the engines resolve differently"
    return "unknown"


def compare(subject: Subject) -> Iterator[Comparison]:
    """Both suites on a rigid subject of a size that neither engine has to scale."""
    with BulletSimulator() as bullet:
        mujoco = cast(Simulator, MujocoSimulator())  # Of the protocol it has what these suites need.
        for suite in (CommonSuite(), ManipulatedSuite()):
            if suite.obstacle(subject):
                continue
            if isinstance(suite, ManipulatedSuite) and not grasps_to_try(subject)[0]:
                continue
            first = suite.run(subject, bullet, NOMINAL)
            second = suite.run(first.tried or subject, mujoco, NOMINAL)
            yield Comparison(subject.main_file.stem, suite.name, first, second)


def rigid_subjects(library: Path) -> Iterator[Subject]:
    """Packages of a library, without mechanisms and what is too small or too large for an engine at true size."""
    with BulletSimulator() as simulator:
        for folder in sorted(record.parent for record in library.glob("*/record.json")):
            try:
                subject = subject_on_disk(main_usd_files(folder)[0], simulator)
            except InvalidInput:
                continue
            if not subject.is_articulated and SMALLEST_M <= diagonal(subject.body.shapes) <= LARGEST_M:
                yield subject


def main() -> None:
    """Print a line per suite and package, disagreements below, and counts at the end."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("library", type=Path)
    parser.add_argument("--most", type=int, default=1000)
    arguments = parser.parse_args()
    comparisons: list[Comparison] = []
    for number, subject in enumerate(rigid_subjects(arguments.library)):
        if number >= arguments.most:
            break
        for comparison in compare(subject):
            comparisons.append(comparison)
            outcome = [("fails", "passes")[run.passes] for run in (comparison.first, comparison.second)]
            print(f"{comparison.package} | {comparison.suite} | {outcome[0]} | {outcome[1]}", flush=True)
            for line in comparison.disagreements():
                print(f"    {line}", flush=True)
    for suite in sorted({c.suite for c in comparisons}):
        of_suite = [c for c in comparisons if c.suite == suite]
        print(f"{suite}: {sum(c.agree for c in of_suite)} of {len(of_suite)} packages agree")


if __name__ == "__main__":
    main()
