"""Candidate effects of a free body with bounds from its shapes, its motion and direct estimates; SI."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import Series
from sim.effects.effect import Effect
from sim.effects.library import EFFECTS
from sim.effects.ranges import SUPPORT_PAIR, TossRanges
from simgap.kinds.free_body.direct_estimates import agree_on_one_value
from simgap.kinds.free_body.toss import corners
from simgap.problem import Candidate, DirectEstimate

# Contacts begin and end at steps of the engine and in another order: slopes over less are those of single jumps.
_CONTACT_STEP, _NUISANCE_STEP = 0.02, 0.2
_COARSEST = 0.2
BOUNDS_ALPHA = 0.01  # level at which a direct estimate sets the bounds or replaces a fit
_BEYOND = 0.25  # share of a direct estimate above that level by which bounds exceed it
_SEEN, _LITTLE_OF_BOUNDS = 0.05, 0.02  # level of "something is there"; share of the bounds that is little
_LEAST_SPEED = 0.1  # sizes per fall time
Estimate = Callable[[Candidate], DirectEstimate | None]


def candidates_of(
    model: BodyModel, series: Sequence[Series], estimate_directly: Estimate | None = None
) -> tuple[Candidate, ...]:
    """Every effect of the library that poses of a free body can reveal, in library order.

    An effect whose direct estimate is clearly zero is left out; bounds of the others stay near their direct estimates,
    because fits to contacts stray.
    """
    size_m = float(np.ptp(corners(model.shapes), axis=0).max())
    ranges = TossRanges(model, typical_speed(series, size_m, model.gravity_W))
    return tuple(
        candidate
        for each in EFFECTS
        if "free_body" in each.kinds and each.free_body.observable(ranges)
        for candidate in screened(toss_candidate(each, _where(each), ranges), estimate_directly)
    )


def toss_candidate(each: Effect, where: Place, ranges: TossRanges) -> Candidate:
    """The candidate at a place with these ranges, before any direct estimate."""
    null = each.null() | each.free_body.null(ranges)
    bounds = {p.name: (p.low, p.high) for p in each.parameters} | each.free_body.bounds(ranges)
    start = {n: float(np.clip(v, *bounds[n])) for n, v in null.items()}
    return Candidate(each, where, null, start, bounds, shapes=each.shapes, step=_CONTACT_STEP)


def screened(wide: Candidate, estimate_directly: Estimate | None) -> tuple[Candidate, ...]:
    """The candidate, narrowed by its direct estimate where that sets bounds; nothing where it is clearly zero."""
    direct = estimate_directly(wide) if estimate_directly else None
    if direct is None:
        return (wide,)
    if absent(wide, direct):
        return ()
    return (with_direct_bounds(wide, direct) if wide.effect.free_body.bounds_from_direct else wide,)


def absent(wide: Candidate, direct: DirectEstimate) -> bool:
    """Whether the direct estimate sees nothing, and would see a small share of what is possible.

    Of several readings that contradict one another one is enough: what shrinks at rest and not in falls is no scale.
    """
    if direct.separate_readings:
        unseen = [absent(wide, one) for one in direct.separate_readings]
        return all(unseen) or (any(unseen) and not agree_on_one_value(direct.separate_readings))
    if direct.p_value < _SEEN:
        return False
    return all(
        abs(direct.values[n] - wide.null[n]) + 2.0 * direct.standard_errors[n] < _LITTLE_OF_BOUNDS * (high - low)
        for n, (low, high) in wide.bounds.items()
    )


def nuisances_of(model: BodyModel) -> tuple[Candidate, ...]:
    """Declared numbers of the pair within their tolerance."""
    known = [(e, n) for e in EFFECTS if "free_body" in e.kinds and (n := e.free_body.nuisance(model)) is not None]
    return tuple(
        Candidate(
            each,
            Place(pair=SUPPORT_PAIR),
            {n.parameter: n.value},
            {n.parameter: n.value},
            {n.parameter: (n.low, n.high)},
            nuisance=True,
            step=_NUISANCE_STEP,
        )
        for each, n in known
    )


def with_direct_bounds(wide: Candidate, direct: DirectEstimate) -> Candidate:
    """The candidate with bounds from no effect to the direct estimate, and beyond both no further than that errs.

    Fits to contacts stray: one that ends at such a bound is as sure as the estimate that set it, if that is sure at
    all; where it is not, bounds lie a little further.
    """
    bounds, half_widths, step = {}, {}, wide.step
    sure = direct.p_value < BOUNDS_ALPHA
    for name, (low, high) in wide.bounds.items():
        null, value = wide.null[name], direct.values[name]
        beyond = 4.0 * direct.standard_errors[name] + 0.002 * (high - low)
        if not sure:
            beyond += _BEYOND * abs(value - null)
        bounds[name] = (max(low, min(null, value) - beyond), min(high, max(null, value) + beyond))
        if bounds[name][0] >= bounds[name][1]:
            return wide
        if sure:
            half_widths[name] = beyond
        step = min(_COARSEST, wide.step * (high - low) / (bounds[name][1] - bounds[name][0]))
    return replace(wide, bounds=bounds, direct_half_width=half_widths, step=step)


def _where(each: Effect) -> Place:
    if each.family == "contact":
        return Place(pair=SUPPORT_PAIR)
    return Place(body="body") if each.family == "body" else Place()


def typical_speed(series: Sequence[Series], size_m: float, gravity_W: FloatArray) -> float:
    """Speed of the origin in m/s that one row of twenty exceeds; no less than a body so large falls in no time."""
    speeds = np.concatenate([np.linalg.norm(s.columns["v_W"], axis=1) for s in series])
    return max(float(np.quantile(speeds, 0.95)), _LEAST_SPEED * float(np.sqrt(size_m * np.linalg.norm(gravity_W))))
