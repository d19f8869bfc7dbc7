"""What a search decided on each candidate, by closed reasons with values beside their bounds."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from enum import StrEnum
from typing import Literal

from schemas.sim_gap.extension import Machine, Place

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
    SHAPE_DIFFERS = "another force repeats in the balance"
    SHAPE_HIDDEN = "noise hides the shape"
    DIRECT_PREFERS = "direct estimate prefers"
    INPUTS_OF_OTHERS = "inputs of other trials fit as well"
    SINGLE_TRIAL = "a single test trial"
    LESS_THAN_UNEXPLAINED = "smaller than what stays unexplained"
    REMAINDER_OF = "may be a remainder of"


class Criterion(Machine):
    """A value beside the bound it was compared with, both in the unit of the quantity."""

    quantity: str
    value: float
    relation: Relation
    bound: float

    @property
    def holds(self) -> bool:
        """Whether the value lies on the right side of the bound; not where there is no value."""
        return _HOLDS[self.relation](self.value, self.bound)


class CandidateDecision(Machine):
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
