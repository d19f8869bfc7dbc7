"""Clears the review flag of an object once a person has accepted it with its findings."""

from __future__ import annotations

from dataclasses import replace

from assetkit.options import Options
from assetkit.stage_log import Entry, StageLog
from schemas.diagnostics import Severity, finding


def apply_human_acceptance(log: StageLog, options: Options) -> StageLog:
    """The journal without its questions, where the last decision accepts the object and knew all its findings.

    A decision covers the findings that the person saw: findings of other codes that appeared since keep the object in
    review, with a finding of their own. Errors are never accepted.
    """
    verdict = next((d for d in reversed(options.decisions) if d.accept is not None), None)
    if verdict is None or not verdict.accept or not any(e.review for e in log.entries.values()):
        return log
    entries = log.entries.values()
    doubts = {d.code for e in entries for d in e.diagnostics if e.review or d.severity is not Severity.INFO}
    unseen = sorted(doubts - set(verdict.known))
    accepted = log.copy()
    if unseen:
        headline = f"{verdict.by} accepted the object without knowing of {', '.join(unseen)}"
        accepted.entries["decision_scope"] = Entry((finding("asset/decision-outdated", headline),))
        return accepted
    accepted.entries = {name: replace(entry, review=False) for name, entry in accepted.entries.items()}
    return accepted
