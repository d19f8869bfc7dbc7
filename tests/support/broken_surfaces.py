"""Clean solids of many kinds, and ways to break them; every seed gives another."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import manifold3d
import numpy as np
import trimesh

from tests.support.sample_surfaces import ball, box, inside_out, together

Surface = tuple[np.ndarray, np.ndarray]


def _trimesh(solid: trimesh.Trimesh) -> Surface:
    return np.array(solid.vertices, dtype=float), np.array(solid.faces, dtype=np.int32)


def _manifold(solid: manifold3d.Manifold) -> Surface:
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties)[:, :3], np.array(mesh.tri_verts).astype(np.int32)


def _rod(radius: float, height: float) -> manifold3d.Manifold:
    return manifold3d.Manifold.cylinder(height, radius, radius, 40, True)


def _block(x: float, y: float, z: float) -> manifold3d.Manifold:
    return manifold3d.Manifold.cube((x, y, z), True)


SHAPES: dict[str, Callable[[np.random.Generator], Surface]] = {
    "box": lambda rng: box(rng.uniform(0.5, 2.0, 3)),
    "dense box": lambda rng: _trimesh(trimesh.creation.box(rng.uniform(0.5, 2.0, 3)).subdivide().subdivide()),
    "ball": lambda rng: ball(rng.uniform(0.5, 2.0), 3),
    "cylinder": lambda rng: _trimesh(trimesh.creation.cylinder(rng.uniform(0.3, 1), rng.uniform(1, 3), sections=48)),
    "capsule": lambda rng: _trimesh(trimesh.creation.capsule(rng.uniform(1, 2), 0.4, count=(16, 16))),
    "ring": lambda rng: _trimesh(trimesh.creation.annulus(0.5, rng.uniform(0.6, 0.9), rng.uniform(0.2, 1), 32)),
    "torus": lambda rng: _trimesh(trimesh.creation.torus(1.0, rng.uniform(0.2, 0.4), 32, 16)),
    "drilled block": lambda rng: _manifold(_block(2, 1.5, 1) - _rod(rng.uniform(0.2, 0.5), 3)),
    "thin cup": lambda rng: _manifold(_rod(0.5, 1.2) - _rod(rng.uniform(0.42, 0.47), 1.2).translate((0, 0, 0.06))),
    "lens": lambda rng: _manifold(
        manifold3d.Manifold.sphere(1, 40) ^ manifold3d.Manifold.sphere(1, 40).translate((rng.uniform(0.6, 1), 0.1, 0))
    ),
    "hollow ball": lambda rng: together(ball(1.0, 3), inside_out(ball(rng.uniform(0.3, 0.8), 2))),
}


def neighbours(triangles: np.ndarray, rng: np.random.Generator, count: int) -> list[int]:
    """`count` faces that hang together by edges."""
    chosen = [int(rng.integers(len(triangles)))]
    while len(chosen) < count:
        shared = np.isin(triangles, np.unique(triangles[chosen])).sum(axis=1) >= 2
        shared[chosen] = False
        chosen.append(int(rng.choice(np.flatnonzero(shared))))
    return chosen


def _diagonal(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def _unit(rng: np.random.Generator) -> np.ndarray:
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def one_face_missing(surface: Surface, rng: np.random.Generator) -> Surface:
    """A face of some size: a sliver that is missing is a crack, which no one sees and the solid closes."""
    corners = surface[0][surface[1]]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return surface[0], np.delete(surface[1], rng.choice(np.flatnonzero(area >= np.median(area))), axis=0)


def patch_missing(surface: Surface, rng: np.random.Generator) -> Surface:
    return surface[0], np.delete(surface[1], neighbours(surface[1], rng, int(rng.integers(2, 5))), axis=0)


def faces_turned(surface: Surface, rng: np.random.Generator) -> Surface:
    turned = rng.random(len(surface[1])) < rng.uniform(0.1, 0.45)
    turned[0] = True
    return surface[0], np.where(turned[:, None], surface[1][:, [0, 2, 1]], surface[1])


def all_turned(surface: Surface, _: np.random.Generator) -> Surface:
    return inside_out(surface)


def faces_twice(surface: Surface, rng: np.random.Generator) -> Surface:
    again = surface[1][rng.permutation(len(surface[1]))[: max(3, len(surface[1]) // 20)]]
    return surface[0], np.vstack([surface[1], again])


def backs_of_faces(surface: Surface, rng: np.random.Generator) -> Surface:
    again = surface[1][neighbours(surface[1], rng, max(3, len(surface[1]) // 40))]
    return surface[0], np.vstack([surface[1], again[:, [0, 2, 1]]])


def collapsed_faces(surface: Surface, rng: np.random.Generator) -> Surface:
    point = rng.integers(0, len(surface[0]), max(3, len(surface[1]) // 12))
    return surface[0], np.vstack([surface[1], np.stack([point, point, (point + 1) % len(surface[0])], axis=1)])


def stray_triangle(surface: Surface, rng: np.random.Generator) -> Surface:
    points, triangles = surface
    a, b, c = triangles[rng.integers(len(triangles))]
    normal = np.cross(points[b] - points[a], points[c] - points[a])
    tip = 0.5 * (points[a] + points[b]) + rng.uniform(0.02, 0.1) * _diagonal(points) * normal / np.linalg.norm(normal)
    return np.vstack([points, tip]), np.vstack([triangles, [[a, b, len(points)]]])


def whole_shell_twice(surface: Surface, _: np.random.Generator) -> Surface:
    return together(surface, surface)


def floating_crumbs(surface: Surface, rng: np.random.Generator) -> Surface:
    size, middle = _diagonal(surface[0]), surface[0].mean(axis=0)
    crumbs = [
        (middle + size * (rng.uniform(0.6, 1.5) * _unit(rng) + 0.002 * rng.normal(size=(3, 3))), np.array([[0, 1, 2]]))
        for _ in range(int(rng.integers(1, 6)))
    ]
    return together(surface, *crumbs)


def sides_split(surface: Surface, rng: np.random.Generator) -> Surface:
    points, triangles = surface
    a, b, c = triangles[index := int(rng.integers(len(triangles)))]
    halves = [[a, len(points), c], [len(points), b, c]]
    middle = points[a] + rng.uniform(0.2, 0.8) * (points[b] - points[a])
    return np.vstack([points, middle]), np.vstack([np.delete(triangles, index, axis=0), halves])


class Defect(NamedTuple):
    """How to break a solid, and the repair that must be named for it; None when mending needs no words."""

    break_: Callable[[Surface, np.random.Generator], Surface]
    repair: str | None


DEFECTS = {
    "one face missing": Defect(one_face_missing, "hole_fill"),
    "patch missing": Defect(patch_missing, "hole_fill"),
    "faces turned": Defect(faces_turned, "flip_winding"),
    "all turned": Defect(all_turned, "flip_winding"),
    "faces twice": Defect(faces_twice, "degenerate_faces"),
    "backs of faces": Defect(backs_of_faces, "degenerate_faces"),
    "collapsed faces": Defect(collapsed_faces, "degenerate_faces"),
    "stray triangle": Defect(stray_triangle, "non_manifold_edge"),
    "whole shell twice": Defect(whole_shell_twice, "duplicate_shell"),
    "floating crumbs": Defect(floating_crumbs, "fragment_removal"),
    "sides split": Defect(sides_split, "crack_stitch"),
}
