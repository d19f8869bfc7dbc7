"""`plan.json`: which recording to make next, and what it would settle."""

from __future__ import annotations

from typing import Literal

from schemas.sim_gap.extension import Machine, Place


class OpenQuestion(Machine):
    """An effect that was found, and a rival that might be in its place.

    left   loss that the rival is expected to leave on the trials there are, `needed` what rejects it.
    """

    effect: str
    where: Place = Place()
    rival: str
    rival_where: Place = Place()
    left: float
    needed: float


class PlannedRecording(Machine):
    """A recording that could be made: what to do in words, and the losses that rivals would leave with it.

    left        per open question, in their order, if the effect that was found is the true one.
    separates   all rivals would be rejected.
    """

    name: str
    words: str
    left: tuple[float, ...]
    separates: bool


class RecordingPlan(Machine):
    """`plan.json` of `mana gap plan`: what is in doubt, and recordings that would settle it, the best first."""

    schema_version: Literal[1] = 1
    measurement: str
    open_questions: tuple[OpenQuestion, ...] = ()
    recordings: tuple[PlannedRecording, ...] = ()
    statement: str
