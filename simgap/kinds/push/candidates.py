"""Candidate effects of a pushed body, and numbers that are assumed or declared nowhere, within an interval."""

from __future__ import annotations

import numpy as np

from schemas.sim_gap.extension import Place
from sim.effects.effect import Effect
from sim.effects.library import EFFECTS
from sim.effects.ranges import SUPPORT_PAIR, PushRanges
from simgap.kinds.push.model import PushModel
from simgap.problem import Candidate


def ranges_of(declared: PushModel, has_force: bool) -> PushRanges:
    """What is declared of body and pusher, and how far the foot reaches."""
    return PushRanges(
        body=declared.body,
        has_force=has_force,
        lever_m=declared.lever_m,
        reference_friction=declared.reference_friction,
        pusher_friction=declared.pusher_friction,
        low_m=declared.points.min(axis=0),
        high_m=declared.points.max(axis=0),
    )


def candidates_of(ranges: PushRanges) -> tuple[Candidate, ...]:
    """Every effect of the library that pushes can reveal, in library order."""
    return tuple(_candidate(e, ranges) for e in EFFECTS if "push" in e.kinds and e.push.observable(ranges))


def _candidate(each: Effect, ranges: PushRanges) -> Candidate:
    where = Place(pair=SUPPORT_PAIR) if each.family == "contact" else Place(body="body")
    null = each.null() | each.push.null(ranges)
    bounds = {p.name: (p.low, p.high) for p in each.parameters} | each.push.bounds(ranges)
    return Candidate(each, where, null, {n: float(np.clip(v, *bounds[n])) for n, v in null.items()}, bounds)


def nuisances_of(ranges: PushRanges) -> tuple[Candidate, ...]:
    """Numbers that are believed within an interval, at their pair of surfaces."""
    out = []
    for each in EFFECTS:
        known = each.push.nuisance(ranges) if "push" in each.kinds else None
        if known is not None:
            value, bounds = {known.parameter: known.value}, {known.parameter: (known.low, known.high)}
            start = {known.parameter: float(np.clip(known.value, known.low, known.high))}
            where = Place(pair=known.pair or SUPPORT_PAIR)
            out.append(Candidate(each, where, value, start, bounds, nuisance=True))
    return tuple(out)
