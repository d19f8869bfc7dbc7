"""Tangent frames: the directions in which u and v grow, whichever way coordinates are turned, scaled or mirrored."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geom.mesh.tangent_frames import into_frame, out_of_frame, tangent_frames

POINTS = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 1.0, 0.0]])
UP = np.array([[0.0, 0.0, 1.0]])
angles = st.floats(-np.pi, np.pi)


def uvs_of(angle: float, scale: float, mirrored: bool) -> np.ndarray:
    """(1, 3, 2) coordinates of the triangle: its plane turned, scaled and perhaps mirrored."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    flip = np.diag([1.0, -1.0 if mirrored else 1.0])
    return (POINTS[:, :2] @ (scale * flip @ turn).T)[None]


@given(angle=angles, scale=st.floats(1e-3, 1e3), mirrored=st.booleans())
def test_steps_along_t_and_b_raise_u_and_v_alone(angle: float, scale: float, mirrored: bool) -> None:
    uvs = uvs_of(angle, scale, mirrored)
    frame = tangent_frames(POINTS, np.array([[0, 1, 2]]), uvs)
    T, B = (out_of_frame(np.eye(3)[k : k + 1], UP, frame.tangents, frame.sides)[0] for k in (0, 1))
    edges = np.stack([POINTS[1] - POINTS[0], POINTS[2] - POINTS[0]])[:, :2]
    gradient = np.linalg.solve(edges, uvs[0, 1:] - uvs[0, 0])  # (xy, uv): what a step in the plane adds to u and v
    np.testing.assert_allclose(T[:2] @ gradient, [scale, 0.0], atol=1e-9 * scale)
    np.testing.assert_allclose(B[:2] @ gradient, [0.0, scale], atol=1e-9 * scale)


@given(angle=angles, mirrored=st.booleans(), tilt=st.tuples(*[st.floats(-1, 1)] * 3))
def test_a_vector_comes_back_from_its_frame(angle: float, mirrored: bool, tilt: tuple[float, float, float]) -> None:
    frame = tangent_frames(POINTS, np.array([[0, 1, 2]]), uvs_of(angle, 1.0, mirrored))
    normal = np.array([[0.6, 0.0, 0.8]])
    local = into_frame(np.array([tilt]), normal, frame.tangents, frame.sides)
    np.testing.assert_allclose(out_of_frame(local, normal, frame.tangents, frame.sides), [tilt], atol=1e-12)


def test_coordinates_without_area_give_a_frame_nevertheless() -> None:
    frame = tangent_frames(POINTS, np.array([[0, 1, 2]]), np.zeros((1, 3, 2)))
    local = into_frame(UP, UP, frame.tangents, frame.sides)
    np.testing.assert_allclose(local, [[0.0, 0.0, 1.0]])
