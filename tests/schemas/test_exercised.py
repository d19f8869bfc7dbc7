"""Ranges that may be drawn from: no pair within was seen to fail, and nothing is given away without need."""

from __future__ import annotations

import math
from itertools import product

import hypothesis.strategies as st
import pytest
from hypothesis import given

from schemas.acceptance import Corner, Margin, SuiteSection
from schemas.exercised import exercised

FRICTION, MASS_KG = 0.5, 0.2
BELOW, ABOVE = st.floats(0.2, 1.0), st.floats(1.0, 4.0)


def margin(quantity, value: float, low: float, high: float, bounds: tuple[float, float]) -> Margin:
    return Margin(quantity=quantity, low=value * low, high=value * high, bounds=(value * bounds[0], value * bounds[1]))


@st.composite
def suite(draw: st.DrawFn) -> SuiteSection:
    """A suite that passed on record, with bounds of its own draw, margins within them, and corners that may fail."""
    margins, ends = [], []
    for quantity, value in (("friction", FRICTION), ("mass_kg", MASS_KG)):
        bounds = (draw(BELOW), draw(ABOVE))
        low = draw(st.sampled_from([bounds[0], math.sqrt(bounds[0]), 1.0]))
        high = draw(st.sampled_from([bounds[1], math.sqrt(bounds[1]), 1.0]))
        margins.append(margin(quantity, value, low, high, bounds))
        ends.append(margins[-1].bounds)
    corners = [Corner(friction=f, mass_kg=m, passed=draw(st.booleans())) for f, m in product(*ends)]
    name = draw(st.sampled_from(["common", "manipulated", "tool"]))
    return SuiteSection(name=name, outcome="passed", margins=tuple(margins), corners=tuple(corners))


@given(st.lists(suite(), min_size=1, max_size=3))
def test_no_pair_within_the_ranges_lies_at_or_beyond_what_failed(suites: list[SuiteSection]):
    limits = exercised(suites, friction=FRICTION, mass_kg=MASS_KG)
    ranges = {"friction": limits.friction, "mass_kg": limits.mass_kg}
    for each in ranges.values():
        assert each.low <= each.value <= each.high
    for one in suites:
        for each in one.margins:
            assert each.low <= ranges[each.quantity].low
            assert ranges[each.quantity].high <= each.high
        for corner in (c for c in one.corners if not c.passed):
            beyond = [
                any(
                    end != each.value and math.copysign(1.0, end - each.value) * (end - at) >= -1e-12
                    for end in ((each.low,) if at < each.value else (each.high,))
                )
                for each, at in ((limits.friction, corner.friction), (limits.mass_kg, corner.mass_kg))
            ]
            assert not all(beyond)
    assert exercised(suites, friction=FRICTION, mass_kg=MASS_KG) == limits


def test_where_nothing_fails_all_of_the_bounds_stay_and_nobody_limits_them():
    margins = (margin("friction", FRICTION, 0.5, 1.6, (0.5, 1.6)), margin("mass_kg", MASS_KG, 0.7, 2.0, (0.7, 2.0)))
    found = exercised(
        [SuiteSection(name="common", outcome="passed", margins=margins)], friction=FRICTION, mass_kg=MASS_KG
    )
    assert (found.friction.low, found.friction.high) == pytest.approx((0.25, 0.8))
    assert (found.mass_kg.low, found.mass_kg.high) == pytest.approx((0.14, 0.4))
    assert found.friction.limited_by == found.mass_kg.limited_by == ()
    assert found.friction.holds(0.25)
    assert not found.friction.holds(0.24)


def test_a_failed_corner_costs_the_end_that_loses_less():
    bounds = {"friction": (0.5, 1.2), "mass_kg": (0.7, 3.0)}
    margins = tuple(
        margin(quantity, value, *bounds[quantity], bounds[quantity])
        for quantity, value in (("friction", FRICTION), ("mass_kg", MASS_KG))
    )
    corner = Corner(friction=margins[0].high, mass_kg=margins[1].high, passed=False)
    section = SuiteSection(name="tool", outcome="passed", margins=margins, corners=(corner,))
    found = exercised([section], friction=FRICTION, mass_kg=MASS_KG)
    assert found.friction.high == FRICTION
    assert found.friction.limited_by == ("tool",)
    assert found.mass_kg.high == pytest.approx(3.0 * MASS_KG)


@pytest.mark.parametrize("outcome", ["failed", "not_run"])
def test_without_a_suite_that_passed_only_the_value_on_record_was_exercised(outcome):
    margins = (margin("friction", FRICTION, 0.5, 1.6, (0.5, 1.6)),)
    for suites in ([], [SuiteSection(name="common", outcome=outcome, margins=margins)]):
        found = exercised(suites, friction=FRICTION, mass_kg=MASS_KG)
        assert (found.friction.low, found.friction.high) == (FRICTION, FRICTION)
        assert (found.mass_kg.low, found.mass_kg.high) == (MASS_KG, MASS_KG)
