"""Repairs a draft that fails acceptance: one bounded edit at a time, then the stages that depend on it run again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from assetkit.acceptance.repairs import RepairRule
from assetkit.stage import Draft
from assetkit.stage_log import Entry, StageLog
from schemas.diagnostics import Diagnostic
from schemas.outcome import Repair

Rerun = Callable[[Draft, StageLog, str], Draft | None]


def repair_until_accepted(
    draft: Draft, log: StageLog, rules: Sequence[RepairRule], at_most: int, rerun: Rerun
) -> tuple[Draft, StageLog]:
    """The draft that acceptance passes after at most so many edits, or the first one.

    `rerun(draft, log, stage)` runs `stage` and all after it, writing to `log`. An attempt counts as better only if it
    has none of the failures that a rule answers, and is not rejected. Where nothing helps the first draft stays; it
    goes to a person, unless all that failed were roles that it does not have to have.
    """
    attempt, notes = draft, log
    for _ in range(at_most):
        step = _next(attempt, notes, rules)
        if step is None:
            break
        rule, code, edited = step
        notes = log.copy()
        again = rerun(edited, notes, rule.first_stage)
        if again is None:
            break
        attempt = again
        if not _failures(notes, rules) and not notes.rejected and again.acceptance is not None:
            notes.entries["repair"] = Entry(repairs=(_record(rule, code, draft, again),))
            return again, notes
    if any(d.code in rule.failures for d in log.diagnostics for rule in rules):
        log.entries["repair"] = Entry(review=True)
    return draft, log


def _next(draft: Draft, log: StageLog, rules: Sequence[RepairRule]) -> tuple[RepairRule, str, Draft] | None:
    """The first rule that answers a failure and has an edit left, the failure, and the draft with the edit."""
    codes = _failures(log, rules)
    for rule in rules:
        for code in codes:
            if code not in rule.failures:
                continue
            edits = rule.edit(draft)
            if edits is not None:
                return rule, code, replace(draft, edits=edits)
            break
    return None


def _failures(log: StageLog, rules: Sequence[RepairRule]) -> list[str]:
    """Codes of the findings that a rule answers, in order; also of those that withdrew a role."""
    answered = frozenset[str]().union(*(rule.failures for rule in rules))
    return list(dict.fromkeys(d.code for d in all_findings(log.diagnostics) if d.code in answered))


def all_findings(diagnostics: Sequence[Diagnostic]) -> Iterator[Diagnostic]:
    """The findings, and after a role that was withdrawn those that led to it."""
    for diagnostic in diagnostics:
        yield diagnostic
        if diagnostic.code == "asset/role-withdrawn":
            yield from diagnostic.because


def _record(rule: RepairRule, code: str, before: Draft, after: Draft) -> Repair:
    """The repair with the figures of acceptance that both drafts have, and what was edited."""
    was, now = _figures(before), _figures(after)
    return Repair(
        name=rule.name,
        code=code,
        stage=rule.first_stage,
        before={**_edited(before), **{k: v for k, v in was.items() if k in now}},
        after={**_edited(after), **{k: v for k, v in now.items() if k in was}},
    )


def _edited(draft: Draft) -> dict[str, float | int | str]:
    collider = draft.physics.section.collision_method if draft.physics else ""
    return {
        "collider": collider,
        "tried_grasps": draft.edits.tried_grasps,
        "friction_gain": draft.edits.friction_gain,
    }


def _figures(draft: Draft) -> dict[str, float | int | str]:
    """Figures by name: of the object, and of suites as `suite/figure`."""
    if draft.acceptance is None:
        return {}
    section = draft.acceptance.section
    of_suites = {f"{suite.name}/{check.name}": check.value for suite in section.suites for check in suite.checks}
    return {**{check.name: check.value for check in section.checks}, **of_suites}
