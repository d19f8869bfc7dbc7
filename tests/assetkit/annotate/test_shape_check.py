"""Size, opening and form confirm or contradict a category, by laws that hold for every row of the table."""

import numpy as np
import pytest
import trimesh

from assetkit.annotate.annotator import ObjectShape
from assetkit.annotate.shape_check import ANOTHER, FITS, NOT_OPEN, STRANGE, compare, misfit, shape_of
from assetkit.taxonomy.tables import Category, categories
from schemas.physics import Solid

ALL = list(categories().values())


def solid(mesh: trimesh.Trimesh) -> tuple[np.ndarray, Solid]:
    points = np.asarray(mesh.vertices, dtype=np.float64)
    return points, Solid(points, mesh.faces.astype(np.int32), "closed")


@pytest.mark.parametrize("category", ALL, ids=lambda c: c.id)
def test_a_thing_in_the_middle_of_its_ranges_fits_and_one_of_ten_times_the_largest_is_another(category: Category):
    x, y, z = (float(np.sqrt(low * high)) for low, high in category.extents_m)
    usual = (x, y, z)
    assert misfit(category, usual) == 1.0
    assert [f.confirms for f in compare(category, ObjectShape(usual, None, None))] == [FITS]
    x, y, z = (10.0 * high for _, high in category.extents_m)
    giant = (x, y, z)
    assert [f.remaining_chance for f in compare(category, ObjectShape(giant, None, None))] == [ANOTHER]


def test_misfit_is_the_worst_factor_in_either_direction():
    mug = categories()["mug"]
    small, middle, large = (low for low, _ in mug.extents_m)
    assert misfit(mug, (small / 2.0, middle, large)) == pytest.approx(2.0)
    assert [f.remaining_chance for f in compare(mug, ObjectShape((small / 2.0, middle, large), None, None))] == [
        STRANGE
    ]


@pytest.mark.parametrize(
    ("mesh", "fill"),
    [
        (trimesh.creation.box((0.1, 0.2, 0.3)), 1.0),
        (trimesh.creation.cylinder(0.04, 0.12, sections=128), np.pi / 4.0),
        (trimesh.creation.icosphere(4, 0.05), np.pi / 6.0),
    ],
)
def test_fill_of_ideal_bodies_however_they_lie(mesh: trimesh.Trimesh, fill: float):
    straight = shape_of(*solid(mesh))
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.7, (1.0, 2.0, 3.0)))
    for shape in (straight, shape_of(*solid(mesh))):
        assert shape.fill == pytest.approx(fill, rel=0.03)
        assert shape.hollow == pytest.approx(0.0, abs=0.02)
    assert shape_of(*solid(mesh)).extents_m == pytest.approx(straight.extents_m, rel=0.03)


def test_a_closed_block_is_no_mug_and_a_tube_with_a_bottom_is():
    mug = categories()["mug"]
    block = shape_of(*solid(trimesh.creation.cylinder(0.04, 0.09, sections=64)))
    assert NOT_OPEN in [f.remaining_chance for f in compare(mug, block)]
    tube = trimesh.creation.annulus(0.036, 0.04, 0.09, sections=64)
    assert all(f.remaining_chance == 1.0 for f in compare(mug, shape_of(*solid(tube))))


def test_a_flat_sheet_has_a_size_and_no_more():
    points = np.array([[0, 0, 0], [0.2, 0, 0], [0.2, 0.2, 0], [0, 0.2, 0]], dtype=np.float64)
    sheet = Solid(points, np.array([[0, 1, 2], [0, 2, 3]], np.int32), "shell", wall_thickness_m=1e-3)
    assert shape_of(points, sheet) == ObjectShape((0.0, 0.2, 0.2), None, None)
    assert any(f.remaining_chance == ANOTHER for f in compare(categories()["plate"], shape_of(points, sheet)))
