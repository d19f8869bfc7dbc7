"""The verdict from a search on whole trials: each reason for doubt alone keeps an effect from being sure."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np

from schemas.sim_gap.decisions import Reason
from simgap.inference.verdict_text import NAMED, STRANGE
from simgap.problem import Leftover, Problem, StateAxis
from simgap.search_result import gain_between
from simgap.whole_trials.check import check_whole_trials
from simgap.whole_trials.confidence_set import confidence_set
from simgap.whole_trials.judge import JudgedModel, judge
from simgap.whole_trials.ladder import ladder_of
from simgap.whole_trials.policy import POLICY
from simgap.whole_trials.search_models import search_models
from tests.simgap.whole_trials.drawn_trials import Drawn, DrawnProblem, Named, candidates, searched

AGREES = {"ramp": (6.1, 0.2), "bow": (20.0, 1.0), "twin": (10.0, 0.5)}


def judged(
    truth: dict[str, float],
    names: str,
    direct: dict[str, tuple[float, float]] = AGREES,
    outside: float = 0.0,
    strange: bool = False,
    leftovers: tuple[Leftover, ...] = (),
) -> JudgedModel:
    search = searched(Drawn(truth, outside), names)
    null, chosen = search.null.fit, search.chosen.fit
    test = Drawn(truth, outside, seed=1)
    check = check_whole_trials(test, null.model, chosen.model, (null, chosen), POLICY)
    whole = gain_between(check.null, check.final, "full_rollout", 0.0)
    short = whole.model_copy(update={"view": "short_horizon", "horizon_s": 0.2})
    problem = cast(Problem, cast(Any, DrawnProblem(direct, leftovers=leftovers)))
    return judge(problem, confidence_set(search, POLICY), check, (short, whole), test.trial_ids, strange, {}, POLICY)


def reasons(judgement: JudgedModel) -> set[Reason]:
    return {decision.reason for _, decision in judgement.decisions if not decision.kept}


def test_an_effect_without_a_doubt_is_sure() -> None:
    found = judged({"ramp": 6.0}, "ramp wave")
    (effect,) = found.verdict.effects
    assert (found.verdict.status, effect.name) == ("effect_found", "ramp")
    assert effect.confidence > NAMED
    low, high = effect.parameters["size"].ci95
    assert low < 6.0 < high
    assert 0.05 < high - low < 1.0


def test_two_causes_are_both_sure() -> None:
    found = judged({"ramp": 6.0, "bow": 20.0}, "ramp wave bow")
    assert {e.name for e in found.verdict.effects if e.confidence > NAMED} == {"ramp", "bow"}


def test_a_direct_estimate_that_disagrees_leaves_a_doubt() -> None:
    found = judged({"ramp": 6.0}, "ramp wave", {"ramp": (-6.0, 0.2)})
    assert found.verdict.status == "ambiguous"
    assert reasons(found) == {Reason.DIRECT_DISAGREES}


def another_force(size: float, *names: str) -> tuple[Leftover, ...]:
    """Noise of one and a force over position of so many noise levels, beside laws that explain five each."""
    rng = np.random.default_rng(3)
    place, trials = rng.uniform(-1.0, 1.0, (240, 1)), np.repeat(np.arange(12), 20)
    values = rng.normal(size=(240, 1)) + size * np.sign(np.abs(place) - 0.5)
    by_law = {f"{n}@world": np.full((240, 1), 5.0) for n in names}
    return (Leftover(values, by_law, np.full(1, 0.1), (StateAxis("position", place),), place > 0.0, trials),)


def test_a_law_beside_which_another_force_repeats_is_not_sure_though_whole_trials_come_down_to_the_noise() -> None:
    found = judged({"ramp": 6.0}, "ramp wave", leftovers=another_force(2.5, "ramp"))
    assert reasons(found) == {Reason.SHAPE_DIFFERS}
    assert all(e.confidence < NAMED for e in found.verdict.effects)
    assert (found.verdict.status, found.verdict.ambiguous_groups) == ("outside_model_class", ())
    assert "0.22 m/s2 (rms) of y repeats along position" in found.verdict.statement  # two of ten bins hold both signs


def test_a_force_that_is_small_beside_a_law_leaves_it_sure() -> None:
    assert judged({"ramp": 6.0}, "ramp wave", leftovers=another_force(0.5, "ramp")).verdict.status == "effect_found"


def test_a_misshapen_law_with_a_twin_is_a_group() -> None:
    found = judged({"bow": 20.0}, "ramp bow twin", leftovers=another_force(2.5, "bow", "twin"))
    assert found.verdict.status == "ambiguous"
    assert Reason.SHAPE_DIFFERS in reasons(found)


def test_a_shape_that_noise_hides_is_said_beside_the_name() -> None:
    found = judged({"ramp": 6.0}, "ramp wave")
    assert [d.reason for _, d in found.decisions] == [Reason.NAMED, Reason.SHAPE_HIDDEN]


def test_without_a_direct_estimate_nothing_is_sure() -> None:
    found = judged({"ramp": 6.0}, "ramp wave", {})
    assert found.verdict.status == "ambiguous"
    assert reasons(found) == {Reason.NO_DIRECT_ESTIMATE}
    assert all(e.confidence < NAMED for e in found.verdict.effects)


def test_twins_are_named_together() -> None:
    found = judged({"bow": 20.0}, "ramp bow twin")
    (group,) = found.verdict.ambiguous_groups
    assert set(group.effects) == {"bow", "twin"}
    assert found.verdict.status == "ambiguous"


def test_what_no_model_explains_caps_what_comes_nearest() -> None:
    found = judged({"ramp": 6.0}, "ramp wave", outside=8.0)
    assert found.verdict.status == "outside_model_class"
    assert all(e.confidence < NAMED for e in found.verdict.effects)
    assert "outside the library" in found.verdict.statement


def test_noise_alone_is_no_effect_and_no_structure() -> None:
    found = judged({}, "ramp wave bow")
    assert (found.verdict.status, found.verdict.effects) == ("no_effect", ())


def test_inputs_of_other_trials_make_nothing_sure() -> None:
    found = judged({"ramp": 6.0}, "ramp wave", strange=True)
    assert found.verdict.statement == STRANGE
    assert Reason.INPUTS_OF_OTHERS in reasons(found)
    assert all(e.confidence < NAMED for e in found.verdict.effects)


def test_a_rival_that_was_not_fitted_is_named_beside_an_effect_whose_place_it_could_take() -> None:
    ramp, late, wave = candidates("ramp late wave")
    search = search_models(ladder_of(Drawn({"ramp": 6.0}), (), POLICY), [ramp, wave], POLICY)
    null, chosen = search.null.fit, search.chosen.fit
    test = Drawn({"ramp": 6.0}, seed=1)
    check = check_whole_trials(test, null.model, chosen.model, (null, chosen), POLICY)
    whole = gain_between(check.null, check.final, "full_rollout", 0.0)
    problem, models = cast(Problem, cast(Any, DrawnProblem(AGREES))), confidence_set(search, POLICY)
    for twins, groups in ({ramp.key: (late,)}, [("ramp", "late")]), ({wave.key: (late,)}, []):
        found = judge(problem, models, check, (whole, whole), test.trial_ids, False, twins, POLICY)
        assert [g.effects for g in found.verdict.ambiguous_groups] == groups


def test_one_law_with_two_names_is_a_group_although_only_one_was_fitted() -> None:
    ramp, wave = candidates("ramp wave")
    twin = replace(ramp, effect=cast(Any, Named("late ramp")))
    ramp = replace(ramp, effect=cast(Any, Named("ramp", same_as="late ramp")))
    search = search_models(ladder_of(Drawn({"ramp": 6.0}), (), POLICY), [ramp, wave], POLICY)
    null, chosen = search.null.fit, search.chosen.fit
    test = Drawn({"ramp": 6.0}, seed=1)
    check = check_whole_trials(test, null.model, chosen.model, (null, chosen), POLICY)
    whole = gain_between(check.null, check.final, "full_rollout", 0.0)
    problem = cast(Problem, cast(Any, DrawnProblem(AGREES, (ramp, twin, wave))))
    found = judge(problem, confidence_set(search, POLICY), check, (whole, whole), test.trial_ids, False, {}, POLICY)
    assert [g.effects for g in found.verdict.ambiguous_groups] == [("ramp", "late ramp")]
