"""Decimation keeps shape, attributes and determinism, and says how far it went."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from geom.mesh.decimate import decimate, decimate_mesh
from geom.mesh.surface_distance import two_way_distance
from geom.mesh.topology import observe
from tests.support.present import present
from tests.support.sample_surfaces import ball, box, mesh_of


def test_a_light_mesh_is_returned_as_it_is() -> None:
    mesh = mesh_of(*box())
    light, figures = decimate_mesh(mesh, 100)
    assert light is mesh
    assert figures["surface_distance_max_m"] == 0.0


def test_a_ball_keeps_its_shape_within_the_stated_distance() -> None:
    mesh = mesh_of(*ball(subdivisions=5))
    light, figures = decimate_mesh(mesh, 2000)
    assert 1800 <= len(light.triangles) <= 2000
    assert figures["triangles_before"] == len(mesh.triangles)
    assert figures["triangles_after"] == len(light.triangles)
    assert 0.0 < figures["surface_distance_p95_m"] <= figures["surface_distance_max_m"] < 0.02
    measured = two_way_distance(mesh.points, mesh.triangles, light.points, light.triangles, 1000, 5)
    assert measured.a_to_b_p95 < 2 * figures["surface_distance_max_m"]
    assert observe(light.points, light.triangles, "").watertight


def test_attributes_come_from_the_nearest_source_point() -> None:
    light, _ = decimate_mesh(mesh_of(*ball(subdivisions=4)), 600)
    corners = light.points[light.triangles]
    assert light.normals is not None
    assert light.colors is not None
    assert np.allclose(light.uvs[0], corners[..., :2], atol=0.05)  # The samples store positions as attributes.
    assert np.allclose(light.colors[..., :3], corners, atol=0.05)
    assert np.einsum("mkx,mkx->mk", light.normals, corners).min() > 0.9
    assert np.allclose(np.linalg.norm(light.normals, axis=2), 1.0, atol=1e-5)
    assert light.normals.dtype == light.uvs[0].dtype == light.colors.dtype == np.float32


def test_hard_edges_keep_the_normals_of_their_own_side() -> None:
    points, triangles = box()
    for _ in range(3):
        dense = trimesh.Trimesh(points, triangles, process=False).subdivide()
        points, triangles = np.array(dense.vertices), np.array(dense.faces)
    light, _ = decimate_mesh(mesh_of(points, triangles), 48)
    corners = light.points[light.triangles]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    assert light.normals is not None
    assert np.einsum("mx,mkx->mk", flat, light.normals).min() > 0.99


def test_place_and_scale_do_not_matter() -> None:
    points, triangles = ball(subdivisions=4)
    here = decimate(points, triangles, 500)
    there = decimate(points * 1e-3 + 1e3, triangles, 500)
    assert len(here[1]) == len(there[1])
    assert observe(there[0], there[1], "").volume == pytest.approx(
        present(observe(here[0], here[1], "").volume) * 1e-9, rel=1e-3
    )


def test_unwelded_faces_do_not_tear() -> None:
    points, triangles = ball(subdivisions=3)
    light = decimate(points[triangles].reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), 400)
    assert observe(*light, "").watertight


def test_the_same_input_gives_the_same_bytes() -> None:
    points, triangles = ball(subdivisions=4)
    first, second = (decimate(points, triangles, 700) for _ in range(2))
    assert first[0].tobytes() == second[0].tobytes()
    assert first[1].tobytes() == second[1].tobytes()
