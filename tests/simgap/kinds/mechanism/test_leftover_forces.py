"""The leftover of the balance of forces tells a law from another one and from a second cause, without a roll-out.

Each law is fitted to the balance itself: nothing here asks whether whole trials come down to the noise.
"""

from __future__ import annotations

import pytest

from schemas.sim_gap.decisions import Reason
from simgap.inference.decision import Decision
from simgap.inference.repeating_shape import shape_of, structures
from simgap.kinds.mechanism import problem as problem_module
from simgap.kinds.mechanism.problem import MechanismProblem
from simgap.problem import Model, Term
from simgap.whole_trials.policy import POLICY
from tests.suites.gap.effects import effect_named
from tests.suites.gap.mechanism_cases import Stage

SWING = Stage(7003, "swing", 1.0)


def hiding(stage: Stage, **strengths: float) -> MechanismProblem:
    hidden: dict = {}
    for name, strength in strengths.items():
        hidden |= stage.numbers(effect_named(f"joint.{name}"), strength)
    return stage.problem(hidden)


def fitted(problem: MechanismProblem, name: str) -> Model:
    """The nuisances as declared, and the effect as the balance estimates it."""
    null = tuple(Term(c, dict(c.start)) for c in problem.nuisances())
    candidate = next(c for c in problem.candidates() if c.effect.name == f"joint.{name}")
    estimate = problem.direct(candidate, null, problem.trial_ids)
    assert estimate is not None
    return (*null, Term(candidate, estimate.values))


def shape(problem: MechanismProblem, name: str) -> Decision:
    model = fitted(problem, name)
    leftovers = problem.leftovers(model, problem.trial_ids)
    repeating = structures(leftovers, POLICY.alpha)
    return shape_of(model[-1].candidate.key, leftovers, repeating, POLICY.alpha, POLICY.shape_share)


@pytest.mark.parametrize("name", ["viscous_friction", "coulomb_friction", "quadratic_drag", "detent", "spring"])
def test_a_right_law_has_the_shape_of_its_force(name: str) -> None:
    decision = shape(hiding(SWING, **{name: 0.1}), name)
    assert (decision.kept, decision.reason) == (True, Reason.PASSED)


@pytest.mark.parametrize(
    ("hidden", "named"),
    [("quadratic_drag", "viscous_friction"), ("coulomb_friction", "quadratic_drag"), ("detent", "spring")],
)
def test_another_law_in_its_place_is_refused(hidden: str, named: str) -> None:
    decision = shape(hiding(SWING, **{hidden: 0.1}), named)
    assert decision.reason is Reason.SHAPE_DIFFERS


@pytest.mark.parametrize("second", ["detent", "quadratic_drag"])
def test_a_right_law_beside_a_second_cause_as_large_is_refused(second: str) -> None:
    problem = hiding(SWING, coulomb_friction=0.05, **{second: 0.1})
    assert shape(problem, "coulomb_friction").reason is Reason.SHAPE_DIFFERS


def test_what_a_law_explains_alone_is_its_force_over_the_inertia() -> None:
    """But for what the believed inertia and weight, 5 % off at most, could do of it."""
    problem = hiding(SWING, viscous_friction=0.1)
    model = fitted(problem, "viscous_friction")
    damping, inertia = model[-1].values["damping_Nms_per_rad"], float(SWING.plant.inertia[0])
    for one in problem.leftovers(model, problem.trial_ids):
        states = {axis.words: axis.values for axis in one.axes}
        expected = damping / inertia * states["velocity"].std()
        assert one.own[model[-1].candidate.key].std() * one.noise == pytest.approx(expected, rel=0.1)


def test_an_effect_that_noise_hides_is_not_doubted_for_its_shape() -> None:
    decision = shape(hiding(Stage(7003, "swing", 30.0), quadratic_drag=0.01), "viscous_friction")
    assert (decision.kept, decision.reason) == (True, Reason.SHAPE_HIDDEN)


@pytest.mark.parametrize(("scene", "noise"), [("swing", 20.0), ("driven", 20.0), ("slide", 5.0), ("swing", 1.0)])
def test_known_friction_at_standstill_is_no_force_that_repeats(scene: str, noise: float) -> None:
    """With whatever friction is needed there, the chance of structure is 0.005 in three of the four."""
    problem = Stage(7003, scene, noise, 0.1).problem({})
    null = tuple(Term(c, dict(c.start)) for c in problem.nuisances())
    leftovers = problem.leftovers(null, problem.trial_ids)
    assert len(leftovers) > 0
    assert structures(leftovers, POLICY.alpha)[0].p_value > POLICY.alpha


def test_nothing_is_rolled_out(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = hiding(SWING, quadratic_drag=0.1)

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("a roll-out")

    for module in (problem_module, problem_module.MechanismTrials):
        monkeypatch.setattr(module, "rollout" if module is problem_module else "errors", refuse)
    assert shape(problem, "quadratic_drag").kept
