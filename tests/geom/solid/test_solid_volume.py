"""Volume properties of a solid: the method follows from its kind and soundness."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geom.mass.inertia import box_volume, is_physical
from geom.mesh import primitives
from geom.solid.solid_volume import volume_properties
from schemas.physics import Solid

SIZE_M = (0.3, 0.2, 0.1)


def assert_same(a, b, rtol=1e-9):
    assert_allclose(a.volume_m3, b.volume_m3, rtol=rtol)
    assert_allclose(a.centre_m, b.centre_m, rtol=rtol, atol=rtol)
    moment = b.second_moment_m5
    assert_allclose(a.second_moment_m5, moment, rtol=rtol, atol=rtol * np.abs(moment).max())


def test_the_hierarchy_of_methods():
    points, triangles, _ = primitives.cube(1.0)
    points, triangles = points * np.array(SIZE_M), triangles.astype(np.int32)
    closed, method, confidence = volume_properties(Solid(points, triangles, "closed"))
    assert_same(closed, box_volume(SIZE_M, np.eye(4)))
    assert (method, confidence) == ("volume of the closed surface", 0.95)
    open_box = Solid(points, triangles[2:], "shell", wall_thickness_m=0.001)
    assert volume_properties(open_box)[0].volume_m3 == pytest.approx(0.001 * 0.16)
    hull, method, confidence = volume_properties(Solid(points, triangles[2:], "hull"))
    assert_same(hull, box_volume(SIZE_M, np.eye(4)))
    assert "hull" in method
    assert confidence < 0.5
    inside_out, method, _ = volume_properties(Solid(points, triangles[:, ::-1], "closed"))
    assert_same(inside_out, hull)
    flat, method, _ = volume_properties(Solid(points * [1, 1, 0], triangles, "hull"))
    assert method == "oriented box"
    assert is_physical(flat.second_moment_m5)
