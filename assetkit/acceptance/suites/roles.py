"""What the outcome of suites means for the roles of an object: those that are borne out stay on its record.

A role that its source or user declares is a promise: where its suite fails, a person must look. A role that was only
inferred is withdrawn, with a finding. What every object does is reported.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from assetkit.acceptance.suites.run import SuiteResult
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence


@dataclass(frozen=True)
class RoleVerdict:
    """Roles to take off the record, findings, and whether a person should review the package."""

    withdrawn: tuple[str, ...]
    findings: tuple[Diagnostic, ...]
    review: bool


def judge_roles(roles: Sequence[Evidence[str]], results: Sequence[SuiteResult]) -> RoleVerdict:
    """The verdict on `roles` from the results of the suites that exercised them."""
    withdrawn: set[str] = set()
    findings: list[Diagnostic] = []
    review = False
    for result in (r for r in results if r.failed):
        promised = [e for e in roles if e.value in result.suite.roles]
        if not result.suite.roles or any(e.source == "declared" for e in promised):
            findings += result.findings
            review |= bool(result.suite.roles)
            continue
        lost = [role.value for role in promised]
        withdrawn |= set(lost)
        names = " and ".join(f"'{name}'" for name in lost)
        number = "the role {} is" if len(lost) == 1 else "the roles {} are"
        headline = f"{number.format(names)} not borne out in simulation: {result.findings[0].headline}"
        findings.append(finding("asset/role-withdrawn", headline, because=result.findings))
    return RoleVerdict(tuple(sorted(withdrawn)), tuple(findings), review)
