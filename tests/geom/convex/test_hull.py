"""Convex hulls beside Qhull, an implementation of its own."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from geom.convex.hull import beyond_planes, convex_hull, volume

# A part of a scanned lamp for which Manifold's Quickhull folds the surface over a point inside.
FOLDED = np.array(
    [
        [0.005054017549009192, 0.0029336276531776702, 0.18654476348118088],
        [0.0039913235899319225, 0.006904814279530945, 0.1839984248982781],
        [0.007007976378857439, 0.010098121336832497, 0.18026338379010864],
        [0.006561857997429947, -0.0013812890513950184, 0.1901347525908083],
        [0.009953271015946853, -0.010591053138739337, 0.1982006831124325],
        [0.018429254855686892, -0.0321444505604655, 0.21183433202115143],
        [0.029571043382612572, -0.08215479578506633, 0.2451767597868042],
        [0.03039676127331303, -0.08215479578506633, 0.24710156541088346],
        [0.03931517399049784, -0.08215479578506633, 0.2425291773575397],
        [0.05430981809478022, -0.08215479578506633, 0.2295582696778074],
        [0.043983691370852195, -0.08215479578506633, 0.23893210080894722],
    ]
)


def assert_convex(points: np.ndarray) -> None:
    corners, triangles = convex_hull(points)
    size = float(np.ptp(points, axis=0).max())
    assert volume(corners, triangles) == pytest.approx(ConvexHull(points).volume, rel=1e-6, abs=1e-9 * size**3)
    assert beyond_planes(corners, triangles, points).max() <= 1e-5 * size


def test_nearly_coplanar_points_that_fold_quickhull() -> None:
    assert_convex(FOLDED)


@pytest.mark.parametrize("seed", range(40))
def test_flat_sets_have_the_volume_of_qhull(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(6, 60)), 3)) * [1.0, 0.3, 10.0 ** rng.uniform(-3, 0)]
    points[: len(points) // 2, 2] = 0.0
    assert_convex(points @ Rotation.random(rng=np.random.default_rng(seed)).as_matrix())


def test_a_hull_of_many_points_takes_memory_in_proportion() -> None:
    directions = np.random.default_rng(0).normal(size=(30_000, 3))
    points = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    tracemalloc.start()
    corners, _ = convex_hull(points)
    peak_mb = tracemalloc.get_traced_memory()[1] / 2**20
    tracemalloc.stop()
    assert len(corners) > 25_000
    assert peak_mb < 100.0  # A table of all points by all faces would take 14 GB.
