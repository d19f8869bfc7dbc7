import pytest

from assetkit.units import UnitDecision, decide_unit
from schemas.diagnostics import InvalidInput
from schemas.evidence import Evidence, declared, default

UNKNOWN = default(1.0)


def decide(
    extent: tuple[float, float, float],
    *,
    stated: Evidence[float] = UNKNOWN,
    chosen="auto",
    format_="obj",
    stem="part",
    hints: tuple[str, ...] = (),
) -> UnitDecision:
    return decide_unit(stated=stated, chosen=chosen, extent=extent, format_=format_, stem=stem, hints=hints)


def test_user_beats_file_and_is_declared():
    decision = decide((80, 80, 95), stated=declared(1.0, "file"), chosen="mm")
    assert decision.meters_per_unit.value == 0.001
    assert decision.meters_per_unit.source == "declared"
    assert decision.repairs == ()


def test_declared_unit_is_never_overruled_but_an_unusual_size_is_reported():
    decision = decide((180.0, 60.0, 60.0), stated=declared(1.0, "glTF"))
    assert decision.meters_per_unit.value == 1.0
    assert decision.meters_per_unit.confidence < 1.0
    assert [d.code for d in decision.diagnostics] == ["asset/scale-unverified"]
    assert decision.diagnostics[0].value == 180.0


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
    assert [r.name for r in decision.repairs] == [unit]
    assert decision.repairs[0].after["largest_extent_m"] == pytest.approx(10.0 * scale)


def test_comment_naming_metres_confirms_the_habit_without_a_repair():
    decision = decide((1.2, 0.5, 0.5), hints=("units: meters",))
    assert decision.meters_per_unit.value == 1.0
    assert decision.meters_per_unit.source == "inferred"
    assert decision.repairs == ()


def test_contradicting_comments_are_no_evidence():
    decision = decide((0.2, 0.1, 0.1), hints=("units: mm", "units: cm"))
    assert decision.meters_per_unit.value == 1.0


def test_an_ordinary_word_is_not_a_unit():
    decision = decide((0.2, 0.1, 0.1), hints=("scale this in Blender; made in Maya",))
    assert decision.meters_per_unit.value == 1.0
    assert decision.repairs == ()


def test_size_in_the_file_name_counts_only_when_the_mesh_has_it():
    assert decide((20.0, 20.0, 20.0), stem="20mm_xyz_cube", format_="stl").repairs[0].name == "unit_mm"
    other = decide((0.31, 0.2, 0.2), stem="20mm_xyz_cube")
    assert other.repairs == ()


def test_stl_of_household_size_in_millimetres_is_recognised():
    decision = decide((33.0, 33.0, 60.0), format_="stl", stem="pipe_elbow")
    assert decision.meters_per_unit.value == 0.001
    assert {d.code for d in decision.diagnostics} == {"asset/unit-mismatch", "asset/scale-unverified"}
    assert decision.meters_per_unit.confidence < 0.9


def test_lengths_of_an_inch_designer_are_recognised():
    assert decide((1.33858, 1.0, 1.35198), format_="stl").repairs[0].name == "unit_inch"
    assert decide((5.0, 2.5, 1.375), format_="stl").repairs[0].name == "unit_inch"


def test_a_shelf_in_metres_is_not_taken_for_inches():
    assert decide((0.879534, 2.36728, 0.884222), format_="stl").meters_per_unit.value == 1.0


def test_ambiguous_size_keeps_metres_and_says_so():
    decision = decide((2.0, 2.0, 3.0))
    assert decision.meters_per_unit.value == 1.0
    assert decision.meters_per_unit.source == "default"
    assert decision.meters_per_unit.confidence == 0.0
    low, high = decision.meters_per_unit.bounds or (1.0, 1.0)
    assert low <= 0.01
    assert high >= 1.0
    assert [d.code for d in decision.diagnostics] == ["asset/scale-unverified"]


@pytest.mark.parametrize("largest", [1e-9, 1e9])
def test_impossible_sizes_are_refused_with_value_and_bound(largest: float):
    with pytest.raises(InvalidInput) as refused:
        decide((largest, largest, largest))
    assert refused.value.diagnostic.code == "asset/scale-implausible"
    assert refused.value.diagnostic.value == largest
