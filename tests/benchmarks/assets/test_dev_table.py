import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assetkit.geometry.canonical_model import canonicalize
from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.stages.intake import ReadSource
from benchmarks.assets.dev_table import Row, parse_size, row_of, size_error, summary, table, whole_size
from benchmarks.assets.manifest import verdict
from schemas.report import ReportItem
from tests.support.bad_inputs.assets import CUBE, joined, moved, obj_text

sizes = st.lists(st.floats(1e-3, 1e3), min_size=3, max_size=3)


@pytest.mark.parametrize(
    ("text", "size"),
    [("0.1x0.3x0.2", (0.3, 0.2, 0.1)), ("0.0647", (0.0647,)), ("", ()), ("infx1x2", ()), ("1xnanx2", ()), ("a", ())],
)
def test_sizes_are_read_and_sorted(text: str, size: tuple[float, ...]):
    assert parse_size(text) == size


@given(sizes, st.permutations(range(3)))
def test_a_size_has_no_error_against_itself_turned(size: list[float], order: list[int]):
    own = parse_size("x".join(map(repr, size)))
    assert size_error(parse_size("x".join(repr(size[i]) for i in order)), own) == 0.0


def test_errors_are_relative_and_a_sheet_has_no_thickness_to_miss():
    assert size_error((2.0, 1.0, 0.52), (2.0, 1.0, 0.5)) == pytest.approx(0.04)
    assert size_error((2.0, 1.0, 0.002), (2.0, 1.0, 0.0)) == pytest.approx(0.001)
    assert size_error((), (1.0, 1.0, 1.0)) is None
    assert size_error((1.0, 1.0, 1.0), (0.5,)) is None


class FakeRecord:
    """As much of an AssetRecord as the size of a file needs."""

    def __init__(self, section):
        self.geometry = section


def test_packages_of_one_file_are_put_back_where_they_stood(tmp_path):
    path = tmp_path / "two.obj"
    path.write_text(obj_text(joined(CUBE, moved(CUBE, 1.0, 0.2, 0.0)), "# units: m, y-up\n"))
    taken = ReadSource().run(discover([path])[0], Options())
    made = [canonicalize(item, path.name, Options()).value for item in taken.objects]
    assert len(made) == 2
    records = [FakeRecord(canonical.section) for canonical in made if canonical]
    assert whole_size(records) == pytest.approx((1.1, 0.3, 0.1))  # pyright: ignore[reportArgumentType]


KNOWN = {
    "id": "part",
    "format": "glb",
    "outcome": "accept",
    "reason": "scale_review",
    "meters_per_unit": "1",
    "measured_extent_native": "1x2x3",
    "dims_m": "",
    "mass_kg": "0.2",
}


def test_a_rejected_asset_is_a_row_too():
    row = row_of(KNOWN, {"outcome": "rejected", "seconds": {}}, [])
    assert "part" in table([row])
    assert "1 rejected" in summary([row])


def sized(off: float, unit: str, mass: tuple[float, float]) -> Row:
    return Row(
        "a", "glb", "accepted", "accept", 1, "box", 1, 1.0, 0.001, 0.2, mass, 0.2, (3.0,), (3.0,), off, unit, (), 1.0
    )


def test_what_is_wrong_is_marked_and_counted():
    rows = [sized(0.005, "declared", (0.1, 0.3)), sized(0.02, "declared", (0.3, 0.4)), sized(0.5, "default", (0, 1))]
    assert table(rows).count(" !") == 2
    assert "1 of 2 sizes within 1 %" in summary(rows)
    assert "bounds: 2 of 3" in summary(rows)
    assert math.isfinite(rows[0].seconds)


@pytest.mark.parametrize(
    ("reason", "outcome", "expected"),
    [
        ("scale_review", "review", "ok"),
        ("scale_review", "accepted", "ok"),
        ("", "review", "differs"),
        ("", "rejected", "differs"),
    ],
)
def test_review_is_right_only_where_the_row_asks_for_it(reason: str, outcome: str, expected: str):
    item = ReportItem.model_validate({"source": "a", "outcome": outcome})
    assert verdict(KNOWN | {"reason": reason}, item) == expected
