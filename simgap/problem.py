"""The interface between statistics and kinds of measurement: candidates, residuals, direct estimates, noise.

`simgap.inference` works on a `Problem` alone; each folder of `simgap.kinds` implements one. All quantities are SI.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.sim_gap.extension import Place
from schemas.sim_gap.report import ConventionCheck, RolloutEngine
from sim.dynamics.mechanism import MechanismModel
from sim.effects.effect import Effect

View = Literal["short_horizon", "full_rollout"]


@dataclass(frozen=True)
class Candidate:
    """An effect at a place in one measurement; all keys are parameter names.

    null      values without effect: the effect's own, or what the subject declares (a declared friction, a mass).
    start     initial values of a fit.
    bounds    plausible values in this measurement, within the effect's own.
    nuisance  the candidate is a declared number within its tolerance: part of the null model, never named.
    shapes    parameters without meaning while the effect is absent: where on a range it acts, not how strongly.
    extra_starts        further initial values, for thresholds: a gradient vanishes away from them.
    max_excursion       largest motion beyond a threshold, by parameter; the force law out there is a guess.
    direct_half_width   half width of the direct estimate that set the bounds; used when a fit ends on a bound.
    step      share of a range over which slopes are differenced: larger where contacts make roll-outs jump.
    variant   where one effect may lie at several points of a drive, which of them: values that bounds fix.
    """

    effect: Effect
    where: Place
    null: dict[str, float]
    start: dict[str, float]
    bounds: dict[str, tuple[float, float]]
    nuisance: bool = False
    shapes: tuple[str, ...] = ()
    extra_starts: tuple[dict[str, float], ...] = ()
    max_excursion: dict[str, float] = field(default_factory=dict)
    direct_half_width: dict[str, float] = field(default_factory=dict)
    step: float = 2e-3
    variant: str = ""

    @property
    def key(self) -> str:
        """Name, variant and place as one word; the keys of nuisances and of named effects differ."""
        variant = f"[{self.variant}]" if self.variant else ""
        return f"{'nuisance:' if self.nuisance else ''}{self.effect.name}{variant}@{self.where}"

    @property
    def strengths(self) -> tuple[str, ...]:
        """Parameters other than shapes: at their null values the effect is absent."""
        return tuple(n for n in self.null if n not in self.shapes)


@dataclass(frozen=True)
class Term:
    """A candidate with values: one term of a model."""

    candidate: Candidate
    values: dict[str, float]


Model = tuple[Term, ...]  # The declared model is the empty tuple.


@dataclass(frozen=True)
class DirectEstimate:
    """An estimate of a candidate's parameters without a simulator, from trials taken as independent clusters.

    values, standard_errors   by parameter; `p_value` of "no effect" over `trials` usable trials.
    held_out            (t,) cross-validated loss per trial, comparable between candidates; None where there is none.
    separate_readings   one estimate per reading, where several readings of the motion give the same number.
    """

    values: dict[str, float]
    standard_errors: dict[str, float]
    p_value: float
    trials: int
    held_out: FloatArray | None = None
    separate_readings: tuple[DirectEstimate, ...] = ()


@dataclass(frozen=True)
class StateAxis:
    """A state that forces may depend on, per stretch and channel (b, c); `by_direction`: apart for either direction."""

    words: str
    values: FloatArray
    by_direction: bool = False


@dataclass(frozen=True)
class Leftover:
    """What a model leaves of a balance in which nothing is simulated: c channels over b stretches of trials.

    The parameters are moved first to where least is left, nuisances within their tolerance: what stays has a shape that
    no values of them give.

    values      (b, c) in noise levels of the channel.
    own         (b, c) by key of an effect: what the balance without it leaves more, when all others have moved.
    noise       (c,) that level; rad/s2 or m/s2.
    axes        that the values are compared along; `forwards` (b, c) is the direction of motion.
    trials      (b,) number of the trial.
    """

    values: FloatArray
    own: dict[str, FloatArray]
    noise: FloatArray
    axes: tuple[StateAxis, ...]
    forwards: BoolArray
    trials: IntArray


@dataclass(frozen=True)
class JointMotion:
    """Stamps (k,) and joint positions (k, j), rad or m, that full roll-outs of one trial are compared with."""

    t_s: FloatArray
    q: FloatArray


@dataclass(frozen=True)
class ImaginedRecording:
    """A recording that could be made next, as a model would give it, and how often: a name, what to do in words."""

    name: str
    words: str
    system: TrialSystem
    copies: int


class Problem(Protocol):
    """A measurement of one kind with its simulator. The value of a method depends on its arguments alone.

    A kind inherits from this class. Methods with a body answer for a kind without that capability; kinds that have it
    override them, and callers never ask which kind a problem is of.
    """

    horizon_s: float  # length of short roll-outs; 0 for events

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """All trials, in file order."""
        ...

    def candidates(self) -> tuple[Candidate, ...]:
        """Every effect that this measurement could reveal, at every place, in library order."""
        ...

    def nuisances(self) -> tuple[Candidate, ...]:
        """Declared numbers that the null model refits within their tolerance; never a named effect."""
        ...

    def residuals(self, model: Model, trials: Sequence[str], view: View) -> list[FloatArray]:
        """Per trial (k, c): simulated minus measured, SI units; k over windows and frames.

        Channels c are those of `channels`. Rows may hold NaN where nothing was measured. A simulation that diverges
        gives large finite numbers, never an exception. Equal trials give equally many rows for any model.
        """
        ...

    def features(self, trials: Sequence[str], view: View) -> list[FloatArray]:
        """Per trial (k, f), row by row beside the residuals: measured state, input and time since the start."""
        ...

    def channels(self) -> tuple[str, ...]:
        """Names of the residual's columns, e.g. `position_x` or `q_elbow`."""
        ...

    def direct(self, candidate: Candidate, model: Model, trials: Sequence[str]) -> DirectEstimate | None:
        """The candidate's parameters without a simulator, beside the accepted terms `model`; None without a method."""
        ...

    def leftovers(self, model: Model, trials: Sequence[str]) -> tuple[Leftover, ...]:
        """What `model` leaves of the balance of forces, over stretches of several lengths; none without a balance."""
        return ()

    def noise_floor(self, trials: Sequence[str], view: View) -> FloatArray:
        """(c,) rms residual (SI) that noise of initial states and readings alone leaves."""
        ...

    def channel_units(self) -> tuple[str, ...]:
        """SI unit of each channel."""
        ...

    def with_input_timing(self) -> Problem:
        """The same problem with inputs at the times that its motions show best; itself where nothing drives."""
        return self

    def whole_trials(self, trials: Sequence[str]) -> TrialSystem | None:
        """Errors of whole trials with free starts; None where contacts make whole roll-outs diverge."""
        return None

    def timing_check(self) -> ConventionCheck | None:
        """When inputs act, inferred from motion; None where that is not inferred or leaves no alternative open."""
        return None

    def with_permuted_inputs(self, by: int = 1) -> Problem | None:
        """The same motions with inputs of the trial `by` places on; None where nothing drives, or all alike."""
        return None

    def bootstrap_sample(self, model: Model, seed: int) -> Problem | None:
        """The same measurement with readings that `model` would have given; None where that cannot be simulated."""
        return None

    def declared_mechanism(self) -> MechanismModel | None:
        """The declared model of a fixed mechanism; None for all other kinds."""
        return None

    def joint_motion(self, trial: str) -> JointMotion | None:
        """The motion of the joints of a fixed mechanism; None for all other kinds."""
        return None

    def engine_time_s(self) -> float:
        """SI seconds that pass in one second of an engine that rolls models out."""
        return 1.0

    def own_rollout(self) -> RolloutEngine | None:
        """How models are rolled out here; None for bodies, which the caller's engine rolls out."""
        return None

    def as_events(self) -> EventProblem | None:
        """The problem itself where rows are events without time; None for time series."""
        return None


class TrialSystem(Protocol):
    """Whole trials (t) whose starts are free, as errors in noise levels. Methods depend on their arguments alone."""

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """The trials, in the order of all arrays."""
        ...

    @property
    def start_steps(self) -> FloatArray:
        """(t, s) a noise level of each start value, in SI units; changes of starts are counted in these."""
        ...

    @property
    def channel_count(self) -> int:
        """Channels of a row; errors of one row lie side by side."""
        ...

    def errors(self, model: Model, starts: FloatArray) -> FloatArray:
        """(m, t, n) simulated minus measured, in noise levels, for m sets of starts (m, t, s) in `start_steps`.

        NaN where nothing was measured. A simulation that diverges gives large finite numbers.
        """
        ...

    @property
    def piece_starts(self) -> tuple[tuple[int, int], ...]:
        """(t,) number of the trial, and row in it, where each starts."""
        ...

    def pieces(self, count: int) -> TrialSystem | None:
        """Each trial cut into so many pieces (a power of two) that start freely; None where they get too short.

        What starts a longer piece starts one of the shorter ones, too.
        """
        ...

    def finer(self) -> TrialSystem:
        """The same in smaller steps: dearer, and for comparisons with the noise."""
        ...

    @property
    def plain(self) -> TrialSystem:
        """The same in the steps from which `finer` went: for changes of errors. Itself where it is not finer."""
        ...

    def imagined(self, model: Model) -> tuple[ImaginedRecording, ...]:
        """Further recordings that could be made of what moves in these trials, as a model would give them."""
        ...

    def with_noise_from(self, model: Model, starts: FloatArray) -> TrialSystem:
        """The same with the noise level that a model's errors show from row to row; single wild rows are left out."""
        ...


class EventProblem(Problem, Protocol):
    """A problem whose rows are events without time; short horizon and full roll-out are the same."""

    @property
    def convention_checks(self) -> tuple[ConventionCheck, ...]:
        """Conventions of the record that were checked."""
        ...

    def readings(self, trials: Sequence[str]) -> list[FloatArray]:
        """Per trial (k, c) what was measured, row by row beside the residuals."""
        ...

    def slices(self, features: FloatArray) -> dict[str, FloatArray]:
        """(k,) masks of rows by the words of the report for their common property."""
        ...
