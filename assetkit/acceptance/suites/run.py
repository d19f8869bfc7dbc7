"""Runs the suites of a subject and makes of each a section of the record, and findings."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from assetkit.acceptance.suites.margins import variations
from assetkit.acceptance.suites.suite import NOMINAL, Subject, Suite, SuiteRun
from schemas.acceptance import SuiteSection
from schemas.diagnostics import Diagnostic
from sim.port import Simulator


@dataclass(frozen=True)
class SuiteResult:
    """The section of one suite, its findings, and its run at the values of the package, if it was run."""

    suite: Suite
    section: SuiteSection
    findings: tuple[Diagnostic, ...] = ()
    nominal: SuiteRun | None = None

    @property
    def failed(self) -> bool:
        """Whether a check did not pass."""
        return self.section.outcome == "failed"


def suites_for(subject: Subject, suites: Collection[Suite]) -> tuple[Suite, ...]:
    """Those for every object, and those for a role of the subject."""
    return tuple(suite for suite in suites if not suite.roles or suite.roles & set(subject.roles))


def run_suite(suite: Suite, subject: Subject, simulator: Simulator, *, thorough: bool = True) -> SuiteResult:
    """One suite at the values of the package; if it passes and is to be `thorough`, also under other conditions."""
    if obstacle := suite.obstacle(subject):
        return SuiteResult(suite, SuiteSection(name=suite.name, outcome="not_run", reason=obstacle))
    nominal = suite.run(subject, simulator, NOMINAL)
    section = SuiteSection(name=suite.name, outcome="passed" if nominal.passes else "failed", checks=nominal.checks)
    if nominal.passes and thorough and suite.varies:
        varied = variations(suite, nominal.tried or subject, simulator)
        section = section.model_copy(
            update={"repeats": varied.repeats, "corners": varied.corners, "margins": varied.margins}
        )
    return SuiteResult(suite, section, nominal.findings, nominal)
