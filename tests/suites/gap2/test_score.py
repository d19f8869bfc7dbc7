"""Each category on a made-up report, and the table's rates."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.conftest import SHARED
from tests.suites.gap2.foreign import foreign_cases
from tests.suites.gap2.generate.truth import HiddenEffect, Truth, truth_from
from tests.suites.gap2.score import Category, is_failure, score, scored_record, table

SPRING, DELAY = HiddenEffect("joint.spring", "a", {"stiffness_Nm_per_rad": 2.0}), HiddenEffect("actuator.delay")
SINGLE = Truth(1, "", "single", "mechanism", "pendulum", (SPRING,), level="gross", miss=6.6)
TWO = replace(SINGLE, family="two", effects=(SPRING, DELAY))
TWIN = replace(SINGLE, family="twin", effects=(DELAY,), accept=("sensor.latency",), rivals={"sensor.latency": 0.3})
OUTSIDE = replace(SINGLE, family="outside", effects=(HiddenEffect("outside.magnet", "a"),))
LEFT_OUT = replace(SINGLE, family="left_out", left_out=("joint.spring",))
CONTROL = replace(SINGLE, family="control", effects=(), miss=0.0, level="", control="none")


def report(*names: tuple[str, float, str], groups: tuple[tuple[str, ...], ...] = (), status: str = "") -> dict:
    effects = [
        {
            "name": name,
            "where": {"joint": joint or None},
            "confidence": confidence,
            "parameters": {"stiffness_Nm_per_rad": {"value": 2.1, "ci95": [1.9, 2.3]}},
        }
        for name, confidence, joint in names
    ]
    status = status or ("effect_found" if names else "ambiguous" if groups else "no_effect")
    return {
        "verdict": {"status": status, "effects": effects, "ambiguous_groups": [{"effects": list(g)} for g in groups]}
    }


SURE_SPRING, SURE_DELAY = ("joint.spring", 0.9, "a"), ("actuator.delay", 0.95, "a")
DOUBTED_SPRING = ("joint.spring", 0.5, "a")


@pytest.mark.parametrize(
    ("truth", "said", "category"),
    [
        (SINGLE, report(SURE_SPRING), Category.NAMED_RIGHT),
        (SINGLE, report(("joint.spring", 0.9, "b")), Category.WRONG_SURE),
        (SINGLE, report(SURE_SPRING, SURE_DELAY), Category.WRONG_SURE),
        (SINGLE, report(DOUBTED_SPRING, groups=(("joint.spring", "joint.detent"),)), Category.RIGHTLY_GROUPED),
        (SINGLE, report(groups=(("joint.detent",),)), Category.DOUBTED),
        (SINGLE, report(("joint.detent", 0.79, "a")), Category.SILENT),
        (SINGLE, report(status="outside_model_class"), Category.UNEXPLAINED),
        (SINGLE, report(), Category.SILENT),
        (SINGLE, {"refused": "gap/no-clock: no time"}, Category.REFUSED),
        (TWO, report(SURE_SPRING, SURE_DELAY), Category.NAMED_RIGHT),
        (TWO, report(SURE_SPRING, groups=(("actuator.delay", "sensor.latency"),)), Category.RIGHTLY_GROUPED),
        (TWO, report(SURE_SPRING), Category.PART),
        (TWIN, report(SURE_DELAY), Category.OVERCONFIDENT),
        (TWIN, report(("sensor.latency", 0.9, "a")), Category.NAMED_EQUAL),
        (TWIN, report(groups=(("actuator.delay", "sensor.latency"),)), Category.RIGHTLY_GROUPED),
        (TWIN, report(SURE_SPRING), Category.WRONG_SURE),
        (OUTSIDE, report(SURE_SPRING), Category.WRONG_SURE),
        (OUTSIDE, report(status="outside_model_class"), Category.UNEXPLAINED),
        (OUTSIDE, report(groups=(("joint.spring",),)), Category.DOUBTED),
        (OUTSIDE, report(), Category.SILENT),
        (LEFT_OUT, report(("joint.gravity_load", 0.9, "a")), Category.WRONG_SURE),
        (LEFT_OUT, report(status="outside_model_class"), Category.UNEXPLAINED),
        (CONTROL, report(SURE_SPRING), Category.FALSE_NAME),
        (CONTROL, report(("joint.spring", 0.4, "a"), groups=(("joint.spring",),)), Category.DOUBTED),
        (CONTROL, report(), Category.SILENT),
    ],
)  # fmt: skip
def test_category(truth: Truth, said: dict, category: Category) -> None:
    assert score(truth, said).category is category


def test_interval_of_a_right_name_holds_the_truth_or_not() -> None:
    assert score(SINGLE, report(SURE_SPRING)).intervals == (True,)
    far = replace(SINGLE, effects=(replace(SPRING, parameters={"stiffness_Nm_per_rad": 3.0}),))
    assert score(far, report(SURE_SPRING)).intervals == (False,)
    assert score(SINGLE, report(("joint.spring", 0.5, "a"))).intervals == ()


def test_table_gives_rates_with_wilson_intervals_and_lists_failures() -> None:
    weaker = replace(SINGLE, miss=1.33, level="large", number=2)
    cases = [
        *[score(SINGLE, report(SURE_SPRING), 30.0)] * 3,
        score(replace(SINGLE, number=77), report(), 30.0),
        score(weaker, report(groups=(("joint.spring", "joint.detent"),))),
        *[score(OUTSIDE, report(status="outside_model_class"))] * 4,
        score(replace(OUTSIDE, number=88), report(SURE_DELAY)),
        *[score(CONTROL, report())] * 2,
        score(replace(SINGLE, kind="free_body"), report()),
    ]
    text = table(cases)
    assert "### Mechanisms: 12 cases" in text
    assert "### Tosses: 1 cases" in text
    assert "| sure wrong names, outside and twin | <= 2 % | 1/5 = 20% (4%-62%) |" in text
    assert "| named or rightly grouped, miss of 6 noise levels | >= 85 % | 3/4 = 75% (30%-95%) |" in text
    assert "| named or rightly grouped, miss of 1.3 noise levels | >= 70 % | 1/1 = 100% (21%-100%) |" in text
    assert "| outside causes called unexplained | >= 80 % | 4/5 = 80% (38%-96%) |" in text
    assert "| false names on controls | <= 5 % | 0/2 = 0% (0%-66%) |" in text
    assert "| 95 % intervals that hold the truth | 90-98 % | 3/3 = 100% (44%-100%) |" in text
    assert "| CPU hours | <= 3 | 0.03 |" in text
    failures = text.partition("Failures:")[2].partition("###")[0]
    assert failures.index("88 outside") < failures.index("77 single")  # wrong names first


def test_small_misses_and_equals_are_no_failures() -> None:
    assert not is_failure(score(replace(SINGLE, miss=0.5), report()))
    assert not is_failure(score(replace(OUTSIDE, accept=("joint.detent",)), report()))
    assert is_failure(score(TWIN, report(SURE_DELAY)))


def test_record_reads_back_as_it_was_written() -> None:
    assert truth_from(TWIN.as_dict()) == TWIN
    record = {"truth": TWIN.as_dict(), "report": report(SURE_DELAY), "cpu_s": 2.0}
    assert scored_record(record) == score(TWIN, report(SURE_DELAY), 2.0)


@pytest.mark.shared
def test_foreign_cases_have_families_and_levels() -> None:
    cases = foreign_cases(SHARED / "measured" / "foreign")
    assert len(cases) == 60
    families = [truth.family for _, truth in cases]
    assert families.count("outside") == 5
    assert all((folder / "measurement.yaml").exists() for folder, _ in cases)
