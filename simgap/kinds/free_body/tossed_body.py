"""Protocol of a simulated tossed body, one rigid body or bodies with joints, for roll-outs and direct estimates.

State columns: p, v_W of the base's origin, quat_wxyz, w_B as in `simgap.recording.recording.Trial`, and for joints q,
qd.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from schemas.arrays import FloatArray
from schemas.measurement import SensorNoise
from sim.dynamics.hooks import Series
from simgap.kinds.free_body.apply_model import AppliedBody
from simgap.kinds.free_body.direct_estimates import Routes
from simgap.kinds.free_body.toss import Toss
from simgap.problem import Candidate, DirectEstimate, Model

Columns = Mapping[str, FloatArray]
DirectEstimator = Callable[[Candidate], DirectEstimate | None]


class BodySimulator(Protocol):
    """A declared model with its engine; pure functions of their arguments."""

    @property
    def has_support(self) -> bool:
        """Whether there is something to land on."""
        ...

    @property
    def size_m(self) -> float:
        """Greatest extent of the shapes."""
        ...

    @property
    def gravity_W(self) -> FloatArray:
        """(3,) declared gravity, m/s2."""
        ...

    @property
    def engine_time_s(self) -> float:
        """SI seconds that pass in one second of the engine."""
        ...

    @property
    def state(self) -> tuple[str, ...]:
        """Columns that start a roll-out."""
        ...

    @property
    def read(self) -> tuple[str, ...]:
        """Columns of a pose, which are compared."""
        ...

    @property
    def channel_units(self) -> tuple[str, ...]:
        """SI unit of each channel."""
        ...

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the errors' columns."""
        ...

    def routes(self, candidate: Candidate) -> Routes:
        """Estimators that read the candidate off one toss."""
        ...

    def apply(self, model: Model) -> AppliedBody:
        """The declared model with terms."""
        ...

    def rollout(self, applied: AppliedBody, t_s: FloatArray, start: Columns, finer: float) -> Columns:
        """`state` at the stamps t_s (w, k) as (w, k, n), from `start` (w, n), in steps so many times finer."""
        ...

    def errors(self, simulated: Columns, measured: Columns) -> FloatArray:
        """(w * k, c) simulated minus measured, row by row, from columns `read` (w, k, n)."""
        ...

    def gaps(self, series: Series) -> FloatArray:
        """(n,) distance of the lowest point of the declared shapes from the support; negative is penetration."""
        ...

    def toss(self, applied: AppliedBody, series: Series) -> Toss:
        """A trial with its contact geometry, for direct estimates."""
        ...

    def candidates(self, series: Sequence[Series], estimate_directly: DirectEstimator) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`; bounds follow from `series`."""
        ...

    def nuisances(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        ...

    def reading_noise(self, noise: SensorNoise, slope_noise_per_s: float, horizon_s: float) -> FloatArray:
        """(c,) mean square error that noise of readings and starts leaves after `horizon_s`.

        Rates that were not measured have `slope_noise_per_s` times the noise of poses.
        """
        ...
