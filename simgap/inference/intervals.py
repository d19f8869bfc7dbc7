"""Intervals of an effect's parameters from its fit, its direct estimate and its rivals, possibly asymmetric; SI."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from schemas.sim_gap.decisions import Reason
from schemas.sim_gap.extension import Estimate
from simgap.inference.candidate_fit import CandidateFit
from simgap.inference.decision import Decision, criterion, decide, either
from simgap.inference.fit import ROUNDING_MARGIN
from simgap.problem import DirectEstimate, Term

Sides = dict[str, tuple[float, float]]  # how far an interval reaches below and above a value, by parameter


def symmetric(widths: Mapping[str, float]) -> Sides:
    """The same below and above."""
    return {n: (w, w) for n, w in widths.items()}


def wider(sides: Sides, least: Sides) -> Sides:
    """Of either, how far it reaches below and above."""
    none = (0.0, 0.0)
    both = {n: (sides.get(n, none), least.get(n, none)) for n in {**sides, **least}}
    return {n: (max(a[0], b[0]), max(a[1], b[1])) for n, (a, b) in both.items()}


def distance_to_alternatives(
    term: Term, widths: Mapping[str, float], direct: DirectEstimate | None, rivals: Sequence[Sequence[CandidateFit]]
) -> Sides:
    """How far values lie from those beside rivals of the other effects, and from the direct estimate, either way.

    Where that lies beyond `widths`, either route may be the right one: its own interval counts too. It does as well
    where the direct route set the bounds of the fit.
    """
    others = [t.values for each in rivals for r in each for t in r.fit.model if t.candidate.key == term.candidate.key]
    out: Sides = {}
    for n, value in term.values.items():
        ends = [o[n] for o in others]
        if direct is not None:
            apart = abs(direct.values[n] - value) > widths.get(n, 0.0)
            own = 1.96 * direct.standard_errors[n] if apart or n in term.candidate.direct_half_width else 0.0
            ends += [direct.values[n] - own, direct.values[n] + own]
        out[n] = (max([0.0, *(value - e for e in ends)]), max([0.0, *(e - value for e in ends)]))
    return out


def threshold_excess(term: Term) -> dict[str, float]:
    """Half of how far motion went beyond each threshold: one that yields more and more begins so much earlier.

    A joint pressed to a depth d into a stop of a force that grows as its depth to the power n looks as if a linear one
    began up to d (1 - 1/n) later.
    """
    beyond = {n: far - term.values[n] for n, far in term.candidate.max_excursion.items()}
    return {n: 0.5 * abs(d) for n, d in beyond.items() if d * (term.candidate.null[n] - term.values[n]) > 0.0}


def differs_from_none(term: Term, sides: Sides) -> Decision:
    """Kept if some strength still differs from none in the final model: if none lies outside its interval."""
    distances = []
    for n in term.candidate.strengths:
        value, none, (below, above) = term.values[n], term.candidate.null[n], sides.get(n, (0.0, 0.0))
        least = max(below if value > none else above, 1e-9 * abs(none), 1e-12)
        distances.append(criterion(f"distance of {n} from no effect", abs(value - none), ">", ROUNDING_MARGIN * least))
    return decide([(Reason.INTERVAL_INCLUDES_NONE, either(*distances))])


def parameters(term: Term, sides: Sides) -> dict[str, Estimate]:
    """Values with units and 95 % intervals."""
    units = {p.name: p.unit for p in term.candidate.effect.parameters}
    reach = {n: sides.get(n, (0.0, 0.0)) for n in term.values}
    return {
        n: Estimate(value=value, unit=units[n], ci95=(value - reach[n][0], value + reach[n][1]))
        for n, value in term.values.items()
    }
