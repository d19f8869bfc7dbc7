"""The unit as a decision: a table of situations, and laws that hold for all of them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assetkit.options import METERS_PER_UNIT
from assetkit.scale.declared_units import CREDIBLE_M, USUAL_M, UnitDecision, UnitName, decide_unit
from schemas.diagnostics import InvalidInput
from schemas.evidence import Evidence, declared, default
from schemas.model import Node

UNKNOWN = default(1.0)
METRES = declared(1.0, "glTF")
CENTIMETRES = declared(0.01, "metersPerUnit")
BY_STANDARD_M = declared(1.0, "COLLADA default unit", confidence=0.5)
BY_STANDARD_CM = declared(0.01, "USD fallback", confidence=0.5)
BELOW_100 = (Node("/top", np.diag([100.0, 100.0, 100.0, 1.0])), Node("/top/part", np.eye(4), (0,)))


def decide(
    extent: tuple[float, float, float],
    *,
    stated: Evidence[float] = UNKNOWN,
    chosen: UnitName = "auto",
    format_="obj",
    name="folder/part",
    hints: tuple[str, ...] = (),
    nodes: tuple[Node, ...] = (),
) -> UnitDecision:
    return decide_unit(
        stated=stated, chosen=chosen, extent=extent, format_=format_, name=name, hints=hints, nodes=nodes
    )


def codes(decision: UnitDecision) -> set[str]:
    return {d.code.removeprefix("asset/") for d in decision.diagnostics}


def cube(side: float) -> tuple[float, float, float]:
    return (side, 0.8 * side, 0.7 * side)


def test_user_beats_file_and_is_declared():
    decision = decide((80, 80, 95), stated=METRES, chosen="mm", hints=("units: cm",))
    assert decision.meters_per_unit.value == 0.001
    assert decision.meters_per_unit.source == "declared"
    assert decision.repairs == ()


# (what is stated, largest extent in source units, further signs) -> (metres per unit, outcome, codes)
CONTRADICTIONS = {
    "glTF 180 m tall": (METRES, 180.0, {}, 1.0, "review", {"contradictory-evidence"}),
    "glTF 120 m bottle": (METRES, 120.0, {"name": "kitchen/bottle"}, 1.0, "review", {"contradictory-evidence"}),
    "glTF 180 m, file called _mm": (
        METRES,
        180.0,
        {"name": "kitchen/bottle_mm"},
        0.001,
        "repaired",
        {"contradictory-evidence", "unit-mismatch"},
    ),
    "glTF 180 m, extras say mm": (
        METRES,
        180.0,
        {"hints": ("units: mm",)},
        0.001,
        "repaired",
        {"contradictory-evidence", "unit-mismatch"},
    ),
    "glTF 180 m, top node scaled by 100": (
        METRES,
        180.0,
        {"nodes": BELOW_100},
        0.01,
        "repaired",
        {"contradictory-evidence", "unit-mismatch"},
    ),
    "glTF 180 m, extras say metres": (
        METRES,
        180.0,
        {"hints": ("unit: metre",)},
        1.0,
        "review",
        {"contradictory-evidence"},
    ),
    "glTF 0.3 mm": (METRES, 0.0003, {}, 1.0, "review", {"contradictory-evidence"}),
    "glTF 40 m": (METRES, 40.0, {}, 1.0, "accepted", {"scale-unverified"}),
    "glTF of usual size, node scaled by 100": (METRES, 0.3, {"nodes": BELOW_100}, 1.0, "accepted", set()),
    "glTF of usual size, texts say mm": (
        METRES,
        0.3,
        {"hints": ("units: mm",)},
        1.0,
        "accepted",
        {"contradictory-evidence"},
    ),
    "glTF 0.3 m, file called _mm": (METRES, 0.3, {"name": "a/part_mm"}, 1.0, "accepted", set()),
    "USD says cm, numbers are metres": (CENTIMETRES, 0.05, {}, 0.01, "review", {"contradictory-evidence"}),
    "USD silent, numbers are metres": (BY_STANDARD_CM, 0.2, {}, 0.01, "accepted", {"scale-unverified"}),
    "USD silent, impossible as cm": (
        BY_STANDARD_CM,
        0.05,
        {},
        1.0,
        "repaired",
        {"unit-mismatch", "scale-unverified"},
    ),
    "USD silent, usual as cm": (BY_STANDARD_CM, 2.0, {}, 0.01, "accepted", set()),
    "USD silent, comment says mm": (
        BY_STANDARD_CM,
        80.0,
        {"hints": ("units are mm",)},
        0.001,
        "repaired",
        {"unit-mismatch"},
    ),
    "DAE silent, 180 units": (BY_STANDARD_M, 180.0, {}, 0.001, "repaired", {"unit-mismatch", "scale-unverified"}),
    "DAE silent, 90 units": (BY_STANDARD_M, 90.0, {}, 1.0, "accepted", {"scale-unverified"}),
    "DAE silent, 2 units": (BY_STANDARD_M, 2.0, {}, 1.0, "accepted", set()),
    "DAE silent, unit called inch": (
        BY_STANDARD_M,
        20.0,
        {"hints": ("unit name: inch",)},
        0.0254,
        "repaired",
        {"unit-mismatch"},
    ),
    "STL 0.08": (UNKNOWN, 0.08, {"format_": "stl"}, 1.0, "accepted", {"scale-unverified"}),
    "STL 80": (UNKNOWN, 80.0, {"format_": "stl"}, 0.001, "repaired", {"unit-mismatch", "scale-unverified"}),
    "STL 3.1": (UNKNOWN, 3.1, {"format_": "stl"}, None, None, {"scale-unverified"}),
    "STL 8000": (UNKNOWN, 8000.0, {"format_": "stl"}, 0.001, "repaired", {"unit-mismatch", "scale-unverified"}),
    "STL 1e-4": (UNKNOWN, 1e-4, {"format_": "stl"}, 1.0, "review", {"contradictory-evidence"}),
    "OBJ says mm, is 0.2": (UNKNOWN, 0.2, {"hints": ("units: mm",)}, 1.0, "review", {"contradictory-evidence"}),
    "OBJ says mm and cm, only mm fits": (
        UNKNOWN,
        800.0,
        {"hints": ("units: mm", "units: cm")},
        0.001,
        "repaired",
        {"contradictory-evidence", "unit-mismatch"},
    ),
    "OBJ says mm and cm, both fit": (
        UNKNOWN,
        80.0,
        {"hints": ("units: mm", "units: cm")},
        1.0,
        "review",
        {"contradictory-evidence"},
    ),
    "OBJ says mm, name says cm": (
        UNKNOWN,
        80.0,
        {"hints": ("units: mm",), "name": "a/part_cm"},
        0.001,
        "repaired",
        {"unit-mismatch"},
    ),
}


@pytest.mark.parametrize("case", CONTRADICTIONS)
def test_contradictions_are_settled_by_evidence_or_by_a_person(case: str):
    stated, largest, signs, scale, outcome, expected = CONTRADICTIONS[case]
    decision = decide(cube(largest), stated=stated, **signs)
    evidence = decision.meters_per_unit
    if scale is not None:
        assert evidence.value == pytest.approx(scale)
        assert "review" if decision.review else ("repaired" if decision.repairs else "accepted") == outcome
        assert decision.review == (outcome == "review")
    assert expected <= codes(decision)
    if not expected:
        assert decision.diagnostics == ()
    if decision.review:
        assert evidence.confidence == 0.0
    for repair in decision.repairs:
        assert repair.after["largest_extent_m"] == pytest.approx(largest * evidence.value)


@given(
    stated=st.sampled_from([UNKNOWN, METRES, CENTIMETRES, BY_STANDARD_M, BY_STANDARD_CM]),
    log_size=st.floats(-3.9, 3.9),
    format_=st.sampled_from(["stl", "obj", "gltf"]),
    hint=st.sampled_from(["", "units: mm", "units: cm", "unit = inch", "1 unit = 0.1 m"]),
    name=st.sampled_from(["a/part", "a/part_mm", "a/20mm_part"]),
)
def test_no_decision_is_silent_or_sure_of_a_guess(stated, log_size: float, format_: str, hint: str, name: str):
    size = 10**log_size
    try:
        decision = decide(cube(size), stated=stated, format_=format_, hints=(hint,), name=name)
    except InvalidInput:
        return  # Impossible in every unit.
    evidence = decision.meters_per_unit
    size_m = size * evidence.value
    if evidence.bounds is not None:
        assert evidence.bounds[0] <= evidence.value <= evidence.bounds[1]
    if not 0.99 * CREDIBLE_M[0] <= size_m <= 1.01 * CREDIBLE_M[1]:
        assert decision.review
    if not 0.99 * USUAL_M[0] <= size_m <= 1.01 * USUAL_M[1]:
        assert evidence.confidence <= 0.5
        assert decision.diagnostics
    if decision.review or evidence.source == "default":
        assert evidence.confidence == 0.0
        assert decision.diagnostics
    if evidence.source == "default":  # Only a person knows.
        assert decision.review
        assert evidence.bounds is not None or "contradictory-evidence" in codes(decision)
    if decision.review and stated in (METRES, CENTIMETRES):
        assert not USUAL_M[0] <= size_m <= USUAL_M[1]
    if not math.isclose(evidence.value, stated.value):
        assert decision.repairs
        assert evidence.source != "declared"
        assert evidence.confidence <= 0.9
    if stated is METRES and USUAL_M[0] <= size <= USUAL_M[1]:
        assert evidence.value == 1.0
        assert evidence.source == "declared"


@pytest.mark.parametrize(
    ("comment", "unit", "scale"),
    [
        ("units: mm", "unit_mm", 0.001),
        ("exported in centimetres", "unit_cm", 0.01),
        ("# All dimensions in inches.", "unit_inch", 0.0254),
        ("Scale is in millimeters;", "unit_mm", 0.001),
    ],
)
def test_comment_names_the_unit(comment: str, unit: str, scale: float):
    decision = decide((10.0, 5.0, 5.0), hints=(comment,))
    assert decision.meters_per_unit.value == scale
    assert decision.meters_per_unit.inputs == (comment,)
    assert [r.name for r in decision.repairs] == [unit]
    assert decision.repairs[0].after["largest_extent_m"] == pytest.approx(10.0 * scale)


def test_comment_naming_metres_confirms_the_habit_without_a_repair():
    decision = decide((1.2, 0.5, 0.5), hints=("units: meters",))
    assert decision.meters_per_unit.value == 1.0
    assert decision.meters_per_unit.source == "inferred"
    assert decision.repairs == ()


def test_size_in_the_file_name_counts_only_when_the_mesh_has_it():
    assert decide((20.0, 20.0, 20.0), name="20mm_xyz_cube", format_="stl").repairs[0].name == "unit_mm"
    other = decide((0.31, 0.2, 0.2), name="20mm_xyz_cube")
    assert other.repairs == ()


def test_stl_of_household_size_in_millimetres_is_recognised():
    decision = decide((33.0, 33.0, 60.0), format_="stl", name="pipe_elbow")
    assert decision.meters_per_unit.value == 0.001
    assert codes(decision) == {"unit-mismatch", "scale-unverified"}
    assert decision.meters_per_unit.confidence < 0.9


def test_lengths_of_an_inch_designer_are_recognised():
    assert decide((1.33858, 1.0, 1.35198), format_="stl").repairs[0].name == "unit_inch"
    assert decide((5.0, 2.5, 1.375), format_="stl").repairs[0].name == "unit_inch"


def test_a_shelf_in_metres_is_not_taken_for_inches():
    assert decide((0.879534, 2.36728, 0.884222), format_="stl").meters_per_unit.value == 1.0


def test_ambiguous_size_keeps_metres_for_a_person_to_decide():
    decision = decide((2.0, 2.0, 3.0))
    assert decision.review
    assert decision.meters_per_unit.value == 1.0
    assert decision.meters_per_unit.source == "default"
    assert decision.meters_per_unit.confidence == 0.0
    low, high = decision.meters_per_unit.bounds or (1.0, 1.0)
    assert low <= 0.01
    assert high >= 1.0
    assert codes(decision) == {"scale-unverified"}


def test_a_placeholder_is_never_a_reading_that_is_hardly_possible():
    decision = decide((6.2, 8.0, 3.3), format_="stl")
    assert decision.meters_per_unit.source == "default"
    assert decision.meters_per_unit.value < 1.0
    low, high = decision.meters_per_unit.bounds or (1.0, 1.0)
    assert low <= METERS_PER_UNIT["cm"] <= high < 1.0
    assert codes(decision) == {"unit-mismatch", "scale-unverified"}
    assert decision.review


@pytest.mark.parametrize(
    ("extent", "format_", "hints", "true_size", "true_scale"),
    [
        ((3.0, 2.0, 3.0), "stl", (), "in 76.2 mm", 0.0254),
        ((12.0, 8.0, 5.0), "stl", (), "in 305 mm", 0.0254),
        ((2.0, 1.5, 1.0), "obj", ("# https://github.com/mikedh/trimesh",), "in 50.8 mm", 0.0254),
        ((25.0, 18.0, 3.0), "obj", ("# https://github.com/mikedh/trimesh",), "cm 250 mm", 0.01),
    ],
)
def test_a_guess_that_is_hardly_better_than_the_others_goes_to_a_person(extent, format_, hints, true_size, true_scale):
    decision = decide(extent, format_=format_, hints=hints)
    assert decision.review
    (note,) = (d for d in decision.diagnostics if d.code == "asset/scale-unverified")
    assert true_size in note.headline
    assert (note.bound, note.unit) == (0.6, "probability of the first")
    low, high = decision.meters_per_unit.bounds or (1.0, 1.0)
    assert low <= true_scale <= high


@pytest.mark.parametrize("side", [1.0, 2.0])
def test_a_tools_first_cube_stands_in_scene_units_but_not_where_cad_writes(side: float):
    drawn = decide((side, side, side))
    assert not drawn.review
    assert drawn.meters_per_unit.value == 1.0
    assert drawn.meters_per_unit.confidence < 0.8
    cad = decide((2.0, 2.0, 2.0), format_="stl")
    assert cad.review
    assert decide((2.0, 1.5, 1.0)).review


def test_the_tool_that_wrote_a_file_counts_more_than_its_format():
    plain, blender = (decide((1.5, 1.0, 0.7), format_="stl", hints=h) for h in ((), ("Exported from Blender-2.79",)))
    assert plain.meters_per_unit.source == "default"
    assert blender.meters_per_unit.source == "inferred"
    assert blender.meters_per_unit.value == 1.0


@pytest.mark.parametrize("stated", [UNKNOWN, METRES])
@pytest.mark.parametrize("largest", [1e-9, 1e9])
def test_impossible_sizes_are_refused_with_value_and_bound(largest: float, stated: Evidence[float]):
    with pytest.raises(InvalidInput) as refused:
        decide((largest, largest, largest), stated=stated)
    assert refused.value.diagnostic.code == "asset/scale-implausible"
    assert refused.value.diagnostic.value == largest
