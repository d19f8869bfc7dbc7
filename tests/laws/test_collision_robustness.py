"""Whatever the surface, choosing colliders ends, within bounds, with a stated result; the same one each time."""

from __future__ import annotations

import resource
import time

import numpy as np
import pytest
import trimesh

from assetkit.colliders.choose import choose_colliders
from assetkit.colliders.decompose import DECOMPOSITION_CPU_S, MOST_FACES, DecompositionSettings, decompose
from geom.convex.hull import contains, thickness, volume
from geom.decomposition.simplified_body import simplify_body
from geom.solid.solidify import solidify
from schemas.model import Mesh
from schemas.physics import Solid
from tests.support.sample_surfaces import box, inside_out, lidless, together


def mesh(surface) -> Mesh:
    points, triangles = surface
    return Mesh("part", np.asarray(points, dtype=float), np.asarray(triangles, dtype=np.int32))


def ell(size: float = 1.0, shift: float = 0.0):
    points, triangles = together(box((1.0, 0.3, 0.3)), box((0.3, 0.3, 1.0), at=(-0.35, 0.0, 0.5)))
    return points * size + shift, triangles


def doubled():
    points, triangles = ell()
    return points, np.concatenate([triangles, triangles])


def soup():
    rng = np.random.default_rng(1)
    return rng.normal(size=(900, 3)), np.arange(900).reshape(-1, 3)


SURFACES = {
    "flat": lambda: (np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float), np.array([[0, 1, 2], [0, 2, 3]])),
    "single triangle": lambda: (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.2]], float), np.array([[0, 1, 2]])),
    "open box": lambda: lidless(box((0.3, 0.2, 0.15))),
    "two overlapping boxes": lambda: together(box(), box(at=(0.5, 0.4, 0.3))),
    "duplicate faces": doubled,
    "inside out": lambda: inside_out(ell()),
    "a micrometre": lambda: ell(1e-6),
    "a thousand kilometres": lambda: ell(1e6),
    "far from the origin": lambda: ell(1.0, 1e5),
}


@pytest.mark.parametrize("name", SURFACES)
def test_every_surface_ends_with_sound_shapes(name, tmp_path):
    solid, _ = solidify([mesh(SURFACES[name]())])
    chosen = choose_colliders(solid, tmp_path)
    assert 1 <= len(chosen.shapes) <= 32
    figures = next(c for c in chosen.candidates if c.method == chosen.method)
    assert figures.accepted or chosen.diagnostics[0].code == "asset/collision-fallback"
    size = float(np.linalg.norm(np.ptp(solid.points, axis=0)))
    for shape in chosen.shapes:
        if shape.points is not None and shape.triangles is not None:
            assert len(shape.points) <= 64
            assert volume(shape.points, shape.triangles) > 0.0
            assert thickness(shape.points, shape.triangles) > 1e-4 * size
            assert contains(shape.points, shape.triangles, shape.points, 1e-6 * size).all()


def closed(surface) -> Solid:
    points, triangles = surface
    return Solid(points, np.asarray(triangles, dtype=np.int32), "closed")


def test_two_overlapping_boxes_are_a_few_hulls(tmp_path):
    solid, _ = solidify([mesh(SURFACES["two overlapping boxes"]())])
    assert len(choose_colliders(solid, tmp_path).shapes) <= 4


@pytest.mark.parametrize("broken", ["nan", "index", "empty", "soup"])
def test_what_is_no_surface_is_refused_by_name(broken):
    points, triangles = ell()
    if broken == "nan":
        points = np.where(np.arange(len(points))[:, None] == 3, np.nan, points)
    elif broken == "index":
        triangles = np.concatenate([triangles, [[0, 1, 10_000]]])
    elif broken == "soup":
        points, triangles = soup()
    else:
        points, triangles = points[:0], triangles[:0]
    with pytest.raises(ValueError, match=r"finite|does not exist|empty|closed manifold"):
        simplify_body(points, triangles)


def test_equal_bytes_twice(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=4)
    points = np.array(ball.vertices) * (1.0 + 0.3 * np.sin(5.0 * np.array(ball.vertices)[:, [2]]))
    body = simplify_body(points, np.array(ball.faces))
    for settings in (DecompositionSettings(method="cuts"), DecompositionSettings()):
        first, again = (decompose(body, settings, tmp_path).shapes for _ in range(2))
        assert [s.points.tobytes() for s in first] == [s.points.tobytes() for s in again]  # pyright: ignore


def test_too_many_faces_never_reach_coacd(tmp_path):
    rough = trimesh.creation.icosphere(subdivisions=5)
    noise = np.random.default_rng(0).uniform(0.85, 1.15, size=(len(rough.vertices), 1))
    body = simplify_body(np.array(rough.vertices) * noise, np.array(rough.faces))
    assert body.simplified.num_tri() > MOST_FACES
    started = time.process_time()
    assert "faces" in decompose(body, DecompositionSettings(), tmp_path).reason
    assert time.process_time() - started < DECOMPOSITION_CPU_S


def test_a_million_faces_take_bounded_time(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=8)
    points = np.array(ball.vertices)
    points = points * (1.0 + 0.2 * np.sin(4.0 * points[:, [0]]))
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime + time.process_time()
    body = simplify_body(points, np.array(ball.faces))
    found = decompose(body, DecompositionSettings(method="cuts"), tmp_path)
    spent = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime + time.process_time() - before
    assert len(ball.faces) > 1_000_000
    assert 0 < len(found.shapes) <= 32
    assert spent < 60.0
