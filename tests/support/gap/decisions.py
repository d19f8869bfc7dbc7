"""Whether the reasons in a sim gap report agree with the values beside them and with the rest of the report."""

from __future__ import annotations

import re
from collections import Counter

from schemas.sim_gap.decisions import CandidateDecision, Reason
from schemas.sim_gap.report import GapReport
from simgap.inference.verdict_text import NAMED

WHOLE = "mean square error of whole (test|training) trials"
# What decides, by reason: the quantity of the last criterion, and on which side of its bound a refused value lies.
DECIDES = {
    Reason.NOT_PROMISING: (
        "smaller p-value|loss that a linear step takes off whole trials|share of the best score",
        "<|>=",
    ),
    Reason.OUTRANKED: ("rank by (held-out gain|direct loss|held-out loss|loss)|models that were fitted", "<=?"),
    Reason.NOT_SIGNIFICANT: ("(adjusted )?p-value|p of the direct losses", "<"),
    Reason.TOO_SMALL: (
        "share of the loss removed|gain of the direct losses|held-out loss per row that it takes off",
        ">",
    ),
    Reason.INTERVAL_INCLUDES_NONE: ("distance of .* from no effect", ">"),
    Reason.BOUND_REACHED: ("half width of .*", ">"),
    Reason.NOT_DETERMINED: ("half width of .*", ">"),
    Reason.MAKES_VANISH: ("distance of .* of .*@.* from no effect", ">="),
    Reason.TEST_TRIALS_WORSE: ("ratio of test losses, .*", "<"),
    Reason.METHOD_BIAS: ("distance of .* from no effect", ">"),
    Reason.ACCEPTED_AFTER: ("rank among significant candidates", "<="),
    Reason.FITS_WORSE_THAN: ("p of being no worse|p-value of no better held-out loss", ">=?"),
    Reason.EXPLAINS_LESS_THAN: ("held-out gain", ">=?"),
    Reason.MORE_PARAMETERS_THAN: ("share of its held-out gain|share of the pair's loss|parameters", "[<>]=?"),
    Reason.INCOMPLETE_WITHOUT: ("p of the other on top of it", ">="),
    Reason.REPLACED_BY: ("p of being no worse|parameters of candidates as good", "[<>]="),
    Reason.NO_LONGER_NEEDED: ("distance of .* from no effect", ">"),
    Reason.MIMICKED_BY: ("(direct p|p of the direct|gain of the direct) .*", "[<>]"),
    Reason.NO_DIRECT_ESTIMATE: ("direct estimates|direct losses to compare", ">"),
    Reason.DIRECT_NOT_SIGNIFICANT: ("direct p-value.*", "<"),
    Reason.DIRECT_DISAGREES: ("(product|distance) of both estimates of .*", "<=|>"),
    Reason.DIRECT_PREFERS: ("p of the direct losses", ">="),
    Reason.INPUTS_OF_OTHERS: ("failed checks of input pairing", "<="),
    Reason.SINGLE_TRIAL: ("gains without an interval", "<="),
    Reason.LESS_THAN_UNEXPLAINED: (f"share of the loss that comes back without it|{WHOLE}.*", "[<>]="),
    Reason.INSEPARABLE_FROM: ("models of the confidence set without the effect", "<="),
    Reason.SHAPE_DIFFERS: (
        "share of what repeats in the balance along .* that the law explains|p-value of structure in the balance .*",
        ">=",
    ),
    Reason.REMAINDER_OF: ("confusable effects in doubt at its place", "<="),
}
PASSES = {
    "screen": {Reason.PASSED},
    "confirm": {Reason.PASSED},
    "compare": {Reason.PASSED, Reason.INSEPARABLE_FROM},
    "judge": {Reason.NAMED, Reason.SHAPE_HIDDEN},
}
MIMICS = (Reason.MIMICKED_BY, Reason.DIRECT_PREFERS, Reason.INSEPARABLE_FROM)
NEEDS_ANOTHER = {r for r in Reason if re.search(r" (than|by|from|without|to|after|prefers|of)$", f" {r}")}


def contradictions(report: GapReport) -> list[str]:
    """Each decision whose reason and values do not belong together, or that the rest of the report contradicts."""
    bad = [f"{d.name}: {d.reason}" for d in report.decisions if not _fits(d)]
    if Counter(d.reason for d in report.decisions) != report.reason_counts:
        bad.append("counts")
    judged = [d for d in report.decisions if d.step == "judge"]
    sure = [(e.name, e.where) for e in report.verdict.effects if e.confidence >= NAMED]
    if [(d.name, d.where) for d in judged if d.reason is Reason.NAMED] != sure:
        bad.append("named")
    grouped = {name for g in report.verdict.ambiguous_groups for name in g.effects}
    mimics = {d.beside.partition("@")[0] for d in judged if d.reason in MIMICS}
    doubted = mimics | {d.name for d in judged if d.reason not in (Reason.NAMED, Reason.NO_LONGER_NEEDED)}
    # What does not come down to the noise over whole trials is in doubt with causes that have no name.
    unexplained = any(re.match(WHOLE, c.quantity) and not c.holds for d in judged for c in d.criteria)
    if grouped != (set() if unexplained else doubted):
        bad.append("groups")
    p_values = {(h.name, h.where): h.p_adjusted for h in report.hypotheses}
    first = [d for d in report.decisions if (d.step, d.round_number) == ("confirm", 0)]
    stated = {(d.name, d.where): p for d in first if (p := _p_adjusted(d)) is not None}
    bad += [name for (name, where), p in stated.items() if p != p_values.get((name, where))]
    return bad


def _fits(decision: CandidateDecision) -> bool:
    passes = decision.reason in PASSES[decision.step]
    if decision.kept != all(c.holds for c in decision.criteria) or decision.kept != passes:
        return False
    if ("@" in decision.beside) != (decision.reason in NEEDS_ANOTHER):
        return False
    if decision.kept or decision.reason not in DECIDES:
        return decision.kept
    quantity, relation = DECIDES[decision.reason]
    *before, last = decision.criteria
    refused = not last.holds and all(c.holds for c in before)
    return refused and bool(re.fullmatch(quantity, last.quantity)) and bool(re.fullmatch(relation, last.relation))


def _p_adjusted(decision: CandidateDecision) -> float | None:
    return next((c.value for c in decision.criteria if c.quantity == "adjusted p-value"), None)
