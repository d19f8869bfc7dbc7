"""What `review` asks a person, answered: an object that somebody accepted with its findings is no question any more."""

from __future__ import annotations

from dataclasses import replace

from assetkit.options import Options
from assetkit.stage_log import Entry, Journal
from schemas.diagnostics import Severity, finding


def accepted_by_person(journal: Journal, options: Options) -> Journal:
    """The journal without its questions, where the last decision accepts the object and knew all its findings.

    A decision covers what the person saw: findings of other codes that appeared since keep the object in review, and
    are told. Errors are never accepted.
    """
    verdict = next((d for d in reversed(options.decisions) if d.accept is not None), None)
    if verdict is None or not verdict.accept or not any(e.review for e in journal.entries.values()):
        return journal
    entries = journal.entries.values()
    doubts = {d.code for e in entries for d in e.diagnostics if e.review or d.severity is not Severity.INFO}
    unseen = sorted(doubts - set(verdict.known))
    settled = journal.copy()
    if unseen:
        headline = f"{verdict.by} accepted the object without knowing of {', '.join(unseen)}"
        settled.entries["decision_scope"] = Entry((finding("asset/decision-outdated", headline),))
        return settled
    settled.entries = {name: replace(entry, review=False) for name, entry in settled.entries.items()}
    return settled
