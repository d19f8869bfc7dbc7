"""The scale of numbers without a unit, by what the thing is."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assetkit.options import METERS_PER_UNIT
from assetkit.scale.metric_scale import ScaleEstimate, estimate_scale, is_normalised
from assetkit.scale.size_prior import CATEGORY_PRECISION, size_prior
from assetkit.taxonomy.tables import categories, size_anchors

MUG = (0.081, 0.097, 0.118)


def asked(edges: tuple[float, ...], category: str | None) -> ScaleEstimate:
    x, y, z = edges
    return estimate_scale((x, y, z), sorted(edges), categories().get(category or ""), CATEGORY_PRECISION, format_="obj")


@pytest.mark.parametrize("unit", METERS_PER_UNIT)
def test_each_unit_is_found_by_the_size_of_the_category(unit: str) -> None:
    edges = tuple(e / METERS_PER_UNIT[unit] for e in MUG)
    scale = asked(edges, "mug")
    assert scale.meters_per_unit.value == METERS_PER_UNIT[unit]
    assert not scale.review


def test_a_normalised_mug_gets_the_size_of_a_mug_with_bounds() -> None:
    evidence = asked(tuple(e / max(MUG) for e in MUG), "mug").meters_per_unit
    assert evidence.bounds is not None
    assert evidence.bounds[0] < max(MUG) < evidence.bounds[1]
    assert evidence.value == pytest.approx(max(MUG), rel=0.2)
    assert evidence.source == "inferred"
    assert evidence.confidence < 0.6


def test_normalised_numbers_of_an_unknown_thing_go_to_a_person() -> None:
    scale = asked((0.31, 0.72, 1.0), None)
    bounds = scale.meters_per_unit.bounds
    assert scale.review
    assert bounds is not None
    assert bounds[1] > 20 * bounds[0]


def test_a_size_that_no_unit_makes_usual_goes_to_a_person_with_bounds_that_hold_it() -> None:
    scale = asked(tuple(7.3 * e for e in MUG), "mug")
    bounds = scale.meters_per_unit.bounds
    assert scale.review
    assert bounds is not None
    assert bounds[0] < 1 / 7.3 < bounds[1]


@given(st.floats(1e-3, 1e3), st.sampled_from(sorted(categories())))
def test_a_belief_scales_with_the_numbers(factor: float, category: str) -> None:
    edges = [math.sqrt(low * high) for low, high in categories()[category].extents_m]
    one = size_prior(edges, categories()[category], CATEGORY_PRECISION).quantiles((0.1, 0.5, 0.9))
    other = size_prior([factor * e for e in edges], categories()[category], CATEGORY_PRECISION).quantiles(
        (0.1, 0.5, 0.9)
    )
    assert other == pytest.approx([q / factor for q in one], rel=1e-3)
    assert one[0] < 1.0 < one[2]


def test_a_cube_of_side_one_is_not_called_normalised() -> None:
    assert not is_normalised((1.0, 1.0, 1.0))
    assert is_normalised((0.3, 1.0, 0.5))
    assert is_normalised((0.6, 0.8, 1e-9))
    assert not is_normalised((0.3, 1.1, 0.5))


def test_things_of_known_size_lie_within_the_ranges_of_their_category() -> None:
    for anchor in size_anchors():
        for edge, (low, high) in zip(anchor.edges_mm, categories()[anchor.category].extents_m, strict=True):
            assert low <= edge / 1000.0 <= high, anchor.name
        assert list(anchor.edges_mm) == sorted(anchor.edges_mm)
    assert {a.category for a in size_anchors()} == set(categories())
