"""Rays: places that rays hit and places nearest to points are places of the triangles that are named with them."""

from __future__ import annotations

import numpy as np
import trimesh

from geom.mesh.rays import Rays

BALL = trimesh.creation.icosphere(3, 2.0).apply_translation((50.0, -3.0, 7.0))
POINTS, TRIANGLES = np.asarray(BALL.vertices), np.asarray(BALL.faces)


def placed(faces: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return np.einsum("kc,kcx->kx", weights, POINTS[TRIANGLES[faces]])


def test_a_hit_lies_on_its_ray_and_on_its_triangle() -> None:
    rng = np.random.default_rng(0)
    ways = rng.normal(size=(200, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    starts = np.tile(BALL.centroid, (200, 1))
    hits = Rays(POINTS, TRIANGLES).hits(starts, ways)
    np.testing.assert_allclose(placed(hits.triangles, hits.weights), starts + hits.distances[:, None] * ways, atol=2e-5)


def test_a_ray_past_the_surface_hits_nothing() -> None:
    hits = Rays(POINTS, TRIANGLES).hits(np.array([[0.0, 0.0, 0.0]]), np.array([-1.0, 0.0, 0.0]))
    assert (hits.triangles[0], np.isinf(hits.distances[0])) == (-1, True)


def test_triangles_without_area_do_not_shift_the_numbers_of_others() -> None:
    flat = np.concatenate([[[0, 0, 1]], TRIANGLES])
    hits = Rays(POINTS, flat).hits(BALL.centroid[None], np.array([0.0, 0.0, 1.0]))
    plain = Rays(POINTS, TRIANGLES).hits(BALL.centroid[None], np.array([0.0, 0.0, 1.0]))
    assert hits.triangles[0] == plain.triangles[0] + 1


def test_the_nearest_place_is_as_far_as_said_and_nearer_than_all_corners() -> None:
    queries = BALL.centroid + np.random.default_rng(1).normal(size=(100, 3)) * 3.0
    faces, weights, away = Rays(POINTS, TRIANGLES).nearest(queries)
    np.testing.assert_allclose(np.linalg.norm(placed(faces, weights) - queries, axis=1), away, atol=2e-5)
    assert (away <= np.linalg.norm(queries[:, None] - POINTS[None], axis=2).min(axis=1) + 1e-5).all()
