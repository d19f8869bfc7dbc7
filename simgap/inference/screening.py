"""One round of a search: every candidate alone on top of a base, quickly, and the promising ones to the end."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from simgap.inference.candidate_fit import Map, Round, Trial, round_of, told_loss, tried_on, warm
from simgap.inference.competing_hypotheses import RIVAL_SHARE
from simgap.inference.fit import Errors, Fit, extend, fit, promising, rollout_errors, spread
from simgap.inference.losses import Comparison
from simgap.inference.search_state import Standpoint
from simgap.problem import Candidate, Farsighted

_FINALISTS = 6
_TOLD = 3  # finalists by direct estimates
_SHOWS = 0.3  # chance below which a quick look is followed by a long one
_SCREEN_STEPS = 2
_SETTLING = 2  # times that a threshold's fit is taken up again with starts seen from it
_NOT_JUDGED = Comparison(0.0, (0.0, 0.0), 1.0)


def try_all(here: Standpoint, free: Iterable[Candidate], each: Map) -> Round:
    """All of `free` on top of the base, best first; `each` maps trials, over processes or not.

    Where effects are judged on long horizons, short ones are enough to see which are worth those.
    """
    farther = here.view != "short_horizon"
    errors, base = _nearby(here) if farther else (here.errors, here.base)
    return _to_the_end(here, list(each(_screening(here, errors, base), free)), farther, each)


def _nearby(here: Standpoint) -> tuple[Errors, Fit]:
    """The base on short horizons."""
    problem, train = here.problem, here.trials.train
    level = spread(problem, here.base.model, train, "short_horizon")
    errors = rollout_errors(problem, train, "short_horizon", level)
    return errors, fit(errors, warm(here.base))


def _screening(here: Standpoint, errors: Errors, base: Fit) -> Callable[[Candidate], Trial]:
    """A quick trial of one candidate: from where the direct estimate points, a step or two."""

    def tried(candidate: Candidate) -> Trial:
        direct = here.problem.direct(candidate, base.model, here.trials.train)
        if direct is None and isinstance(here.problem, Farsighted):
            starts = [dict(candidate.start)]  # Its direct route scans the whole range and found no trace.
        elif direct is None:
            starts = promising(errors, base, candidate)
        else:
            none = {n: candidate.null[n] for n in candidate.strengths}
            starts = [direct.values, {**direct.values, **none}]
        return tried_on(base, extend(errors, base, candidate, starts, _SCREEN_STEPS), direct)

    return tried


def _to_the_end(here: Standpoint, screened: list[Trial], farther: bool, each: Map) -> Round:
    """The most promising ones, by their quick trial or by their direct estimate, fitted to the end; best first.

    Where both say that chance does as well, no more is asked. What was screened on shorter horizons than it is judged
    on (`farther`) and is no finalist has not been judged: it counts as no gain.
    """
    order = sorted(screened, key=lambda t: (-t.comparison.gain, t.candidate.key))
    told = sorted(order, key=told_loss)
    finalists = {t.candidate.key: t for t in (*order[:_FINALISTS], *told[:_TOLD]) if _shows(t)}

    def tried(candidate: Candidate) -> Trial:
        quick = finalists[candidate.key]
        return tried_on(here.base, extend(here.errors, here.base, candidate, _begun(quick)), quick.direct)

    fits = list(each(tried, [t.candidate for t in order if t.candidate.key in finalists]))
    others = [t for t in order if t.candidate.key not in finalists]
    unjudged = [replace(t, comparison=_NOT_JUDGED, delta_bic=0.0) if farther else t for t in others]
    return round_of([*(_seen_by_themselves(here, fits) if farther else fits), *unjudged])


def _shows(found: Trial) -> bool:
    direct = 1.0 if found.direct is None else found.direct.p_value
    return min(direct, found.comparison.p_value) < _SHOWS


def _begun(found: Trial) -> list[dict[str, float]]:
    """Where a fit to the end begins: the quick fit and the direct estimate, of a threshold also halfway to none.

    No descent leads far along a threshold, and a law that is nearly right asks for less on longer roll-outs.
    """
    quick, none = found.fit.model[-1].values, found.candidate.null
    starts = [quick] if found.direct is None or found.direct.values == quick else [quick, found.direct.values]
    if found.candidate.probes:
        starts.append({**quick, **{n: 0.5 * (none[n] + quick[n]) for n in found.candidate.strengths}})
    return starts


def _seen_by_themselves(here: Standpoint, finalists: list[Trial]) -> list[Trial]:
    """Finalists, thresholds among them seen from their own models, and so are all that come near one of those.

    After a blow nothing of what a start does is as it was without one: starts that were taken where nothing was met
    would blame the threshold for what noise does. Where others compete, they are owed the same.
    """
    near = [_settled(here, t) if t.candidate.probes else t for t in finalists]
    best = max((t.comparison.gain for t in near if t.candidate.probes), default=1.0)
    rivals = [not t.candidate.probes and t.comparison.gain > RIVAL_SHARE * best for t in near]
    return [_settled(here, t) if rival else t for t, rival in zip(near, rivals, strict=True)]


def _settled(here: Standpoint, found: Trial) -> Trial:
    """A candidate's fit taken up again, with starts as they are where its own model leads."""
    fitted = found.fit
    for _ in range(_SETTLING):
        again = fit(here.seen_from(fitted.model), warm(fitted))
        if again.losses.sum() >= fitted.losses.sum():
            break
        fitted = again
    return found if fitted is found.fit else tried_on(here.base, fitted, found.direct)
