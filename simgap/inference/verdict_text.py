"""The text of a verdict: its status, one sentence a person can act on, and the experiment that would decide."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from schemas.sim_gap.extension import Interval
from schemas.sim_gap.report import AmbiguousGroup, Gain, NamedEffect
from simgap.inference.candidate_fit import CandidateFit

NAMED = 0.8  # the confidence from which a name is sure
_SMALL_SHARE = 0.0095  # share that whole per cent would hide
_FAR = 2.0  # noise levels of error beyond which a model without effects is no good one
STRANGE = (
    "The inputs do not belong to these motions: another trial's do as well or better. Check which file goes with which."
)


def status(
    certain: bool, groups: bool, unexplained: bool
) -> Literal["effect_found", "ambiguous", "outside_model_class", "no_effect"]:
    """The first that holds, in this order."""
    if certain:
        return "effect_found"
    if groups:
        return "ambiguous"
    return "outside_model_class" if unexplained else "no_effect"


def statement(
    gains: Sequence[Gain], named: Sequence[NamedEffect], groups: Sequence[AmbiguousGroup], unexplained: bool
) -> str:
    """One sentence a person can act on; `gains` (short roll-outs, whole ones) are of all effects, named or in doubt."""
    certain = [e for e in named if e.confidence >= NAMED]
    if certain:
        words = " and ".join(f"{e.name} at {e.where} ({_figures(e)})" for e in certain)
        doubted = ", with what is in doubt beside it" if len(certain) < len(named) else ""
        tail = "; something structured is left" if unexplained else ""
        return f"Add {words}: {gained(gains)}{doubted}{tail}."
    if groups and len(groups[0].effects) == 1:
        first = named[0]
        return (
            f"{first.name} at {first.where} is likely ({_figures(first)}), not sure: {gained(gains)}; "
            f"to decide: {groups[0].experiment}."
        )
    if groups:
        return (
            f"These data cannot tell {' from '.join(groups[0].effects)}: with what is in doubt, {gained(gains)}; "
            f"to tell: {groups[0].experiment}."
        )
    if unexplained:
        return "The error has structure that no effect of the library explains; see where it is."
    gain = gains[0]
    judges = "; a single trial judges that" if math.isinf(gain.ci95[0]) else ""
    if not gain.heldout_after <= _FAR:
        left = f"what is left (rms) is {gain.heldout_after:.2g} times the noise"
        return f"No effect of the library takes off error that repeats from trial to trial; {left}{judges}."
    return f"No effect is needed: nothing that is left repeats from trial to trial{judges}."


def gained(gains: Sequence[Gain]) -> str:
    """The change of held-out error as text, over short roll-outs and over whole ones; of events, which are short."""
    if gains[0].horizon_s == 0.0:
        return _change(gains[0], "", "events")
    over = [f"roll-outs of {g.horizon_s:.3g} s" if g.view == "short_horizon" else "whole roll-outs" for g in gains]
    if all(g.reduction > 0.0 for g in gains):
        first, *others = (share(g.reduction, g.ci95) for g in gains)
        return " and ".join(
            [f"{first} less held-out error over {over[0]}", *map("{} over {}".format, others, over[1:])]
        )
    return ", ".join(_change(g, f" over {words}", words) for g, words in zip(gains, over, strict=True))


def _change(gain: Gain, over: str, what: str) -> str:
    how_much = share(gain.reduction, gain.ci95)
    if gain.ci95[1] < 0.0:
        return f"{what} get worse, {how_much}"
    return (
        f"{how_much} less held-out error{over}" if gain.reduction > 0.0 else f"no less held-out error{over}, {how_much}"
    )


def share(value: float, ci95: Interval) -> str:
    """A share with its interval; one trial has none, and the lower end of what it leaves open is infinite."""
    low, high = ci95
    reach = "one trial: no interval" if math.isinf(low) else f"{_percent(low)} to {_percent(high)}"
    return f"{_percent(value)} ({reach})"


def _percent(value: float) -> str:
    """Whole, with one digit more below one; nothing has no sign."""
    text = f"{value:.1%}" if abs(value) < _SMALL_SHARE else f"{value:.0%}"
    return text.removeprefix("-") if float(text.rstrip("%")) == 0.0 else text


def _figures(effect: NamedEffect) -> str:
    seen = {n: e for n, e in effect.parameters.items() if e.ci95[0] < e.ci95[1]} or effect.parameters
    return ", ".join(f"{n} = {e.value:.3g}" for n, e in seen.items())


def experiment(accepted: CandidateFit, rivals: Sequence[CandidateFit], single: bool = False) -> str:
    """The library's experiments that distinguish the effect from its rivals; for a `single` trial, more trials."""
    names = {r.candidate.effect.name for r in rivals}
    experiments = [c.experiment for c in accepted.candidate.effect.confusables if c.effect in names]
    experiments += [
        c.experiment
        for r in rivals
        for c in r.candidate.effect.confusables
        if c.effect == accepted.candidate.effect.name
    ]
    if single:
        experiments = ["judge by two trials or more", *experiments]
    if not experiments:
        experiments = [c.experiment for c in accepted.candidate.effect.confusables[:1]]
    return "; ".join(dict.fromkeys(experiments)) or "more trials with larger and smaller motion"
