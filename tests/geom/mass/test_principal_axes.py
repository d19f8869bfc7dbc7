"""Principal axes: the tensor comes back, also when moments coincide."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geom.mass.principal_axes import inertia_from_principal, principal_axes
from geom.pose import matrix_of

MOMENTS = st.sampled_from([(1.0, 1.0, 1.0), (1.0, 1.0, 1.5), (1.0, 2.0, 2.0), (1e-9, 1.4e-9, 2e-9), (3e4, 4e4, 5e4)])


@given(MOMENTS, st.integers(0, 10_000))
def test_tensor_is_rebuilt_in_single_precision(moments: tuple[float, ...], seed: int) -> None:
    R = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    inertia = R @ np.diag(moments) @ R.T
    found, quat_wxyz = principal_axes(inertia)
    assert np.linalg.det(matrix_of(quat_wxyz)) == pytest.approx(1.0)
    assert np.linalg.norm(quat_wxyz) == pytest.approx(1.0)
    assert quat_wxyz[0] >= 0.0
    stored = inertia_from_principal(found.astype(np.float32).astype(float), quat_wxyz.astype(np.float32).astype(float))
    np.testing.assert_allclose(stored, inertia, atol=1e-6 * max(moments))


def test_diagonal_tensor_keeps_its_axes() -> None:
    moments, quat_wxyz = principal_axes(np.diag([3.0, 1.0, 2.5]))
    assert moments.tolist() == [3.0, 1.0, 2.5]
    assert quat_wxyz.tolist() == [1.0, 0.0, 0.0, 0.0]
