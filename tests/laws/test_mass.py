"""Laws that mass properties keep for any solid: covariance, scaling, additivity, tensors of real bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geom.mass.inertia import combine, is_physical, moved
from geom.pose import pose
from geom.solid.solid_volume import volume_properties
from geom.solid.solidify import solidify
from schemas.model import Mesh
from schemas.physics import MassProperties, Solid
from tests.support.mass_samples import WOOD, assert_same
from tests.support.package_samples import mesh_from


def solid_mass(meshes: Sequence[Mesh]) -> MassProperties:
    return volume_properties(solidify(meshes)[0])[0].filled(WOOD)


def random_boxes(seed: int) -> list[Mesh]:
    """Three boxes, turned and overlapping."""
    rng = np.random.default_rng(seed)
    meshes = []
    for _ in range(3):
        X = pose(Rotation.random(rng=rng).as_matrix(), rng.uniform(-0.08, 0.08, 3))
        body = trimesh.creation.box(rng.uniform(0.05, 0.2, 3))
        body.apply_transform(X)
        meshes.append(mesh_from(body))
    return meshes


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1))
def test_law_turning_and_moving(seed, turn):
    X = pose(
        Rotation.random(rng=np.random.default_rng(turn)).as_matrix(), np.random.default_rng(turn).uniform(-3, 3, 3)
    )
    meshes = random_boxes(seed)
    here = solid_mass(meshes)
    there = solid_mass([replace(m, points=m.points @ X[:3, :3].T + X[:3, 3]) for m in meshes])
    assert_same(there, moved(here, X), 1e-6)


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 100.0))
def test_law_scaling(seed, s):
    meshes = random_boxes(seed)
    small, large = solid_mass(meshes), solid_mass([replace(m, points=m.points * s) for m in meshes])
    scaled_up = MassProperties(small.mass_kg * s**3, small.centre_of_mass_m * s, small.inertia_kgm2 * s**5)
    assert_same(large, scaled_up, 1e-6)


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1))
def test_law_disjoint_bodies_add(first, second):
    left = random_boxes(first)
    right = [replace(m, points=m.points + np.array([0.6, 0.0, 0.0])) for m in random_boxes(second)]
    assert_same(solid_mass([*left, *right]), combine([solid_mass(left), solid_mass(right)]), 1e-6)


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([1e-3, 1.0, 1e3]),
    st.sampled_from([0.0, 1e-6, 1.0]),
    st.sampled_from(["closed", "shell", "hull"]),
)
def test_law_every_tensor_belongs_to_some_body(seed, size, flatness, kind):
    """Random triangles, flat ones too, whatever they are taken for."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 30))
    points = rng.uniform(-1, 1, (3 * count, 3)) * size * [1.0, 1.0, flatness]
    triangles = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
    volume, _, _ = volume_properties(Solid(points, triangles, kind, 1e-3 * size if kind == "shell" else None))
    body = volume.filled(WOOD)
    assert body.mass_kg > 0
    assert is_physical(body.inertia_kgm2)


@pytest.mark.parametrize("seed", range(3))
def test_the_union_agrees_with_another_library(seed):
    """Open3D's point-in-mesh test votes on the union of the boxes as they stand."""
    import open3d as o3d

    meshes = random_boxes(seed)
    solid, _ = solidify(meshes)
    points = np.concatenate([m.points for m in meshes])
    low, high = points.min(axis=0), points.max(axis=0)
    x = np.random.default_rng(0).uniform(low, high, (40_000, 3)).astype(np.float32)
    inside = np.zeros(len(x), dtype=bool)
    for mesh in meshes:
        scene = o3d.t.geometry.RaycastingScene()
        scene.add_triangles(
            o3d.core.Tensor.from_numpy(mesh.points.astype(np.float32)),
            o3d.core.Tensor.from_numpy(mesh.triangles.astype(np.uint32)),
        )
        inside |= scene.compute_occupancy(o3d.core.Tensor.from_numpy(x)).numpy() > 0.5
    share = inside.mean()
    volume = trimesh.Trimesh(solid.points, solid.triangles, process=False).volume / np.prod(high - low)
    assert abs(volume - share) < 4.0 * np.sqrt(share * (1.0 - share) / len(x))
