"""Closed bodies and open sheets in one asset: bodies stay solid, sheets get walls, mouths that nobody sees are filled.

All against closed forms: a mitred wall of thickness t around a box of sheets is a box outside less a box inside.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from assetkit.options import Options
from geom.features.cavities import find_cavities
from geom.mesh.topology import observe
from geom.mesh.weld import diagonal
from geom.solid.solid_distance import solid_distance
from geom.solid.solid_volume import volume_properties
from geom.solid.solidify import assumed_wall_m, solidify
from tests.support.mass_samples import weighed
from tests.support.sample_surfaces import box, lidless, mesh_of
from tests.support.sample_surfaces import cylinder as cylinder_about_origin

T = 0.002
BLOCK = box((0.2, 0.2, 0.1), at=(0, 0, 0.05))
TRAY = lidless(box((0.2, 0.2, 0.06), at=(0, 0, 0.13)))  # stands on the block, its mouth up
TURNED = Rotation.from_rotvec([0.3, -0.7, 1.1]).as_matrix()


def tray_wall(a: float, b: float, height: float, t: float) -> float:
    """Volume of a mitred wall of `t` around five sides of a box: it ends at the rim."""
    return (a + t) * (b + t) * (height + t / 2) - (a - t) * (b - t) * (height - t / 2)


def cylinder(radius: float, height: float, at):
    points, triangles = cylinder_about_origin(radius, height)
    return points + np.asarray(at), triangles


def turned(surface):
    return surface[0] @ TURNED.T + [0.4, -0.2, 0.1], surface[1]


def solid_of(*surfaces, **options):
    return solidify([mesh_of(*s, name=f"m{i}") for i, s in enumerate(surfaces)], **options)


@pytest.mark.parametrize("pose", [lambda s: s, turned], ids=["upright", "turned"])
@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("declared", [False, True])
def test_a_sheet_tray_on_a_block_is_the_block_and_its_walls(pose, reverse: bool, declared: bool) -> None:
    parts = [pose(BLOCK), pose(TRAY)][:: -1 if reverse else 1]
    solid, figures = solid_of(*parts, wall_m=T if declared else None, sheets=declared)
    t = solid.wall_thickness_m
    assert t is not None
    assert t == pytest.approx(T if declared else assumed_wall_m(diagonal(np.vstack([p for p, _ in parts]))))
    sunk = 0.2 * 0.2 * t / 2  # half of the bottom's wall lies in the block
    grown = tray_wall(0.2, 0.2, 0.06, t) - sunk
    assert (solid.kind, figures["method"]) == ("closed", "union_and_walls")
    assert figures["volume_m3"] == pytest.approx(0.2 * 0.2 * 0.1 + grown, rel=1e-6)
    assert solid.walls is not None
    assert solid.walls.volume_m3 == pytest.approx(grown, rel=1e-6)
    assert observe(solid.points, solid.triangles, "").watertight
    room = find_cavities(solid)
    assert [c.volume_m3 for c in room if not c.through] == [pytest.approx((0.2 - t) ** 2 * (0.06 - t / 2), rel=0.1)]


def test_a_lamp_keeps_its_base_solid_and_its_mass_centre_low() -> None:
    """More than half of the area is the shade, yet base and pole are no sheets."""
    base, pole = cylinder(0.06, 0.03, at=(0, 0, 0.015)), cylinder(0.008, 0.2, at=(0, 0, 0.125))
    points, triangles = cylinder(0.09, 0.12, at=(0, 0, 0.26))
    upright = np.abs(np.ptp(points[triangles][:, :, 2], axis=1)) > 1e-9
    shade = (points, triangles[upright])
    parts = [mesh_of(*s, name=f"m{i}") for i, s in enumerate((base, pole, shade))]
    solid, figures = solidify(parts, wall_m=T, sheets=True)
    held = [volume_properties(solid_of(s)[0])[0] for s in (base, pole)]
    corners = points[triangles[upright]]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    overlap = held[1].volume_m3 * 0.005 / 0.2  # the pole stands 5 mm deep in the base
    truth = held[0].volume_m3 + held[1].volume_m3 - overlap + T * area
    height = (held[0].volume_m3 * 0.015 + held[1].volume_m3 * 0.125 - overlap * 0.0275 + T * area * 0.26) / truth
    assert float(figures["open_area_share"]) > 0.5
    assert figures["volume_m3"] == pytest.approx(truth, rel=1e-3)
    assert volume_properties(solid)[0].centre_m[2] == pytest.approx(height, rel=1e-3)


def test_a_cup_that_sinks_into_its_saucer_keeps_its_room() -> None:
    saucer, cup = cylinder(0.07, 0.008, at=(0, 0, 0.004)), lidless(cylinder(0.035, 0.08, at=(0, 0, 0.0475)))
    solid, figures = solid_of(saucer, cup, wall_m=T, sheets=True)
    assert figures["method"] == "union_and_walls"
    assert solid_distance([mesh_of(*saucer), mesh_of(*cup)], solid).missing.attained < 1e-6
    (room,) = [c for c in find_cavities(solid) if not c.through]
    assert room.volume_m3 == pytest.approx(np.pi * 0.034**2 * 0.079, rel=0.1)


def test_a_foot_whose_open_end_is_hidden_is_filled_unless_somebody_says_it_is_a_sheet() -> None:
    seat = box((0.4, 0.4, 0.05), at=(0, 0, 0.225))
    foot = lidless(box((0.1, 0.1, 0.06), at=(0.14, 0.14, 0.17)))  # its mouth at the seat's underside
    assert solid_of(seat, foot)[1]["method"] == "union"
    assert solid_of(seat, foot)[1]["volume_m3"] == pytest.approx(0.4 * 0.4 * 0.05 + 0.1 * 0.1 * 0.06, rel=1e-6)
    said, figures = solid_of(seat, foot, wall_m=T, sheets=True)
    assert said.walls is not None
    assert figures["volume_m3"] == pytest.approx(0.4 * 0.4 * 0.05 + tray_wall(0.1, 0.1, 0.06, T), rel=1e-6)


def test_decoration_within_one_percent_is_left_out() -> None:
    label = box((0.1, 0.1, 1e-3), at=(0, 0, 0.1))
    sheet = (label[0], label[1][label[0][label[1]][:, :, 2].min(axis=1) > 0.1])  # its top face alone, 0.5 mm above
    solid, figures = solid_of(BLOCK, sheet)
    assert (solid.walls, figures["method"]) == (None, "union")
    assert figures["volume_m3"] == pytest.approx(0.2 * 0.2 * 0.1)


def test_the_mass_of_guessed_walls_is_as_uncertain_as_they_are() -> None:
    block, tray = mesh_of(*BLOCK, name="block"), mesh_of(*TRAY, name="tray")
    guessed, canonical, _ = weighed([block, tray])
    declared, exact, _ = weighed([block, tray], Options(shell_thickness_m=T))
    wide, narrow = canonical.section.volume_m3, exact.section.volume_m3
    assert wide.bounds is not None
    assert wide.bounds[0] < narrow.value < wide.bounds[1]
    assert narrow.bounds == (narrow.value, narrow.value)
    assert wide.confidence < narrow.confidence
    assert "wall thickness unknown" in guessed.mass_kg.method
    assert "wall thickness" not in declared.mass_kg.method
    assert exact.section.wall_thickness_m is not None
    assert exact.section.wall_thickness_m.source == "declared"
