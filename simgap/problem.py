"""What the statistics of `simgap` ask of one kind of measurement; nothing in them knows joints, bodies or engines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol, runtime_checkable

from schemas.gap import ConventionCheck, Place
from schemas.model import FloatArray
from sim.dynamics.hooks import Effect

View = Literal["short_horizon", "long_horizon", "full_rollout"]


@dataclass(frozen=True)
class Candidate:
    """An effect at a place in one measurement; all keys are parameter names.

    null      values without effect: the effect's own, or what the subject declares (a declared friction, a mass).
    start     where to begin the search.
    bounds    plausible values here, within the effect's own.
    nuisance  part of the null model: a declared number within its tolerance, never named.
    shapes    parameters that mean nothing while the effect is absent: where on the range it acts, not how strongly.
    probes   further values to try first, where no descent finds the way: thresholds, felt only where they are.
    reached   how far motion went beyond a threshold at most, by parameter: its law there is a guess.
    told      half width to which a route without simulator surely knows what it set bounds of: a fit's at their ends.
    step      share of a range over which slopes are read: more where roll-outs answer in small jumps, as contacts do.
    """

    effect: Effect
    where: Place
    null: dict[str, float]
    start: dict[str, float]
    bounds: dict[str, tuple[float, float]]
    nuisance: bool = False
    shapes: tuple[str, ...] = ()
    extra_starts: tuple[dict[str, float], ...] = ()
    reached: dict[str, float] = field(default_factory=dict)
    told: dict[str, float] = field(default_factory=dict)
    step: float = 2e-3

    @property
    def key(self) -> str:
        """Name and place as one word; a nuisance never shares that of a named effect."""
        return f"{'nuisance:' if self.nuisance else ''}{self.effect.name}@{self.where}"

    @property
    def strengths(self) -> tuple[str, ...]:
        """Parameters that are no shapes: at their null values nothing is there."""
        return tuple(n for n in self.null if n not in self.shapes)


@dataclass(frozen=True)
class Term:
    """A candidate with values: one term of a model."""

    candidate: Candidate
    values: dict[str, float]


Model = tuple[Term, ...]  # The declared model is the empty tuple.


@dataclass(frozen=True)
class DirectEstimate:
    """A simulator-free estimate of a candidate's parameters, from trials taken as independent clusters.

    values, standard_errors   per parameter; `p_value` of "no effect" over trials; `trials` that could be used.
    held_out   loss of each trial under what the others teach, where the route has one; comparable between candidates.
    apart      what each says by itself where several readings of the motion tell the same number.
    """

    values: dict[str, float]
    standard_errors: dict[str, float]
    p_value: float
    trials: int
    held_out: FloatArray | None = None
    apart: tuple[DirectEstimate, ...] = ()


@runtime_checkable
class LongHorizonProblem(Protocol):
    """A problem whose roll-outs stay near the truth for long: its effects are chosen on long horizons.

    Contacts make long roll-outs part ways for no cause; where there are none, what a cause does grows with time, and a
    start may be left free.
    """

    @property
    def search_view(self) -> View:
        """The view in which effects are chosen; `short_horizon` for all other problems."""
        ...

    def around(self, model: Model) -> Problem:
        """The same problem, with what starts do to its roll-outs taken at `model`.

        Asked of a problem that is around a model already, all else stays as it was found there.
        """
        ...


class Problem(Protocol):
    """A measurement of one kind with its simulator. Every method is a pure function of its arguments."""

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """All trials, in file order."""
        ...

    def candidates(self) -> tuple[Candidate, ...]:
        """Every effect that this kind of measurement could reveal, at every place, in library order."""
        ...

    def nuisances(self) -> tuple[Candidate, ...]:
        """What the null model may refit: declared numbers within their tolerance, never a named effect."""
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
        """The candidate's parameters without a simulator, given the terms already accepted; None where no route is."""
        ...

    def noise_floor(self, trials: Sequence[str], view: View) -> FloatArray:
        """(c,) rms residual (SI) that noise in the initial state and the readings alone would leave."""
        ...


@runtime_checkable
class Timed(Protocol):
    """A problem that finds out when its inputs act."""

    def timing(self) -> ConventionCheck | None:
        """What it found; None where stamps are even, or nothing else would do."""
        ...


def around(problem: Problem, model: Model) -> Problem:
    """The problem as seen from `model`: where starts are free, what they do is taken there."""
    return problem.around(model) if isinstance(problem, LongHorizonProblem) else problem
