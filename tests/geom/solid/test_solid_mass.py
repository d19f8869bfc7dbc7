"""Mass properties of a solid: the method follows from its kind and soundness."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geom.mass.inertia import is_physical, of_box
from geom.mesh import primitives
from geom.solid.solid_mass import mass_properties
from schemas.physics import Solid

SIZE_M = (0.3, 0.2, 0.1)


def assert_same(a, b, rtol=1e-9):
    assert_allclose(a.mass_kg, b.mass_kg, rtol=rtol)
    assert_allclose(a.centre_of_mass_m, b.centre_of_mass_m, rtol=rtol, atol=rtol)
    assert_allclose(a.inertia_kgm2, b.inertia_kgm2, rtol=rtol, atol=rtol * np.abs(b.inertia_kgm2).max())


def test_the_hierarchy_of_methods():
    points, triangles, _ = primitives.cube(1.0)
    points, triangles = points * np.array(SIZE_M), triangles.astype(np.int32)
    closed, method, confidence = mass_properties(Solid(points, triangles, "closed"), 700.0)
    assert_same(closed, of_box(SIZE_M, 700.0))
    assert (method, confidence) == ("volume of the closed surface", 0.95)
    open_box = Solid(points, triangles[2:], "shell", wall_thickness_m=0.001)
    assert mass_properties(open_box, 700.0)[0].mass_kg == pytest.approx(700.0 * 0.001 * 0.16)
    hull, method, confidence = mass_properties(Solid(points, triangles[2:], "hull"), 700.0)
    assert_same(hull, of_box(SIZE_M, 700.0))
    assert "hull" in method
    assert confidence < 0.5
    inside_out, method, _ = mass_properties(Solid(points, triangles[:, ::-1], "closed"), 700.0)
    assert_same(inside_out, hull)
    flat, method, _ = mass_properties(Solid(points * [1, 1, 0], triangles, "hull"), 700.0)
    assert method == "oriented box"
    assert is_physical(flat.inertia_kgm2)
