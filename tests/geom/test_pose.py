"""Laws of poses and quaternions: round trips, group axioms, SciPy's order against ours."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geom.pose import (
    angle_between,
    apply,
    compose,
    inverse,
    matrix_of,
    pose,
    pose_from_quat,
    quat_of,
    shortest_rotation,
    to_wxyz,
    to_xyzw,
)

finite = st.floats(-10.0, 10.0)
quats = (
    st.tuples(*[st.floats(-1.0, 1.0)] * 4)
    .map(np.array)
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: q / np.linalg.norm(q))
)
poses = st.builds(pose_from_quat, quats, st.tuples(finite, finite, finite))
units = st.tuples(finite, finite, finite).map(np.array).filter(lambda v: np.linalg.norm(v) > 0.1)


def test_orders_are_as_named() -> None:
    assert to_xyzw(np.array([1, 2, 3, 4])).tolist() == [2, 3, 4, 1]
    assert to_wxyz(np.array([1, 2, 3, 4])).tolist() == [4, 1, 2, 3]


def test_quarter_turn_about_z_takes_x_to_y() -> None:
    half = np.sqrt(0.5)
    assert matrix_of(np.array([half, 0, 0, half])) @ [1, 0, 0] == pytest.approx([0, 1, 0])


@given(quats)
def test_quaternion_survives_the_matrix_up_to_sign_and_comes_back_canonical(quat: np.ndarray) -> None:
    back = quat_of(matrix_of(quat))
    assert back[0] >= 0
    assert abs(np.dot(back, quat)) == pytest.approx(1.0)


@given(poses, poses, poses)
def test_poses_are_a_group(X_AB: np.ndarray, X_BC: np.ndarray, X_CD: np.ndarray) -> None:
    assert compose(X_AB, inverse(X_AB)) == pytest.approx(np.eye(4), abs=1e-12)
    left, right = compose(compose(X_AB, X_BC), X_CD), compose(X_AB, compose(X_BC, X_CD))
    assert left == pytest.approx(right, abs=1e-10)
    assert inverse(compose(X_AB, X_BC)) == pytest.approx(compose(inverse(X_BC), inverse(X_AB)), abs=1e-10)


@given(poses)
def test_apply_agrees_with_homogeneous_coordinates(X_AB: np.ndarray) -> None:
    points = np.array([[0.0, 0, 0], [1, 2, 3]])
    assert apply(X_AB, points)[1] == pytest.approx((X_AB @ [1, 2, 3, 1])[:3])
    assert apply(X_AB, points)[0] == pytest.approx(X_AB[:3, 3])


@given(quats, quats)
def test_angle_is_symmetric_and_ignores_the_sign(a: np.ndarray, b: np.ndarray) -> None:
    assert angle_between(a, b) == pytest.approx(angle_between(b, a))
    assert angle_between(a, -b) == pytest.approx(angle_between(a, b))


def test_angle_of_many_at_once() -> None:
    many = quat_of(np.stack([np.eye(3), np.diag([1.0, -1.0, -1.0])]))
    assert angle_between(np.array([1.0, 0, 0, 0]), many) == pytest.approx([0.0, np.pi])


@given(units, units)
def test_shortest_rotation_maps_u_to_v_and_is_a_rotation(u: np.ndarray, v: np.ndarray) -> None:
    u, v = u / np.linalg.norm(u), v / np.linalg.norm(v)
    R = shortest_rotation(u, v)
    assert u @ R.T == pytest.approx(v, abs=1e-8)
    assert np.allclose(R @ R.T, np.eye(3), rtol=0.0, atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)


@pytest.mark.parametrize("axis", np.eye(3).tolist())
def test_shortest_rotation_of_equal_and_opposite_vectors(axis: list[float]) -> None:
    u = np.array(axis)
    assert shortest_rotation(u, u) == pytest.approx(np.eye(3))
    assert shortest_rotation(u, -u) @ u == pytest.approx(-u)


@given(units, units, st.floats(-12.0, -0.5))
def test_shortest_rotation_is_exact_close_to_opposite_vectors(u: np.ndarray, off: np.ndarray, exponent: float) -> None:
    u = u / np.linalg.norm(u)
    v = 10.0**exponent * off / np.linalg.norm(off) - u
    v /= np.linalg.norm(v)
    R = shortest_rotation(u, v)
    assert np.allclose(R @ u, v, rtol=0.0, atol=1e-8)
    assert np.allclose(R @ R.T, np.eye(3), rtol=0.0, atol=1e-12)


def test_identity_pose_is_the_default() -> None:
    assert pose().tolist() == np.eye(4).tolist()
    assert pose(p_AB=(1, 2, 3))[:3, 3].tolist() == [1, 2, 3]
