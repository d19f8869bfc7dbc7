"""Outputs of simgap: the report and the model extension, SI units (design: sim gap contract; extend, never rename)."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from enum import StrEnum
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

Interval = tuple[float, float]
Relation = Literal["<", "<=", ">", ">="]
Step = Literal["screen", "confirm", "compare", "judge"]
_HOLDS: Mapping[Relation, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


class Reason(StrEnum):
    """Why a candidate passed or failed a test; those that end in a preposition are followed by another candidate."""

    PASSED = "passed"
    NAMED = "named"
    NOT_PROMISING = "not promising"
    OUTRANKED = "outranked"
    NOT_SIGNIFICANT = "not significant"
    TOO_SMALL = "too small"
    INTERVAL_INCLUDES_NONE = "interval includes no effect"
    BOUND_REACHED = "bound reached"
    NOT_DETERMINED = "not determined by the trials"
    MAKES_VANISH = "replaces rather than adds to"
    TEST_TRIALS_WORSE = "test trials worse"
    METHOD_BIAS = "method bias"
    ACCEPTED_AFTER = "ranked after"
    FITS_WORSE_THAN = "fits worse than"
    EXPLAINS_LESS_THAN = "explains less than"
    MORE_PARAMETERS_THAN = "no better with more parameters than"
    INCOMPLETE_WITHOUT = "incomplete without"
    INSEPARABLE_FROM = "inseparable from"
    REPLACED_BY = "replaced by"
    NO_LONGER_NEEDED = "no longer needed"
    MIMICKED_BY = "mimicked by"
    NO_DIRECT_ESTIMATE = "no direct estimate"
    DIRECT_NOT_SIGNIFICANT = "direct estimate not significant"
    DIRECT_DISAGREES = "direct estimate disagrees"
    DIRECT_PREFERS = "direct estimate prefers"
    INPUTS_OF_OTHERS = "inputs of other trials fit as well"
    SINGLE_TRIAL = "a single test trial"
    LESS_THAN_UNEXPLAINED = "smaller than what stays unexplained"
    REMAINDER_OF = "may be a remainder of"


class _Machine(BaseModel):
    # With one trial an interval's end is unknown: infinity is written as a word and read back.
    model_config = ConfigDict(frozen=True, extra="ignore", ser_json_inf_nan="strings")


class Estimate(_Machine):
    """A value with its unit and 95 % interval."""

    value: float
    unit: str = "1"
    ci95: Interval


class Place(_Machine):
    """Where an effect acts; all None means the whole world or log."""

    joint: str | None = None
    body: str | None = None
    pair: str | None = None

    def __str__(self) -> str:
        return self.joint or self.body or self.pair or "world"


class AppliedEffect(_Machine):
    """One effect of a model extension."""

    name: str
    where: Place = Place()
    parameters: dict[str, Estimate]

    def values(self) -> dict[str, float]:
        """Parameter values alone, SI."""
        return {name: p.value for name, p in self.parameters.items()}


class ModelExtension(_Machine):
    """`extension.json`: what `sim` adds to a world."""

    schema_version: Literal[1] = 1
    measurement: str
    target: dict[str, str] = {}
    effects: tuple[AppliedEffect, ...] = ()


class ConventionCheck(_Machine):
    """One simulator convention that was checked before any physics was blamed."""

    name: str
    status: Literal["ok", "fixed", "suspect"]
    evidence: str


class Localisation(_Machine):
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


class Hypothesis(_Machine):
    """One candidate effect and the evidence for it."""

    name: str
    where: Place = Place()
    heldout_gain: float
    ci95: Interval
    p_adjusted: float
    delta_bic: float
    direct: dict[str, Estimate] = {}
    direct_agrees: bool | None = None  # None: there is no direct route in these data


class Criterion(_Machine):
    """A value beside the bound it was compared with, both in the unit of the quantity."""

    quantity: str
    value: float
    relation: Relation
    bound: float

    @property
    def holds(self) -> bool:
        """Whether the value lies on the right side of the bound; not where there is no value."""
        return _HOLDS[self.relation](self.value, self.bound)


class CandidateDecision(_Machine):
    """What one step of the search decided on one candidate, and why.

    round_number   of the search, from 0; the step `judge` follows the last round.
    beside         `name@place` of the other candidate that the reason refers to; empty where it refers to none.
    criteria       all of them hold if `kept`; else the last one does not, and decides.
    """

    round_number: int
    step: Step
    name: str
    where: Place = Place()
    kept: bool
    reason: Reason
    beside: str = ""
    criteria: tuple[Criterion, ...] = ()


class EffectTwin(_Machine):
    """Another effect that imitates one: separable from it only at `factor` times the strength that is noticed."""

    name: str
    where: Place = Place()
    factor: float


class IdentifiableEffect(_Machine):
    """What the training trials show of an effect beside the declared model, whether or not it acts.

    noticed_from   strengths from which it is noticed, of thresholds such at which it is; empty where these trials show
                   it at no plausible strength.
    twins          effects that imitate it here, the best imitation first.
    """

    name: str
    where: Place = Place()
    noticed_from: dict[str, float]
    twins: tuple[EffectTwin, ...] = ()


class NamedEffect(_Machine):
    """An effect that the verdict names."""

    name: str
    where: Place = Place()
    confidence: float = Field(ge=0.0, le=1.0)
    routes: dict[str, bool]
    parameters: dict[str, Estimate]


class AmbiguousGroup(_Machine):
    """Effects that these data cannot distinguish, and the experiment that would."""

    effects: tuple[str, ...]
    experiment: str


class Verdict(_Machine):
    """The answer. `no_effect` and `ambiguous` are answers of equal rank."""

    status: Literal["effect_found", "no_effect", "ambiguous", "outside_model_class"]
    effects: tuple[NamedEffect, ...] = ()
    ambiguous_groups: tuple[AmbiguousGroup, ...] = ()
    statement: str


class Gain(_Machine):
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


class RolloutEngine(_Machine):
    """What rolled models out: its name with version, its method in words, its longest step (s); None without steps."""

    name: str
    method: str
    step_s: float | None = None


class EngineDifference(_Machine):
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


class EngineComparison(_Machine):
    """The declared mechanism in the user's engine at the user's step, over these whole held-out trials.

    failure   why trials are missing; empty where none is.
    """

    engine: RolloutEngine
    trials: tuple[str, ...] = ()
    differences: tuple[EngineDifference, ...] = ()
    failure: str = ""


class Baseline(_Machine):
    """Errors of the current model without any change."""

    metrics: dict[str, Estimate]


class Rival(_Machine):
    """A way without names, for comparison."""

    name: str
    heldout: float


class OpenQuestion(_Machine):
    """An effect that was found, and a rival that might be in its place.

    left   loss that the rival is expected to leave on the trials there are, `needed` what rejects it.
    """

    effect: str
    where: Place = Place()
    rival: str
    rival_where: Place = Place()
    left: float
    needed: float


class PlannedRecording(_Machine):
    """A recording that could be made: what to do in words, and the losses that rivals would leave with it.

    left        per open question, in their order, if the effect that was found is the true one.
    separates   all rivals would be rejected.
    """

    name: str
    words: str
    left: tuple[float, ...]
    separates: bool


class RecordingPlan(_Machine):
    """`plan.json` of `mana gap plan`: what is in doubt, and recordings that would settle it, the best first."""

    schema_version: Literal[1] = 1
    measurement: str
    open_questions: tuple[OpenQuestion, ...] = ()
    recordings: tuple[PlannedRecording, ...] = ()
    statement: str


class GapReport(_Machine):
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
    reason_counts: dict[Reason, int] = {}  # decisions by reason
    extension: str = "extension.json"
