"""What a verdict says in words: its status, one sentence a person can act on, and the experiment that would tell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from schemas.gap import AmbiguousGroup, NamedEffect
from simgap.search import Selection
from simgap.tried import Trial

NAMED = 0.8  # the confidence from which a name is sure
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
    selection: Selection, named: Sequence[NamedEffect], groups: Sequence[AmbiguousGroup], unexplained: bool
) -> str:
    """One sentence a person can act on."""
    certain = [e for e in named if e.confidence >= NAMED]
    share = 1.0 - np.sqrt(selection.final_losses.sum() / max(selection.null_losses.sum(), 1e-300))
    if certain:
        words = " and ".join(f"{e.name} at {e.where} ({_figures(e)})" for e in certain)
        doubted = ", with what is in doubt beside it" if len(certain) < len(named) else ""
        tail = "; something structured is left" if unexplained else ""
        return f"Add {words}: {share:.0%} of the held-out error goes away{doubted}{tail}."
    if groups and len(groups[0].effects) == 1:
        first = named[0]
        return (
            f"{first.name} at {first.where} is likely ({_figures(first)}), not sure; to decide: {groups[0].experiment}."
        )
    if groups:
        return f"These data cannot tell {' from '.join(groups[0].effects)}; to tell: {groups[0].experiment}."
    if unexplained:
        return "The error has structure that no effect of the library explains; see where it is."
    return "No effect is needed: nothing that is left repeats from trial to trial."


def _figures(effect: NamedEffect) -> str:
    seen = {n: e for n, e in effect.parameters.items() if e.ci95[0] < e.ci95[1]} or effect.parameters
    return ", ".join(f"{n} = {e.value:.3g}" for n, e in seen.items())


def experiment(found: Trial, rivals: Sequence[Trial]) -> str:
    """What would tell the effect from its rivals, from their own files."""
    names = {r.candidate.effect.name for r in rivals}
    told = [c.experiment for c in found.candidate.effect.confusables if c.effect in names]
    told += [
        c.experiment for r in rivals for c in r.candidate.effect.confusables if c.effect == found.candidate.effect.name
    ]
    if not told:
        told = [c.experiment for c in found.candidate.effect.confusables[:1]]
    return "; ".join(dict.fromkeys(told)) or "more trials with larger and smaller motion"
