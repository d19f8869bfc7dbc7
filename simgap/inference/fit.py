"""Fits of model terms to residuals of roll-outs or of equations of motion: values, losses, intervals, p-values."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import accumulate, pairwise, product

import numpy as np
from scipy import stats

from schemas.arrays import FloatArray
from schemas.sim_gap.decisions import Reason
from simgap.inference.decision import Decision, Test, criterion, decide
from simgap.inference.robust_least_squares import (
    CAUCHY_SCALE,
    Prior,
    Solution,
    half_widths,
    leave_one_out_losses,
    minimise,
)
from simgap.problem import Candidate, Model, Problem, Term

Errors = Callable[[Model], Sequence[FloatArray]]  # one array per trial, in noise levels
ROUNDING_MARGIN = 1.0 + 1e-9  # an end of a range lies as far from none as it is known: rounding must not decide
_STRENGTHS = 9  # values of a strength tried before the local search
_MANY = 24  # values of one shape parameter; of two: _SHAPE_GRID
_SHAPE_GRID = (48, 6)
_WAVES = 120  # waves over a position: neighbours differ by about a radian at its ends
_PROBE = 0.05  # share of a strength's range at which its signature is read off
_CLIP = 1e4
_AT_BOUND_SHARE = 1e-6  # share of a range; a value this near an end counts as at it
_FEWEST_UNITS = 12


@dataclass(frozen=True)
class Fit:
    """Free terms with their solution."""

    free: tuple[Candidate, ...]
    solution: Solution

    @cached_property
    def model(self) -> Model:
        """All terms with their values, in the order of `free`."""
        return _model(self.free, self.solution.x)

    @property
    def losses(self) -> FloatArray:
        """(t,) loss per training trial."""
        return self.solution.losses

    @cached_property
    def held_out(self) -> FloatArray:
        """(t,) loss of each training trial under what the others teach."""
        return leave_one_out_losses(self.solution)

    @cached_property
    def half_widths(self) -> dict[str, dict[str, float]]:
        """Half 95 % intervals by key and parameter, SI; at the end of a range as sure as what set it, if that is."""
        return {
            c.key: {n: self._trial_half_widths[c.key][n] or c.direct_half_width.get(n, 0.0) for n in c.null}
            for c in self.free
        }

    @cached_property
    def _trial_half_widths(self) -> dict[str, dict[str, float]]:
        """Half widths from the trials alone: none of a value at the end of its range."""
        widths = half_widths(self.solution) if self.free else np.zeros(0)
        out: dict[str, dict[str, float]] = {c.key: {} for c in self.free}
        for (c, name), width in zip(_parameters(self.free), widths, strict=True):
            out[c.key][name] = float(width * (c.bounds[name][1] - c.bounds[name][0]))
        return out

    def strength_exceeds(self, least: Mapping[str, float]) -> Decision:
        """Kept if some strength of the last term differs from none by more than its interval and than `least`."""
        term, widths = self.model[-1], self.half_widths[self.free[-1].key]
        by_strength = [decide(_strength_tests(term, n, widths[n], least.get(n, 0.0))) for n in term.candidate.strengths]
        return next((d for d in by_strength if d.kept), max(by_strength, key=_progress))

    @property
    def p_value(self) -> float:
        """Of "the last term's strengths are none": Student's test over clusters, times the values that were tried.

        It tests whether the trials agree on a value, and sees far smaller effects than a comparison of losses, in which
        noise times effect stands beside the effect's square.
        """
        candidate = self.free[-1]
        term, widths, n = self.model[-1], self._trial_half_widths[candidate.key], len(self.losses)
        names = [name for name in candidate.strengths if widths[name] > 0.0]
        if not names or n < 2:
            return 1.0
        most = float(stats.t.ppf(0.975, n - 1))
        t = max(abs(term.values[name] - candidate.null[name]) / widths[name] * most for name in names)
        tried = len(names) * (_MANY if candidate.shapes else 1)
        return float(min(1.0, 2.0 * stats.t.sf(t, n - 1) * tried))

    @property
    def evaluations(self) -> int:
        """Calls of the residual function."""
        return self.solution.evaluations


def _strength_tests(term: Term, name: str, width: float, least: float) -> Iterator[Test]:
    """The criteria of one strength: beyond interval and `least`, with an interval that the trials or a bound gave."""
    value, (low, high) = term.values[name], term.candidate.bounds[name]
    reason = Reason.METHOD_BIAS if least > width else Reason.INTERVAL_INCLUDES_NONE
    distance = abs(value - term.candidate.null[name])
    yield reason, criterion(f"distance of {name} from no effect", distance, ">", ROUNDING_MARGIN * max(width, least))
    at_bound = min(value - low, high - value) <= _AT_BOUND_SHARE * (high - low)
    reason = Reason.BOUND_REACHED if at_bound else Reason.NOT_DETERMINED
    yield reason, criterion(f"half width of {name}", width, ">", 0.0)


def _progress(decision: Decision) -> tuple[int, float]:
    """How far a strength came: criteria met, then its distance from no effect over what it had to exceed."""
    first = decision.criteria[0]
    return len(decision.criteria), first.value / first.bound if first.bound > 0.0 else 0.0


def rollout_errors(problem: Problem, trials: Sequence[str], scale: FloatArray) -> Errors:
    """Residuals of short roll-outs over `scale` (c,), one array per cluster; missing ones count as 0."""

    def errors(model: Model) -> list[FloatArray]:
        residuals = problem.residuals(model, trials, "short_horizon")
        levels = np.nan_to_num(np.concatenate(residuals) / scale)
        ends = np.cumsum([len(r) for r in residuals])[:-1]
        return resampling_units(np.split(np.minimum(np.maximum(levels, -_CLIP), _CLIP), ends))

    return errors


def resampling_units(by_trial: Sequence[FloatArray]) -> list[FloatArray]:
    """Residual rows (k, c) as flat arrays, one per trial; few trials are cut into stretches as units instead."""
    parts = -(-_FEWEST_UNITS // len(by_trial))
    if parts <= 1:
        return [r.ravel() for r in by_trial]
    out = []
    for r in by_trial:
        ends = _ends(len(r), max(1, min(parts, len(r))))
        out += [r[a:b].ravel() for a, b in pairwise((0, *ends))]
    return out


@cache
def _ends(rows: int, parts: int) -> tuple[int, ...]:
    """Ends of stretches of nearly equal length; the first ones are longer by what is left."""
    each, left = divmod(rows, parts)
    return tuple(accumulate(each + (k < left) for k in range(parts)))


def robust_scale(problem: Problem, fitted: Model, trials: Sequence[str]) -> FloatArray:
    """(c,) size of what a model leaves of short roll-outs, outliers aside, at least the noise floor: one level."""
    rows = np.concatenate(problem.residuals(fitted, trials, "short_horizon"))
    least = problem.noise_floor(trials, "short_horizon") + 1e-15
    return np.maximum(1.4826 * np.nanmedian(np.abs(rows), axis=0), least)


def fit(errors: Errors, free: Sequence[Candidate], most: int = 8) -> Fit:
    """All of `free` together, from their own starts; deterministic."""
    free = tuple(free)
    start = _shares(free, {c.key: c.start for c in free})
    return Fit(
        free, minimise(lambda x: errors(_model(free, x)), start, most=most, steps=_steps(free), prior=_prior(free))
    )


def extend(
    errors: Errors, base: Fit, candidate: Candidate, starts: Sequence[Mapping[str, float]], most: int = 8
) -> Fit:
    """`base` with one term more, from the best of several starts of that term; the others move along.

    The Jacobian of the base's terms is reused. A nuisance that is the same number as the candidate is left out.
    """
    keep = [k for k, c in enumerate(base.free) if not is_twin(c, candidate)]
    free = (*(base.free[k] for k in keep), candidate)
    rows = [k for k, (c, _) in enumerate(_parameters(base.free)) if not is_twin(c, candidate)]
    others = base.solution.x[rows]
    tries = [np.concatenate([others, _shares((candidate,), {candidate.key: s})]) for s in starts]
    residuals = [errors(_model(free, x)) for x in tries]
    best = min(range(len(tries)), key=lambda k: _cost(residuals[k]))
    solution = minimise(
        lambda x: errors(_model(free, x)),
        tries[best],
        known=base.solution.jac[:, rows],
        at=residuals[best],
        most=most,
        starting=len(tries),
        steps=_steps(free),
        prior=_prior(free),
    )
    return Fit(free, solution)


def promising_starts(errors: Errors, base: Fit, candidate: Candidate) -> list[dict[str, float]]:
    """Starts for `extend`: the candidate's own, and the best of a coarse scan of its range.

    A strength whose signature has shape parameters enters linearly: its best value at each shape is a projection. A
    threshold does not, and has probes instead.
    """
    shapes = [n for n in candidate.null if n in candidate.shapes]
    model = tuple(t for t in base.model if not is_twin(t.candidate, candidate))
    starts = [
        dict(candidate.start),
        {**candidate.start, **{n: v for n, v in candidate.null.items() if n not in shapes}},
    ]
    if shapes and not candidate.extra_starts:
        return [*starts, *_best_shapes(errors, base, model, candidate, shapes)]
    scanned = [(_cost(errors((*model, Term(candidate, values)))), values) for values in candidate.extra_starts]
    for name, (low, high) in candidate.bounds.items():
        for share in np.linspace(0.02, 0.98, _STRENGTHS):
            values = {**candidate.start, name: low + float(share) * (high - low)}
            scanned.append((_cost(errors((*model, Term(candidate, values)))), values))
    return [*starts, min(scanned, key=lambda s: s[0])[1]]


def _best_shapes(
    errors: Errors, base: Fit, model: Model, candidate: Candidate, shapes: Sequence[str]
) -> list[dict[str, float]]:
    """The two best of a grid of shapes, each with its best strength.

    A wave's phase is no part of the grid: any phase is a sum of the waves at none and at a quarter turn.
    """
    strength = next(n for n in candidate.null if n not in shapes)
    low, high = candidate.bounds[strength]
    null = float(np.clip(candidate.null[strength], low, high))
    probe = _PROBE * ((high - null) if high - null >= null - low else (low - null))
    r0 = np.concatenate(base.solution.residuals)
    weight = 1.0 / np.sqrt(1.0 + (r0 / CAUCHY_SCALE) ** 2)
    rows = [k for k, (c, _) in enumerate(_parameters(base.free)) if not is_twin(c, candidate)]
    Q, _ = np.linalg.qr(base.solution.jac[:, rows] * weight[:, None])

    def beyond_base(column: FloatArray) -> FloatArray:
        column = weight * column
        return column - Q @ (Q.T @ column)

    def signature(values: dict[str, float]) -> FloatArray:
        moved = np.concatenate(errors((*model, Term(candidate, {**values, strength: null + probe}))))
        return beyond_base((moved - r0) / probe)

    y = beyond_base(r0)
    phase = candidate.effect.phase
    counts = (_WAVES,) if phase else (_MANY,) if len(shapes) == 1 else _SHAPE_GRID
    grids = [np.linspace(*candidate.bounds[n], k + 2)[1:-1] for n, k in zip(shapes, counts, strict=False)]
    scored = []
    for at in product(*grids):
        values = {**candidate.start, **dict(zip(shapes, (float(v) for v in at), strict=False))}
        phases = ({phase: 0.0}, {phase: 0.5 * np.pi}) if phase else ({},)
        columns = np.stack([signature({**values, **p}) for p in phases], axis=1)
        if (columns**2).sum() <= 1e-12:
            continue
        parts = -np.linalg.lstsq(columns, y, rcond=1e-6)[0]
        if phase:
            values[phase] = float(np.arctan2(parts[1], parts[0]))
            parts *= min(1.0, (high - null) / max(float(np.hypot(*parts)), 1e-300))
            value = null + float(np.hypot(*parts))
        else:
            value = float(np.clip(null + parts[0], low, high))
            parts = np.array([value - null])
        change = columns @ parts
        scored.append((2.0 * float(change @ y) + float(change @ change), {**values, strength: value}))
    return [values for _, values in sorted(scored, key=lambda s: s[0])[:2]]


def is_twin(term: Candidate, candidate: Candidate) -> bool:
    """Whether a nuisance is the same number as the candidate."""
    return term.nuisance and term.effect.name == candidate.effect.name and term.where == candidate.where


def _parameters(free: Sequence[Candidate]) -> list[tuple[Candidate, str]]:
    return [(c, n) for c in free for n in c.null]


def _steps(free: Sequence[Candidate]) -> FloatArray:
    return np.array([c.step for c, _ in _parameters(free)])


def _prior(free: Sequence[Candidate]) -> Prior:
    """Declared numbers are believed: a nuisance's range is two deviations to either side."""
    centre = _shares(free, {c.key: c.null for c in free})
    known = np.array([16.0 if c.nuisance else 0.0 for c, _ in _parameters(free)])
    return Prior(centre, known)


def _model(free: Sequence[Candidate], x: FloatArray) -> Model:
    values: dict[str, dict[str, float]] = {c.key: {} for c in free}
    for (c, name), share in zip(_parameters(free), x, strict=True):
        low, high = c.bounds[name]
        values[c.key][name] = float(low + share * (high - low))
    return tuple(Term(c, values[c.key]) for c in free)


def _shares(free: Sequence[Candidate], values: Mapping[str, Mapping[str, float]]) -> FloatArray:
    bounds = np.array([c.bounds[n] for c, n in _parameters(free)]).reshape(-1, 2)
    given = np.array([values[c.key][n] for c, n in _parameters(free)])
    return np.clip((given - bounds[:, 0]) / (bounds[:, 1] - bounds[:, 0]), 0.0, 1.0)


def _cost(residuals: Sequence[FloatArray]) -> float:
    return float(sum(np.log1p((r / CAUCHY_SCALE) ** 2).sum() for r in residuals))
