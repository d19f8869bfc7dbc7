"""The steps of the asset pipeline as data: which stages run in which order, and which ones send a draft back.

`Pipeline` takes the steps, checks their order once, when it is made, and is run by `assetkit.pipeline`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from assetkit.acceptance.repairs import RepairRule
from assetkit.stage import RESULT_FIELDS, Draft, Frame, Stage
from schemas.asset import RepeatReason

Reasons = Mapping[RepeatReason, Mapping[str, float]]


@dataclass(frozen=True)
class Revision:
    """Another frame for a draft, and the reasons for it, each with its values by name and unit."""

    frame: Frame
    reasons: Reasons


@dataclass(frozen=True)
class Refinement:
    """A loop: after its step, `revise(draft)` may give another frame, in which `repeats` run again, in that order.

    It is bounded: after `at_most` repeated passes per object a draft that would be revised once more goes to a person.
    """

    repeats: tuple[str, ...]
    revise: Callable[[Draft], Revision | None]
    at_most: int


@dataclass(frozen=True)
class Retry:
    """A loop over whole attempts: a failure that a rule answers leads to an edit, and the stages from the rule's first
    one on run again, at most `at_most` times. The first draft stays when no attempt ends without.
    """

    rules: tuple[RepairRule, ...]
    at_most: int


@dataclass(frozen=True)
class Step:
    """One stage in its place, with the loops that it may start."""

    stage: Stage
    refines: Refinement | None = None
    retries: Retry | None = None

    @property
    def name(self) -> str:
        """The name of the stage."""
        return self.stage.name


class InvalidPipeline(ValueError):
    """The steps cannot run in this order; a defect of the code, raised when the pipeline is made."""


@dataclass(frozen=True)
class Pipeline:
    """Steps in order; a run begins with the step at `start` and takes the results of those before from its draft.

    Raises InvalidPipeline where a stage reads what no earlier stage makes, where a name is no field of the draft or
    occurs twice, and where a loop goes to a stage that has not run, or has no bound.
    """

    steps: tuple[Step, ...]
    start: int = 0

    def __post_init__(self) -> None:
        earlier: list[str] = []
        for step in self.steps:
            stage = step.stage
            if RESULT_FIELDS.get(stage.result) != stage.name:
                raise InvalidPipeline(f"'{stage.name}' is not the field of {stage.result.__name__} in a draft")
            if stage.name in earlier:
                raise InvalidPipeline(f"'{stage.name}' occurs twice")
            if missing := [result.__name__ for result in stage.reads if RESULT_FIELDS[result] not in earlier]:
                raise InvalidPipeline(f"'{stage.name}' reads {', '.join(missing)}, which no earlier stage makes")
            earlier.append(stage.name)
            _require_loops(step, earlier)

    def up_to(self, stage: str) -> Pipeline:
        """The steps up to the one named, included."""
        return Pipeline(self.steps[: self._position(stage) + 1], self.start)

    def from_stage(self, stage: str) -> Pipeline:
        """The same steps, run from the one named on."""
        return Pipeline(self.steps, self._position(stage))

    def before(self, stage: str) -> Step | None:
        """The step before the one named; None for the first."""
        position = self._position(stage)
        return self.steps[position - 1] if position else None

    def stages(self, *names: str) -> tuple[Stage, ...]:
        """The stages of these names."""
        return tuple(self.steps[self._position(name)].stage for name in names)

    def _position(self, stage: str) -> int:
        return [step.name for step in self.steps].index(stage)


def _require_loops(step: Step, earlier: list[str]) -> None:
    """Raises InvalidPipeline where a loop of a step goes elsewhere than back, or has no bound."""
    back = step.refines.repeats if step.refines else ()
    if lost := [name for name in back if name not in earlier]:
        raise InvalidPipeline(f"'{step.name}' sends a draft to {', '.join(lost)}, which has not run")
    if list(back) != sorted(set(back), key=earlier.index):
        raise InvalidPipeline(f"'{step.name}' repeats stages out of their order")
    for rule in step.retries.rules if step.retries is not None else ():
        if rule.first_stage not in earlier:
            raise InvalidPipeline(f"'{step.name}' retries from '{rule.first_stage}', which has not run")
    bounds = [loop.at_most for loop in (step.refines, step.retries) if loop is not None]
    if any(at_most < 1 for at_most in bounds):
        raise InvalidPipeline(f"'{step.name}' has a loop of no pass")
