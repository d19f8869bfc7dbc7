"""The canonical frame: metres, z-up, bottom-centre origin, whatever the source did."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from assetkit.geometry.canonical_model import canonicalize
from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.stage import Intake
from assetkit.stages.intake import ReadSource
from schemas.evidence import declared
from schemas.model import Mesh, Model
from tests.support.bad_inputs.assets import SAMPLES

CONE = trimesh.creation.cone(radius=0.05, height=0.2)


def intake(points: np.ndarray, *, meters_per_unit: float = 1.0, up: str = "z") -> Intake:
    mesh = Mesh("cone", points, np.asarray(CONE.faces, dtype=np.int32))
    model = Model((mesh,), (), (), (), declared(meters_per_unit, "test"), declared(up, "test"))  # pyright: ignore
    x, y, z = (float(e) for e in np.ptp(points, axis=0))
    return Intake("obj", (), model, (x, y, z))


def canonical(item: Intake):
    value = canonicalize(item, "cone.obj", Options()).value
    assert value is not None
    return value


def test_y_up_millimetres_become_z_up_metres_standing_on_the_origin():
    y_up = CONE.vertices @ Rotation.from_euler("x", -90, degrees=True).as_matrix().T * 1000
    made = canonical(intake(y_up + np.array([30, -500, 7]), meters_per_unit=0.001, up="y"))
    points = made.meshes[0].points
    assert made.section.extent_m.value == pytest.approx((0.1, 0.1, 0.2), abs=1e-3)
    assert points[:, 2].min() == pytest.approx(0, abs=1e-12)
    apex = points[np.argmax(points[:, 2])]
    assert apex == pytest.approx([0, 0, 0.2], abs=1e-9)


@settings(max_examples=20, deadline=None)
@given(st.tuples(*[st.floats(-1e4, 1e4)] * 3))
def test_result_does_not_depend_on_where_the_source_lay(offset: tuple[float, float, float]):
    here, there = canonical(intake(CONE.vertices)), canonical(intake(CONE.vertices + offset))
    assert there.meshes[0].points == pytest.approx(here.meshes[0].points, abs=1e-9)
    assert there.section.volume_m3.value == pytest.approx(here.section.volume_m3.value, rel=1e-6)


def test_origin_offset_leads_back_to_the_source():
    offset = np.array([3.0, -2.0, 5.0])
    made = canonical(intake(CONE.vertices + offset))
    source_origin = np.array(made.section.origin_offset_m)
    assert made.meshes[0].points - source_origin == pytest.approx(CONE.vertices + offset, abs=1e-9)


def test_far_away_objects_keep_their_shape_and_say_so():
    item = intake(CONE.vertices + np.array([1.2e6, -3.4e5, 15]))
    outcome = canonicalize(item, "cone.obj", Options())
    assert [r.name for r in outcome.repairs] == ["recentre"]
    assert outcome.value is not None
    assert outcome.value.section.extent_m.value == pytest.approx((0.1, 0.1, 0.2), abs=1e-3)


def test_annotation_frame_is_separate_and_normalised():
    made = canonical(intake(CONE.vertices))
    frame = made.section.annotation_frame
    seen = (made.meshes[0].points - frame.centre_m) / frame.scale_m
    assert np.linalg.norm(np.ptp(seen, axis=0)) == pytest.approx(1.0)
    assert made.section.extent_m.value == pytest.approx((0.1, 0.1, 0.2), abs=1e-3)


def test_a_removed_fin_leaves_no_point_behind(tmp_path: Path):
    item = ReadSource().run(discover([SAMPLES["asset/non-manifold-edge"](tmp_path)])[0], Options()).objects[0]
    made = canonical(item)
    points = np.concatenate([m.points for m in made.meshes])
    assert np.ptp(points, axis=0) == pytest.approx((0.1, 0.1, 0.1), abs=2e-3)
    assert len(np.unique(made.meshes[0].triangles)) == len(points)


def test_heavy_meshes_are_reduced_within_the_stated_error():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.1)
    item = intake(CONE.vertices)
    mesh = Mesh("ball", np.asarray(ball.vertices), np.asarray(ball.faces, dtype=np.int32))
    item = replace(item, model=replace(item.model, meshes=(mesh,)))
    outcome = canonicalize(item, "ball.obj", Options(max_triangles=1000))
    assert outcome.value is not None
    assert sum(len(m.triangles) for m in outcome.value.meshes) <= 1000
    repair = next(r for r in outcome.repairs if r.name == "decimate")
    assert 0 < float(repair.after["hausdorff_m"]) < 0.002
