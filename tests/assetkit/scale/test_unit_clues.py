import numpy as np
import pytest

from assetkit.scale.unit_clues import scaled_nodes, stated_in_name, stated_in_text
from schemas.model import Node

EXTENT = (12.0, 8.0, 3.0)


def scales(*texts: str) -> set[float]:
    return {c.meters_per_unit for c in stated_in_text(texts, EXTENT)}


@pytest.mark.parametrize(
    ("text", "scale"),
    [
        ("# Units: mm", 0.001),
        ("COLOR=\xff,MATERIAL=,UNITS=mm", 0.001),
        ("comment unit m", 1.0),
        ('unit = "in"', 0.0254),
        ("obj_info length unit: centimeter", 0.01),
        ("# This file uses centimeters as units for non-parametric coordinates.", 0.01),
        ("# File units = inches", 0.0254),
        ("# 1 unit = 1 cm", 0.01),
        ("1 unit = 0.001 m (scale in arm.urdf)", 0.001),
        ("unit: 10 mm", 0.01),
        ("metersPerUnit: 0.01", 0.01),
        ("meters_per_unit = 2.54e-2", 0.0254),
        ("units per meter: 1000", 0.001),
        ("converted from mm to units of m", 1.0),
        ("millimetre units", 0.001),
        ("coordinates are in feet", 0.3048),
        ("measured in m", 1.0),
        ("all lengths: in;", 0.0254),
        ("scanned object, 12 x 8 x 3 cm", 0.01),
        ("Dimensions: 120 mm by 80 mm", 0.01),
    ],
)
def test_a_text_states_the_unit(text: str, scale: float):
    assert list(scales(text)) == [pytest.approx(scale)]


@pytest.mark.parametrize(
    "text",
    [
        "scale this in Blender; made in Maya",
        "Dimensions: 40 mm by 20 mm",  # of something the mesh is not
        "exported by John M.",
        "meters per unit",
        "unitsResolve",
        "United Kingdom, 100 m from the sea",
        "from mm",
        "exported in",
        "to scale in.",
        "# 8 vertices in 1 mesh",
        "inch by inch",
    ],
)
def test_other_texts_do_not(text: str):
    assert scales(text) == set()


def test_every_line_is_heard():
    assert scales("units: mm\nunits: cm", "nothing") == {0.001, 0.01}


@pytest.mark.parametrize(
    ("name", "extent", "found"),
    [
        ("a/20mm-cube", (20.0, 20.0, 20.0), {0.001}),
        ("a/20mm-cube", (0.02, 0.02, 0.02), {1.0}),
        ("a/20mm-cube", (0.787, 0.787, 0.787), {0.0254}),
        ("a/40x20x10mm", (40.0, 10.0, 20.0), {0.001}),
        ("a/40x20x10mm", (40.0, 11.0, 20.0), set()),
        ("a/20mm_part", (20.0, 2.0, 1.0), set()),  # 20 mm and 2 cm both fit
        ("a/bracket_mm", (3.0, 2.0, 1.0), {0.001}),
        ("meshes-cm/bracket", (3.0, 2.0, 1.0), {0.01}),
        ("a/bracket (inches)", (3.0, 2.0, 1.0), {0.0254}),
        ("a/hammer_common", (3.0, 2.0, 1.0), set()),
        ("a/part_in_two", (3.0, 2.0, 1.0), set()),
        ("a/part_m", (3.0, 2.0, 1.0), set()),
    ],
)
def test_a_name_tells_the_unit_by_a_size_or_a_word(name: str, extent: tuple[float, float, float], found: set[float]):
    assert {c.meters_per_unit for c in stated_in_name(name, extent)} == found


def node(path: str, scale: float, meshes: tuple[int, ...] = ()) -> Node:
    return Node(path, np.diag([scale, scale, scale, 1.0]), meshes)


def test_a_conversion_factor_counts_only_when_all_meshes_share_it():
    root = node("/top", 100.0)
    [clue] = scaled_nodes((root, node("/top/a", 1.0, (0,)), node("/top/b", 1.0, (1,))), 1.0)
    assert clue.meters_per_unit == pytest.approx(0.01)
    assert scaled_nodes((root, node("/top/a", 1.0, (0,)), node("/b", 1.0, (1,))), 1.0) == []
    assert scaled_nodes((node("/top", 7.0, (0,)),), 1.0) == []
    assert scaled_nodes((node("/top", 100.0), node("/top/a", 0.01, (0,))), 1.0) == []
    assert scaled_nodes((), 1.0) == []


def test_endless_lines_cost_no_time():
    assert scales("1" * 1_000_000, "units " + "1x" * 500_000, "x" * 500_000 + " units: mm") == set()
