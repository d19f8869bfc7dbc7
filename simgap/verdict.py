"""From evidence to an answer: an effect is named only when held-out gain and direct estimate agree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy import stats

from schemas.gap import AmbiguousGroup, Estimate, NamedEffect, Verdict
from simgap.numerics import Numerics
from simgap.problem import Candidate, DirectEstimate, Model, Problem, Term
from simgap.score import Comparison
from simgap.search import Selection
from simgap.told_apart import DIRECT_LEVEL, leads, told_apart
from simgap.tried import LEVEL, Trial

AGREE_ERRORS = 3.0
_LOOKS = 2.0  # at losses and at strengths, as on roll-outs
AGREE_SHARE = 0.5  # of the larger of the two: within a factor of two, either way
_TOLD = 3  # candidates that the direct route is asked about besides
_HELD = 1e-6  # a range so narrow holds a value, relative
NAMED = 0.8
Sides = dict[str, tuple[float, float]]  # how far an interval reaches below and above a value, by parameter
# What a model without names may still explain before we say that something else is there.
LEFTOVER = 0.1
_STRANGE = (
    "The inputs do not belong to these motions: another trial's do as well or better. Check which file goes with which."
)


def judge(
    problem: Problem,
    selection: Selection,
    trials: Sequence[str],
    leftover: Comparison,
    tails: float = 0.0,
    strange: bool = False,
) -> Verdict:
    """The verdict over all accepted effects; `leftover` compares the final model with a black box on top of it.

    `tails` is the share of its loss that lies in tails longer than noise has: what comes seldom, as play at reversals,
    no black box finds. Where the data are `strange`, nothing is sure: the inputs may be those of other motions.
    """
    unexplained = leftover.p_value < LEVEL and leftover.gain > LEFTOVER
    nameless = max(leftover.gain if unexplained else 0.0, tails)
    named: list[NamedEffect] = []
    groups: list[AmbiguousGroup] = []
    in_doubt: list[Candidate] = []
    base = selection.final.model
    doubted: list[list[Trial]] = [[] for _ in selection.accepted]
    for position, (found, rivals) in enumerate(zip(selection.accepted, selection.rivals, strict=True)):
        term, widths = _of(selection, position)
        if _stands(term, _even(widths)):  # Else effects found after it do its work.
            others = _without(base, found)
            doubted[position] = [r for r in rivals if not told_apart(problem, found, r, others, trials)]
    for position, (found, alike) in enumerate(zip(selection.accepted, doubted, strict=True)):
        term, widths = _of(selection, position)
        if not _stands(term, _even(widths)):
            continue
        others = _without(base, found)
        same = [*alike, *_preferred(problem, found, alike, others, selection.rounds[position].tried, trials)]
        said, agreed = _said_directly(problem, found, term, widths, others, trials, alone=len(doubted) == 1)
        direct = agreed and said is not None and _beyond(term, said, selection.numerics[position])
        wide = _wider(_wider(_even(widths), _even(_pressed(term))), _unsure(term, widths, said, doubted))
        # What may be nothing, by the interval that is reported, has no sure name; nor has what took a place of another
        # and would not have passed among all candidates by itself.
        p = min(p for t, p in zip(*_columns(selection, position), strict=True) if t is found)
        drowned = strange or p >= LEVEL or _removed(selection, position) < nameless or not _stands(term, wide)
        drowned = drowned or any(_left_by(found.candidate, other) for other in in_doubt)
        effect = NamedEffect(
            name=found.candidate.effect.name,
            where=found.candidate.where,
            confidence=_confidence(p, said, direct, bool(same) or drowned),
            routes={"heldout": True, "direct": direct},
            parameters=parameters(term, wide),
        )
        if same or drowned or not direct:
            in_doubt.append(found.candidate)
            names = tuple(dict.fromkeys([effect.name, *(r.candidate.effect.name for r in same)]))
            groups.append(AmbiguousGroup(effects=names, experiment=_experiment(found, same)))
        named.append(effect)
    certain = [e for e in named if e.confidence >= NAMED]
    return Verdict(
        status=_status(bool(certain), bool(groups), unexplained or strange),
        effects=tuple(named),
        ambiguous_groups=tuple(groups),
        statement=_statement(selection, named, groups, unexplained) if not strange else _STRANGE,
    )


def agrees(found: Trial) -> bool | None:
    """Whether the direct estimate says the same as the fit; None where there is no direct route."""
    if found.direct is None:
        return None
    return _agree(found.fit.model[-1], found.fit.half_widths[found.candidate.key], found.direct)


def _agree(term: Term, widths: dict[str, float], direct: DirectEstimate) -> bool:
    strength = _strength(term, widths)
    null, fitted = term.candidate.null[strength], term.values[strength]
    step = fitted - null
    apart = direct.values[strength] - fitted
    noise = float(np.hypot(direct.standard_errors[strength], widths.get(strength, 0.0) / 1.96))
    slack = max(AGREE_ERRORS * noise, AGREE_SHARE * max(abs(step), abs(direct.values[strength] - null)))
    one_way = step * (direct.values[strength] - null) > 0.0
    return _heard(direct, term.candidate, strength) and one_way and abs(apart) <= slack


def _said_directly(
    problem: Problem,
    found: Trial,
    term: Term,
    widths: dict[str, float],
    others: Model,
    trials: Sequence[str],
    alone: bool,
) -> tuple[DirectEstimate | None, bool]:
    """What the direct route says of an accepted effect beside the others, and whether that agrees with the fit.

    What is said is said of the final model: values move when causes are found that were not yet known. And a strength
    means something beside a shape only: torque at rest beside the speed at which it is gone.
    """
    said = found.direct
    if said is None or (alone and _agree(term, widths, said)):
        return said, said is not None
    said = problem.direct(found.candidate, others, trials)
    if said is None or _agree(term, widths, said) or not term.candidate.shapes:
        return said, said is not None and _agree(term, widths, said)
    pinned = problem.direct(_of_one_shape(term), others, trials)
    if pinned is None or not _agree(term, widths, pinned):
        return said, False
    return _shapes_of(said, pinned, term.candidate), True


def _heard(direct: DirectEstimate, candidate: Candidate, strength: str) -> bool:
    """Whether a direct estimate differs from none beyond chance: by trials held out, or by its error over trials.

    The second sees far smaller effects, as on roll-outs; it says nothing of a threshold, which is sharp anywhere.
    """
    error = direct.standard_errors[strength]
    if direct.p_value < DIRECT_LEVEL or candidate.probes or direct.trials < 2 or error <= 0.0:
        return direct.p_value < DIRECT_LEVEL
    t = abs(direct.values[strength] - candidate.null[strength]) / error
    return bool(_LOOKS * 2.0 * stats.t.sf(t, direct.trials - 1) < DIRECT_LEVEL)


def _shapes_of(free: DirectEstimate, pinned: DirectEstimate, candidate: Candidate) -> DirectEstimate:
    """What is said of strengths at one shape, and of shapes where nothing is held."""
    return replace(
        pinned,
        values={n: (free if n in candidate.shapes else pinned).values[n] for n in pinned.values},
        standard_errors={n: (free if n in candidate.shapes else pinned).standard_errors[n] for n in pinned.values},
    )


def _of_one_shape(term: Term) -> Candidate:
    """The candidate with its shape held as it was fitted: strengths of two routes then compare."""
    held = {n: (v - _HELD * (abs(v) + _HELD), v + _HELD * (abs(v) + _HELD)) for n, v in term.values.items()}
    bounds = {n: held[n] if n in term.candidate.shapes else b for n, b in term.candidate.bounds.items()}
    return replace(term.candidate, start=term.values, bounds=bounds)


def _preferred(
    problem: Problem, found: Trial, known: Sequence[Trial], others: Model, tried: Sequence[Trial], trials: Sequence[str]
) -> list[Trial]:
    """Other candidates of the round that the direct route prefers beyond chance: the two routes name different causes.

    One law that does the work of two on roll-outs seldom balances the equations of motion as well.
    """
    if found.direct is None or found.direct.held_out is None:
        return []
    own = problem.direct(found.candidate, others, trials)
    if own is None:
        return []
    taken = {found.candidate.key, *(t.candidate.key for t in known), *(t.candidate.key for t in others)}
    left = [
        (float(t.direct.held_out.sum()), t.candidate.key, t)
        for t in tried
        if t.candidate.key not in taken and t.direct is not None and t.direct.held_out is not None
    ]
    out = []
    for _, _, rival in sorted(left, key=lambda entry: entry[:2])[:_TOLD]:
        theirs = problem.direct(rival.candidate, others, trials)
        if theirs is not None and leads(theirs, own) is True:
            out.append(rival)
    return out


def _removed(selection: Selection, position: int) -> float:
    """Loss that an accepted effect took away, as a share of what is left in the end.

    Beside structure that nothing explains an effect must be the larger of the two: what is wrong with the model repeats
    from trial to trial like a cause, wherever trials move alike.
    """
    gains = [t.comparison.gain for t in selection.accepted[position:]]
    return float(gains[0] / max(np.prod([1.0 - g for g in gains]), 1e-12))


def _of(selection: Selection, position: int) -> tuple[Term, dict[str, float]]:
    """An accepted effect in the final model, and half the width of its intervals, numerics included."""
    key = selection.accepted[position].candidate.key
    term = next(t for t in selection.final.model if t.candidate.key == key)
    least = selection.numerics[position].fitted
    return term, {n: max(w, least.get(n, 0.0)) for n, w in selection.final.half_widths.get(key, {}).items()}


def _without(model: Model, found: Trial) -> Model:
    return tuple(t for t in model if t.candidate.key != found.candidate.key)


def _unsure(
    term: Term, widths: Mapping[str, float], direct: DirectEstimate | None, rivals: Sequence[Sequence[Trial]]
) -> Sides:
    """How far values lie from those beside rivals of the other effects, and from the direct estimate, either way.

    Where that lies beyond `widths`, either route may be the right one: its own interval counts too.
    """
    others = [t.values for each in rivals for r in each for t in r.fit.model if t.candidate.key == term.candidate.key]
    out: Sides = {}
    for n, value in term.values.items():
        ends = [o[n] for o in others]
        if direct is not None:
            apart = abs(direct.values[n] - value) > widths.get(n, 0.0)
            own = 1.96 * direct.standard_errors[n] if apart else 0.0
            ends += [direct.values[n] - own, direct.values[n] + own]
        out[n] = (max([0.0, *(value - e for e in ends)]), max([0.0, *(e - value for e in ends)]))
    return out


def _even(widths: Mapping[str, float]) -> Sides:
    return {n: (w, w) for n, w in widths.items()}


def _wider(sides: Sides, least: Sides) -> Sides:
    """Of either, how far it reaches below and above."""
    none = (0.0, 0.0)
    both = {n: (sides.get(n, none), least.get(n, none)) for n in {**sides, **least}}
    return {n: (max(a[0], b[0]), max(a[1], b[1])) for n, (a, b) in both.items()}


def _left_by(candidate: Candidate, earlier: Candidate) -> bool:
    """Whether an effect may be no more than what a law in doubt leaves: one that does nearly the same, at one place."""
    doubles = {c.effect for c in earlier.effect.confusables}
    kin = candidate.effect.name in doubles or earlier.effect.name in {c.effect for c in candidate.effect.confusables}
    return kin and candidate.where == earlier.where


def _pressed(term: Term) -> dict[str, float]:
    """Half of how far motion went beyond each threshold: one that yields more and more begins so much earlier.

    A joint pressed to a depth d into a stop of a force that grows as its depth to the power n looks as if a linear one
    began up to d (1 - 1/n) later.
    """
    beyond = {n: far - term.values[n] for n, far in term.candidate.reached.items()}
    return {n: 0.5 * abs(d) for n, d in beyond.items() if d * (term.candidate.null[n] - term.values[n]) > 0.0}


def _beyond(term: Term, direct: DirectEstimate, made_up: Numerics) -> bool:
    """Whether the direct route sees more of some strength than it makes up where there is none."""
    null = term.candidate.null
    return not made_up.direct or any(abs(direct.values[n] - null[n]) > least for n, least in made_up.direct.items())


def _stands(term: Term, sides: Sides) -> bool:
    """Whether some strength still differs from none in the final model: whether none lies outside its interval."""
    for n, value in term.values.items():
        none, (below, above) = term.candidate.null[n], sides.get(n, (0.0, 0.0))
        least = max(below if value > none else above, 1e-9 * abs(none), 1e-12)
        if n not in term.candidate.shapes and abs(value - none) > least:
            return True
    return False


def _strength(term: Term, widths: dict[str, float]) -> str:
    """The parameter that says most clearly that the effect is there: a stop may be touched on one side only."""
    fitted, null = term.values, term.candidate.null
    names = [n for n in null if n not in term.candidate.shapes]
    return max(names, key=lambda n: abs(fitted[n] - null[n]) / widths[n] if widths.get(n, 0.0) > 0.0 else 0.0)


def parameters(term: Term, sides: Sides) -> dict[str, Estimate]:
    """Values with units and 95 % intervals."""
    units = {p.name: p.unit for p in term.candidate.effect.parameters}
    reach = {n: sides.get(n, (0.0, 0.0)) for n in term.values}
    return {
        n: Estimate(value=value, unit=units[n], ci95=(value - reach[n][0], value + reach[n][1]))
        for n, value in term.values.items()
    }


def _columns(selection: Selection, position: int) -> tuple[tuple[Trial, ...], tuple[float, ...]]:
    this = selection.rounds[position]
    return this.tried, this.p_adjusted


def _confidence(p_adjusted: float, direct: DirectEstimate | None, agreed: bool, shared: bool) -> float:
    """At least `NAMED` with both routes and no rival; at most one half else."""
    if shared or not agreed or direct is None:
        return 0.5 * (1.0 - p_adjusted) / (2.0 if shared and not agreed else 1.0)
    return float(NAMED + (1.0 - NAMED) * (1.0 - min(1.0, p_adjusted / LEVEL)) * (1.0 - min(1.0, direct.p_value)))


def _experiment(found: Trial, rivals: Sequence[Trial]) -> str:
    """What would tell the effect from its rivals, from their own files."""
    names = {r.candidate.effect.name for r in rivals}
    told = [c.experiment for c in found.candidate.effect.confusables if c.effect in names]
    told += [
        c.experiment for r in rivals for c in r.candidate.effect.confusables if c.effect == found.candidate.effect.name
    ]
    if not told:
        told = [c.experiment for c in found.candidate.effect.confusables[:1]]
    return "; ".join(dict.fromkeys(told)) or "more trials with larger and smaller motion"


def _status(certain: bool, groups: bool, unexplained: bool):
    if certain:
        return "effect_found"
    if groups:
        return "ambiguous"
    return "outside_model_class" if unexplained else "no_effect"


def _statement(
    selection: Selection, named: Sequence[NamedEffect], groups: Sequence[AmbiguousGroup], unexplained: bool
) -> str:
    """One sentence a person can act on."""
    certain = [e for e in named if e.confidence >= NAMED]
    share = 1.0 - np.sqrt(selection.final_losses.sum() / max(selection.null_losses.sum(), 1e-300))
    if certain:
        words = " and ".join(f"{e.name} at {e.where} ({_figures(e)})" for e in certain)
        tail = "; something structured is left" if unexplained else ""
        return f"Add {words}: {share:.0%} of the held-out error goes away{tail}."
    if groups:
        return f"These data cannot tell {' from '.join(groups[0].effects)}; to tell: {groups[0].experiment}."
    if unexplained:
        return "The error has structure that no effect of the library explains; see where it is."
    return "No effect is needed: what is left looks like noise."


def _figures(effect: NamedEffect) -> str:
    seen = {n: e for n, e in effect.parameters.items() if e.ci95[0] < e.ci95[1]} or effect.parameters
    return ", ".join(f"{n} = {e.value:.3g}" for n, e in seen.items())
