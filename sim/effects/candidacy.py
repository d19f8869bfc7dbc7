"""How a log makes an effect a candidate: whether it can show it, null values, bounds, nuisance, direct estimators.

Members are functions of the ranges of a log (`sim.effects.ranges`). What a function leaves out is the parameter's own:
its null value, its bounds. One class per kind of measurement, because kinds are searched in different ways.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, Literal, TypeVar

from sim.dynamics.body_rollout import BodyModel
from sim.effects.ranges import DeclaredJoint, ImpactRanges, JointRanges, PushRanges, TossRanges

Values = dict[str, float]
Bounds = dict[str, tuple[float, float]]
Declared = TypeVar("Declared")
Ranges = TypeVar("Ranges")
ActsOn = Literal["pair", "link", "linkage", "joint", "log"]
Role = Literal["timing", "inertia", "weight", "friction", "bounce", "damping", "effort"]
ROLES: tuple[Role, ...] = ("timing", "inertia", "weight", "friction", "bounce", "damping", "effort")


@dataclass(frozen=True)
class Nuisance:
    """A declared number that is believed within an interval only; the null model refits it there.

    role   what the number is; a null model lists its nuisances in the order of `ROLES`.
    pair   of surfaces, where it is not the pair of body and support.
    """

    role: Role
    parameter: str
    value: float
    low: float
    high: float
    pair: str = ""


def within(role: Role, parameter: str, value: float, half: float) -> Nuisance | None:
    """A number that is believed to within `half`; None where that is nothing."""
    return Nuisance(role, parameter, value, value - half, value + half) if half > 0.0 else None


def _always(ranges: Any) -> bool:
    return True


def never(ranges: Any) -> bool:
    """Not observable in this kind of measurement."""
    return False


def _nothing(ranges: Any) -> dict[str, Any]:
    return {}


def _no_nuisance(declared: Any) -> Nuisance | None:
    return None


def _no_extra_starts(ranges: Any, null: Values, bounds: Bounds) -> tuple[Values, ...]:
    return ()


@dataclass(frozen=True)
class Candidacy(Generic[Declared, Ranges]):
    """What all kinds of measurement have in common.

    observable   whether the log has what the effect acts on.
    null         declared values; others are the parameters' own.
    bounds       plausible values in this log.
    nuisance     the declared number that is believed within a tolerance, if the effect has one.
    """

    observable: Callable[[Ranges], bool] = _always
    null: Callable[[Ranges], Values] = _nothing
    bounds: Callable[[Ranges], Bounds] = _nothing
    nuisance: Callable[[Declared], Nuisance | None] = _no_nuisance


@dataclass(frozen=True)
class MechanismCandidacy(Candidacy[DeclaredJoint, JointRanges]):
    """In a log of a mechanism, where direct estimates need no estimators of their own.

    whole_log      the effect acts on the whole log; else on each joint.
    start          initial values of a fit, where they are not the null values.
    extra_starts   further ones, from null values and bounds: a gradient vanishes away from thresholds.
    max_excursion  largest motion beyond a threshold, by parameter.
    """

    whole_log: bool = False
    start: Callable[[JointRanges], Values] = _nothing
    extra_starts: Callable[[JointRanges, Values, Bounds], tuple[Values, ...]] = _no_extra_starts
    max_excursion: Callable[[JointRanges], Values] = _nothing


@dataclass(frozen=True)
class TossCandidacy(Candidacy[BodyModel, TossRanges]):
    """In a log of a tossed body or linkage.

    acts_on               place in a linkage, where it does not follow from the effect's family.
    direct, linked_direct   names of estimators for a single body and for a linkage; all of them must agree.
    bounds_from_direct    a direct estimate sets the bounds and, where it is sure, the value: fits to contacts stray.
    """

    acts_on: ActsOn | None = None
    direct: tuple[str, ...] = ()
    linked_direct: tuple[str, ...] = ()
    bounds_from_direct: bool = False


@dataclass(frozen=True)
class ImpactCandidacy(Candidacy[BodyModel, ImpactRanges]):
    """In a table of impacts; `direct` names an estimator."""

    direct: str = ""


@dataclass(frozen=True)
class PushCandidacy(Candidacy[PushRanges, PushRanges]):
    """In a table of pushes; `direct` names an estimator."""

    direct: str = ""
