"""What recordings can show: from which strength on an effect is noticed, and how much stronger it must be to be
distinguished from another one.

From a fitted model and probes of each candidate to the information that the trials hold on their strengths, with the
trials' starts and the model's own parameters eliminated. Column c is the change of the errors by candidate c at a
probe; G = C' C in squared noise levels is the information. A rival d, its size free, leaves the share

    r^2 = 1 - G_cd^2 / (G_cc G_dd)

of c's changes. With a loss of D an effect is noticed from sqrt(D / G_cc) probes on, and distinguished from d from
1 / r times that on. Near-null directions of G, 1 / r far above one, are the groups that these trials cannot separate.
A law of several strengths has several columns; of its directions that counts which the rival imitates best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy import stats

from schemas.arrays import BoolArray, FloatArray
from schemas.sim_gap.report import EffectTwin, IdentifiableEffect
from simgap.problem import Candidate, Model, Term, TrialSystem
from simgap.whole_trials.fit_model import ModelFit
from simgap.whole_trials.linearisation import Linearisation, inverse_of, linearise
from simgap.whole_trials.parameter_space import Space, vector_of
from simgap.whole_trials.policy import Policy
from simgap.whole_trials.score_test import ProbedModel, Score

_UNSEEN = 1e-12  # squared noise levels below which a probe changes nothing
_LEAST_SHARE = 1e-12  # of squared changes: rounding errors of slopes


@dataclass(frozen=True)
class Probe:
    """Changes of the errors (t, n, k) by a candidate at k sets of values near none, without weights."""

    candidate: Candidate
    values: tuple[dict[str, float], ...]
    changes: FloatArray

    @staticmethod
    def of(probed: ProbedModel, candidate: Candidate, values: tuple[dict[str, float], ...]) -> Probe:
        """The changes beside a model."""
        return Probe(candidate, values, np.stack([probed.change(Term(candidate, v)) for v in values], axis=2))


@dataclass(frozen=True)
class Information:
    """On the sizes of probes: `matrix` with the columns `blocks` of each."""

    matrix: FloatArray
    blocks: tuple[slice, ...]

    @staticmethod
    def of(base: Linearisation, prior: FloatArray, probes: Sequence[Probe]) -> Information:
        """With starts and the parameters of `base` eliminated; `prior` (p,) is the precision of these."""
        return Information.of_total(total_information(base, probes), prior, probes)

    @staticmethod
    def of_total(total: FloatArray, prior: FloatArray, probes: Sequence[Probe]) -> Information:
        """The same from a sum over recordings of `total_information`."""
        ends = np.cumsum([0, *(p.changes.shape[2] for p in probes)])
        blocks = tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
        own = len(prior)
        nuisance, mixed = total[:own, :own] + np.diag(prior), total[:own, own:]
        left = total[own:, own:] - mixed.T @ inverse_of(nuisance) @ mixed if own else total
        return Information(left, blocks)

    def size(self, number: int) -> float:
        """Squared noise levels that a probe changes, in the direction of its strengths that shows most."""
        block = self.matrix[self.blocks[number], self.blocks[number]]
        return max(float(np.linalg.eigvalsh(block)[-1]), 0.0)

    def share_beside(self, number: int, rival: int) -> float:
        """The share r^2 of its squared changes that a rival of free size leaves; 1 where one of both changes none."""
        if min(self.size(number), self.size(rival)) <= _UNSEEN:
            return 1.0
        own, other = self.blocks[number], self.blocks[rival]
        mixed = self.matrix[own, other]
        left = self.matrix[own, own] - mixed @ inverse_of(self.matrix[other, other]) @ mixed.T
        values, vectors = np.linalg.eigh(self.matrix[own, own])
        seen = values > _UNSEEN * values[-1]
        whiten = vectors[:, seen] / np.sqrt(values[seen])
        return float(np.clip(np.linalg.eigvalsh(whiten.T @ left @ whiten)[0], _LEAST_SHARE, 1.0))

    def left_by(self, number: int, rival: int) -> float:
        """Squared noise levels that a rival of free size leaves of what a probe changes."""
        return self.size(number) * self.share_beside(number, rival)


def total_information(base: Linearisation, probes: Sequence[Probe]) -> FloatArray:
    """(p + k, p + k) on the parameters of `base` and the sizes of probes, summed over trials, starts eliminated."""
    columns = np.concatenate([p.changes for p in probes], axis=2)
    return base.with_parameters(columns).reduced_equations().information.sum(axis=0)


def probes_of(probed: ProbedModel, scores: Sequence[Score]) -> tuple[Probe, ...]:
    """The probes that gave each candidate its score beside a model, by the candidates' names."""
    ordered = sorted(scores, key=lambda score: score.candidate.key)
    return tuple(Probe.of(probed, score.candidate, score.probed) for score in ordered)


def identifiable(
    system: TrialSystem, fit: ModelFit, scores: Sequence[Score], policy: Policy
) -> tuple[IdentifiableEffect, ...]:
    """What the trials show of every candidate beside a fitted model, in the order of their names."""
    if not scores:
        return ()
    probes = probes_of(ProbedModel.of(system, fit.model, fit.starts), scores)
    space = Space.of(fit.model)
    inside = space.inside(vector_of(fit.model))
    base = linearise(system, fit.model, fit.starts).only(inside)
    information = Information.of(base, (space.prior_precision * space.span**2)[inside], probes)
    by_chance = float(stats.chi2.isf(0.5 * policy.alpha / len(probes), 1)) * fit.dispersion
    enough = max(by_chance, policy.least_gain * float(fit.rows.sum()))
    return tuple(_identifiable(information, probes, number, enough, policy) for number in range(len(probes)))


def _identifiable(
    information: Information, probes: Sequence[Probe], number: int, enough: float, policy: Policy
) -> IdentifiableEffect:
    probe = probes[number]
    factors = {k: information.share_beside(number, k) ** -0.5 for k in range(len(probes)) if k != number}
    same = sorted((k for k, f in factors.items() if f >= policy.twin), key=lambda k: (-factors[k], k))
    rivals = [(probes[k].candidate, factors[k]) for k in same]
    return IdentifiableEffect(
        name=probe.candidate.effect.name,
        where=probe.candidate.where,
        noticed_from=_noticed_from(probe, information.size(number), enough),
        twins=tuple(EffectTwin(name=c.effect.name, where=c.where, factor=factor) for c, factor in rivals),
    )


def _noticed_from(probe: Probe, size: float, enough: float) -> dict[str, float]:
    """Strengths at which so many squared noise levels change, for a probe that changes `size`; empty beyond bounds.

    Changes grow with strengths; those of thresholds do not, so that these count where they were probed, or not at all.
    """
    candidate, values = probe.candidate, probe.values[0]
    if size <= _UNSEEN:
        return {}
    if candidate.extra_starts:
        return {n: values[n] for n in candidate.strengths} if size >= enough else {}
    times = float(np.sqrt(enough / size))
    moved = [n for n in candidate.strengths if values[n] != candidate.null[n]]
    strengths = {n: float(candidate.null[n] + times * (values[n] - candidate.null[n])) for n in moved}
    inside = all(candidate.bounds[n][0] <= v <= candidate.bounds[n][1] for n, v in strengths.items())
    return strengths if inside else {}


def removal(linear: Linearisation, model: Model, term: Term) -> Probe:
    """What the errors change, to first order, by an effect of a model: the slopes in its strengths times these."""
    vector, space = vector_of(model), Space.of(model)
    own = owned_by(model, term)
    nulls = np.array(list(term.candidate.null.values()))
    strong = np.array([n in term.candidate.strengths for n in term.values])
    away = np.where(strong, vector[own] - nulls, 0.0) / space.span[own]
    change = (linear.parameter_slopes[..., own] @ away) / np.sqrt(linear.weight)[:, None]
    return Probe(term.candidate, (term.values,), change[..., None])


def owned_by(model: Model, term: Term) -> BoolArray:
    """(p,) which parameters of a model are those of one of its terms."""
    return np.array([t.candidate.key == term.candidate.key for t in model for _ in t.values], dtype=bool)


def enough_to_reject(fit: ModelFit, policy: Policy) -> float:
    """The loss that a rival must leave for the confidence set to reject it."""
    by_chance = float(stats.chi2.isf(0.5 * policy.rejection_alpha, 1)) * fit.dispersion
    return max(by_chance, policy.least_lead * float(fit.rows.sum()))


def twins(
    system: TrialSystem, fit: ModelFit, scores: Sequence[Score], policy: Policy
) -> dict[str, tuple[Candidate, ...]]:
    """By key of each effect of a model: candidates that would explain what it explains, as far as these trials show.

    `scores` are those of candidates beside the model. A twin is so like the effect that only one `policy.twin` times
    what is noticed separates the two, and leaves of G, what the effect takes off, the loss r^2 G: too little for the
    confidence set to reject it.
    """
    space, inside = Space.of(fit.model), Space.of(fit.model).inside(vector_of(fit.model))
    linear = linearise(system, fit.model, fit.starts)
    rivals = probes_of(ProbedModel.of(system, fit.model, fit.starts), scores)
    enough = enough_to_reject(fit, policy)
    out: dict[str, tuple[Candidate, ...]] = {}
    for term in fit.effects:
        kept = inside & ~owned_by(fit.model, term)
        probes = (removal(linear, fit.model, term), *rivals)
        information = Information.of(linear.only(kept), (space.prior_precision * space.span**2)[kept], probes)
        out[term.candidate.key] = tuple(
            rival.candidate
            for k, rival in enumerate(rivals, 1)
            if information.share_beside(0, k) <= policy.twin**-2 and information.left_by(0, k) < enough
        )
    return out
