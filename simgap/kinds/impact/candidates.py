"""Candidate effects of a body in a table of impacts, and declared numbers that are believed within a tolerance."""

from __future__ import annotations

import numpy as np

from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.effects.effect import Effect
from sim.effects.library import EFFECTS
from sim.effects.ranges import SUPPORT_PAIR, ImpactRanges
from simgap.problem import Candidate


def candidates_of(ranges: ImpactRanges) -> tuple[Candidate, ...]:
    """Every effect of the library that impacts can reveal, in library order."""
    return tuple(_candidate(e, ranges) for e in EFFECTS if "impact" in e.kinds and e.impact.observable(ranges))


def _candidate(each: Effect, ranges: ImpactRanges) -> Candidate:
    where = Place(pair=SUPPORT_PAIR) if each.family == "contact" else Place(body="body")
    null = each.null() | each.impact.null(ranges)
    bounds = {p.name: (p.low, p.high) for p in each.parameters} | each.impact.bounds(ranges)
    return Candidate(each, where, null, {n: float(np.clip(v, *bounds[n])) for n, v in null.items()}, bounds)


def nuisances_of(body: BodyModel) -> tuple[Candidate, ...]:
    """Declared numbers of the pair within their tolerance."""
    out = []
    for each in EFFECTS:
        known = each.impact.nuisance(body) if "impact" in each.kinds else None
        if known is not None:
            value, bounds = {known.parameter: known.value}, {known.parameter: (known.low, known.high)}
            start = {known.parameter: float(np.clip(known.value, known.low, known.high))}
            out.append(Candidate(each, Place(pair=SUPPORT_PAIR), value, start, bounds, nuisance=True))
    return tuple(out)
