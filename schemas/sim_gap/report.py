"""`report.json`: the verdict of a search with the evidence for it."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from schemas.sim_gap.decisions import CandidateDecision, Reason
from schemas.sim_gap.extension import Estimate, Interval, Machine, Place


class ConventionCheck(Machine):
    """One simulator convention that was checked before any physics was blamed."""

    name: str
    status: Literal["ok", "fixed", "suspect"]
    evidence: str


class Localisation(Machine):
    """A phase, band or axis that clearly holds more error than its share of the readings.

    contrast   error of a reading inside over that of one outside: in the rest of the axis, or in other axes.
    """

    what: str
    share_of_error: float
    share_of_time: float | None = None
    first_divergence_s: float | None = None
    phase: str = ""
    axis: str = ""
    noise_ratio: float | None = None
    contrast: float | None = None


class Hypothesis(Machine):
    """One candidate effect and the evidence for it."""

    name: str
    where: Place = Place()
    heldout_gain: float
    ci95: Interval
    p_adjusted: float
    delta_bic: float
    direct: dict[str, Estimate] = Field(default_factory=dict)
    direct_agrees: bool | None = None  # None: there is no direct route in these data


class EffectTwin(Machine):
    """Another effect that imitates one: separable from it only at `factor` times the strength that is noticed."""

    name: str
    where: Place = Place()
    factor: float


class IdentifiableEffect(Machine):
    """What the training trials show of an effect beside the declared model, whether or not it acts.

    noticed_from   strengths from which it is noticed, of thresholds such at which it is; empty where these trials show
                   it at no plausible strength.
    twins          effects that imitate it here, the best imitation first.
    """

    name: str
    where: Place = Place()
    noticed_from: dict[str, float]
    twins: tuple[EffectTwin, ...] = ()


class NamedEffect(Machine):
    """An effect that the verdict names."""

    name: str
    where: Place = Place()
    confidence: float = Field(ge=0.0, le=1.0)
    routes: dict[str, bool]
    parameters: dict[str, Estimate]


class AmbiguousGroup(Machine):
    """Effects that these data cannot distinguish, and the experiment that would."""

    effects: tuple[str, ...]
    experiment: str


class Verdict(Machine):
    """The answer. `no_effect` and `ambiguous` are answers of equal rank."""

    status: Literal["effect_found", "no_effect", "ambiguous", "outside_model_class"]
    effects: tuple[NamedEffect, ...] = ()
    ambiguous_groups: tuple[AmbiguousGroup, ...] = ()
    statement: str


class Gain(Machine):
    """Held-out error before (null refit) and after (extended model)."""

    view: Literal["short_horizon", "full_rollout"]
    horizon_s: float
    metric: str
    heldout_before: float
    heldout_after: float
    reduction: float
    ci95: Interval
    noise_floor: float
    gap_closed: float


class RolloutEngine(Machine):
    """What rolled models out: its name with version, its method in words, its longest step (s); None without steps."""

    name: str
    method: str
    step_s: float | None = None


class EngineDifference(Machine):
    """One joint of the declared mechanism, rms in `unit` over whole trials; infinite where a roll-out is no number.

    between_engines         the engine's roll-out at the user's step against ours: the engine's part of the gap.
    between_at_finer_step   the same at a quarter of that step; what is gone from it was the step's part.
    ours_to_recording, engine_to_recording   each roll-out against the readings: the whole gap.
    """

    channel: str
    unit: str
    between_engines: float
    between_at_finer_step: float | None = None
    ours_to_recording: float
    engine_to_recording: float


class EngineComparison(Machine):
    """The declared mechanism in the user's engine at the user's step, over these whole held-out trials.

    failure   why trials are missing; empty where none is.
    """

    engine: RolloutEngine
    trials: tuple[str, ...] = ()
    differences: tuple[EngineDifference, ...] = ()
    failure: str = ""


class Baseline(Machine):
    """Errors of the current model without any change."""

    metrics: dict[str, Estimate]


class Rival(Machine):
    """A way without names, for comparison."""

    name: str
    heldout: float


class GapReport(Machine):
    """`report.json` of `mana gap find`."""

    schema_version: Literal[1] = 1
    measurement: str  # hash of the folder's content
    measurement_name: str = ""
    n_train: int
    n_test: int
    wall_s: float
    traps: tuple[ConventionCheck, ...] = ()
    rollout: RolloutEngine | None = None  # of the declared model and all others
    engine_comparison: EngineComparison | None = None  # of mechanisms
    baseline: Baseline
    localisation: tuple[Localisation, ...] = ()
    identifiable: tuple[IdentifiableEffect, ...] = ()  # of mechanisms
    hypotheses: tuple[Hypothesis, ...] = ()
    verdict: Verdict
    gains: tuple[Gain, ...] = ()
    gain: Gain | None = None
    baselines: tuple[Rival, ...] = ()
    ladder: tuple[Rival, ...] = ()  # declared, null refit, each effect added, noise: held-out rms
    decisions: tuple[CandidateDecision, ...] = ()  # in the order in which they were made
    reason_counts: dict[Reason, int] = Field(default_factory=dict[Reason, int])  # decisions by reason
    extension: str = "extension.json"
