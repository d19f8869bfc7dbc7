"""Stable poses: the faces, heights and probabilities that geometry and symmetry demand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from assetkit.acceptance.stable_poses import (
    StablePoses,
    find_stable_poses,
    holds,
    pose_families,
    recovers,
    resting_pose,
    spread_directions,
)
from geom.convex.support_function import support
from geom.pose import matrix_of
from schemas.acceptance import StablePose
from schemas.physics import RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.fake import FakeSimulator
from tests.support.sample_bodies import box, boxes, capsule, cylinder, hull, hull_box, sphere


@pytest.fixture(scope="module")
def bullet():
    with BulletSimulator() as simulator:
        yield simulator


def offsets(poses: Sequence[StablePose]) -> list[float]:
    return sorted(round(p.support_offset_m, 4) for p in poses)


def total(stable: StablePoses) -> float:
    return sum(p.probability for p in stable.poses)


@pytest.mark.parametrize("make", [box, hull_box])
def test_a_cube_has_six_poses_about_equally_likely(bullet, make) -> None:
    found = find_stable_poses(make((0.05, 0.05, 0.05)), bullet, trials=48)
    assert offsets(found.poses) == [0.0, 0.025, 0.025, 0.025, 0.025, 0.05]
    assert all(0.08 < p.probability < 0.25 for p in found.poses)
    assert total(found) == pytest.approx(1.0)
    assert found.at_rest == found.trials == 48


def test_the_reference_pose_itself_has_no_yaw_and_no_offset(bullet) -> None:
    found = find_stable_poses(box((0.1, 0.08, 0.02)), bullet)
    upright = [p for p in found.poses if p.support_offset_m == pytest.approx(0.0, abs=1e-9)]
    assert len(upright) == 1
    assert upright[0].quat_wxyz == pytest.approx((1.0, 0.0, 0.0, 0.0), abs=1e-9)


def test_flat_faces_are_likelier_than_narrow_ends(bullet) -> None:
    found = find_stable_poses(box((0.2, 0.1, 0.05)), bullet)
    chance = {}
    for p in found.poses:
        axis = int(np.abs(matrix_of(np.array(p.quat_wxyz))[2]).argmax())
        chance[axis] = chance.get(axis, 0.0) + p.probability
    assert chance[2] > chance[1] > chance.get(0, 0.0)


def test_the_reference_pose_is_tried_however_unlikely(bullet) -> None:
    """A tall thin board comes to rest upright in hardly any drop, yet it stands."""
    found = find_stable_poses(box((0.02, 0.06, 0.3)), bullet)
    upright = [p for p in found.poses if p.quat_wxyz == pytest.approx((1.0, 0.0, 0.0, 0.0), abs=1e-9)]
    assert len(upright) == 1
    assert upright[0].probability == pytest.approx(1 / 32)


def test_a_can_stands_on_two_ends_and_lies_in_one_pose(bullet) -> None:
    for body in (cylinder(0.033, 0.12), hull(trimesh.creation.cylinder(0.033, 0.12, sections=32))):
        found = find_stable_poses(body, bullet)
        assert found.poses[0].support_offset_m == pytest.approx(0.033, rel=0.01)
        assert found.poses[0].probability > 0.5
        assert offsets(found.poses[1:]) in ([0.0, 0.12], [0.0], [0.12], [])


def test_balls_and_capsules_have_one_pose(bullet) -> None:
    for body in (sphere(0.03), capsule(0.01, 0.1), hull(trimesh.creation.icosphere(subdivisions=1, radius=0.03))):
        found = find_stable_poses(body, bullet)
        assert len(found.poses) == 1
        assert found.poses[0].probability > 0.9


def test_an_l_shape_rests_on_its_faces_and_on_its_bridge(bullet) -> None:
    body = boxes([((0.1, 0.04, 0.02), (0, 0, 0.01)), ((0.02, 0.04, 0.08), (-0.04, 0, 0.06))])
    found = find_stable_poses(body, bullet)
    downs = [-matrix_of(np.array(p.quat_wxyz))[2] for p in found.poses]
    bridge = np.array([1.0, 0.0, 1.0]) / math.sqrt(2.0)  # on the ends of both legs
    expected = [np.array(d) for d in ([0, 1, 0], [0, -1, 0], [0, 0, -1], [-1, 0, 0])] + [bridge]
    assert len(found.poses) == len(expected)
    for direction in expected:
        assert max(float(direction @ d) for d in downs) > 0.9999


@pytest.mark.parametrize(
    "body",
    [box((0.006, 0.004, 0.003)), box((56.0, 9.0, 63.0)), box((400.0, 180.0, 120.0)), box((0.09, 0.06, 0.0004))],
    ids=["tiny", "building", "toy car in wrong units", "card"],
)
def test_size_and_thinness_do_not_matter(bullet, body: RigidBody) -> None:
    found = find_stable_poses(body, bullet)
    assert found.at_rest >= 31
    assert found.refuted <= 1  # A trial that starts on edge may stay there by rolling resistance.
    thin = min(body.shapes[0].size_m)
    most_likely = matrix_of(np.array(found.poses[0].quat_wxyz))[2]
    assert body.shapes[0].size_m[int(np.abs(most_likely).argmax())] == thin


def test_a_needle_lies_and_never_flies(bullet) -> None:
    found = find_stable_poses(box((0.01, 0.01, 1.0)), bullet)
    assert found.at_rest > 28
    assert all(p.support_offset_m < 0.008 for p in found.poses)


def test_every_pose_touches_the_ground_and_holds(bullet) -> None:
    body = boxes([((0.1, 0.04, 0.02), (0, 0, 0.01)), ((0.02, 0.04, 0.08), (-0.04, 0, 0.06))])
    for p in find_stable_poses(body, bullet).poses:
        down_A = -matrix_of(np.array(p.quat_wxyz))[2]
        assert p.support_offset_m == pytest.approx(support(body.shapes, down_A[None])[0], abs=1e-12)
        assert holds(body, bullet, down_A)


def test_a_pose_on_an_edge_does_not_hold_or_does_not_recover(bullet) -> None:
    body = box((0.06, 0.05, 0.04))
    assert not holds(body, bullet, np.array([math.sin(0.7), 0.0, -math.cos(0.7)]))
    balanced = np.array([0.06, 0.0, -0.04]) / math.hypot(0.04, 0.06)
    assert holds(body, bullet, balanced)
    assert not recovers(body, bullet, balanced)
    assert recovers(body, bullet, np.array([0.0, 0.0, -1.0]))


def test_a_pencil_stands_a_needle_does_not(bullet) -> None:
    upright = np.array([0.0, 0.0, -1.0])
    assert recovers(cylinder(0.004, 0.1), bullet, upright)
    assert not recovers(cylinder(0.001, 0.1), bullet, upright)


def test_nothing_at_rest_gives_no_pose() -> None:
    found = find_stable_poses(sphere(0.03), _Restless(), trials=4)
    assert (found.poses, found.at_rest, found.trials) == ((), 0, 4)


class _Restless(FakeSimulator):
    """Every record ends in the air."""

    def drop(self, body, X_WA, settings):
        return super().drop(body, X_WA, replace(settings, duration_s=0.01))

    def drop_many(self, body, poses_WA, settings):
        return tuple(self.drop(body, X, settings) for X in poses_WA)


def test_the_search_is_deterministic_and_works_with_any_simulator(bullet) -> None:
    body = hull_box((0.1, 0.07, 0.05))
    assert find_stable_poses(body, bullet) == find_stable_poses(body, bullet)
    assert offsets(find_stable_poses(body, FakeSimulator()).poses) == [0.0, 0.035, 0.035, 0.05, 0.05, 0.05]


def test_directions_are_unit_and_spread_evenly() -> None:
    directions = spread_directions(32)
    assert np.linalg.norm(directions, axis=1) == pytest.approx(np.ones(32))
    assert np.abs(directions.mean(axis=0)).max() < 0.02
    nearest = np.sort(directions @ directions.T, axis=1)[:, -2]
    assert np.degrees(np.arccos(nearest)).min() > 15.0


def test_a_resting_pose_faces_the_direction_down_without_yaw() -> None:
    body = box((0.06, 0.05, 0.04))
    for down_A in spread_directions(12):
        X_WA = resting_pose(body, down_A, gap_m=0.01)
        assert X_WA[:3, :3] @ down_A == pytest.approx([0.0, 0.0, -1.0], abs=1e-9)
        assert X_WA[2, 3] == pytest.approx(support(body.shapes, down_A[None])[0] + 0.01)
        assert abs(X_WA[1, 0] - X_WA[0, 1]) < 1e-9  # the rotation axis is horizontal


@given(st.floats(-9.0, -1.5), st.floats(0.0, 2.0 * np.pi))
def test_almost_opposite_faces_are_two_poses(exponent: float, azimuth: float) -> None:
    """The way between them leads over the edges of the box, whichever great circle it takes."""
    off = 10.0**exponent * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    downs = np.array([[0.0, 0.0, 1.0], off - [0.0, 0.0, 1.0]])
    downs /= np.linalg.norm(downs, axis=1)[:, None]
    assert len(set(pose_families(box((0.1, 0.1, 0.1)), downs).tolist())) == 2


@given(st.lists(st.floats(0.0, 2.0 * np.pi), min_size=2, max_size=6))
def test_a_rod_is_in_one_pose_however_it_rolled(rolls: list[float]) -> None:
    downs = np.array([[np.cos(roll), np.sin(roll), 0.0] for roll in (*rolls, 0.0, 2.0, 4.0)])
    assert set(pose_families(cylinder(0.01, 0.3), downs).tolist()) == {0}


@pytest.mark.parametrize("azimuth", np.arange(8) * (np.pi / 4.0))
def test_a_can_on_its_rim_does_not_recover_whichever_way_it_leans(bullet, azimuth: float) -> None:
    can = cylinder(0.033, 0.1)
    steep = math.atan2(0.033, 0.05)
    rim = np.array([math.sin(steep) * math.cos(azimuth), math.sin(steep) * math.sin(azimuth), -math.cos(steep)])
    assert not recovers(can, bullet, rim)


def test_a_plank_on_either_long_edge_is_in_two_poses() -> None:
    """The way from one to the other stays below the top of the edge, but it leads through the flat pose."""
    edges = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.01, -1.0, 0.0]])
    edges /= np.linalg.norm(edges, axis=1)[:, None]
    assert pose_families(box((0.3, 0.08, 0.01)), edges).tolist() == [0, 1, 1]


def test_a_cone_on_its_side_is_in_one_pose_however_it_rolled() -> None:
    cone = hull(trimesh.creation.cone(0.04, 0.09, sections=32))
    incline, turns = math.atan2(0.04, 0.09), np.array([0.0, 1.9, 3.2, 4.6])
    across = math.cos(incline) * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    downs = np.column_stack([across, np.full(4, math.sin(incline))])
    assert set(pose_families(cone, downs).tolist()) == {0}
