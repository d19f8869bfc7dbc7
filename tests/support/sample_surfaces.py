"""Small surfaces, sound and broken, shared by the geometry tests."""

from __future__ import annotations

import numpy as np
import trimesh

from schemas.model import Mesh


def mesh_of(points, triangles, name: str = "part") -> Mesh:
    """A Mesh with normals, one UV set and colours that tell every corner apart."""
    triangles = np.asarray(triangles, dtype=np.int32)
    points = np.asarray(points, dtype=np.float64)
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    return Mesh(
        name=name,
        points=points,
        triangles=triangles,
        normals=np.repeat(normals[:, None], 3, axis=1).astype(np.float32),
        uvs=(corners[..., :2].astype(np.float32),),
        colors=np.concatenate([corners, np.ones((*corners.shape[:2], 1))], axis=2).astype(np.float32),
    )


def _from(solid: trimesh.Trimesh) -> tuple[np.ndarray, np.ndarray]:
    return np.array(solid.vertices), np.array(solid.faces, dtype=np.int32)


def box(size=(1.0, 1.0, 1.0), at=(0.0, 0.0, 0.0)) -> tuple[np.ndarray, np.ndarray]:
    points, triangles = _from(trimesh.creation.box(size))
    return points + np.asarray(at), triangles


def ball(radius: float = 1.0, subdivisions: int = 3, at=(0.0, 0.0, 0.0)) -> tuple[np.ndarray, np.ndarray]:
    points, triangles = _from(trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius))
    return points + np.asarray(at), triangles


def cylinder(radius: float = 0.5, height: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    return _from(trimesh.creation.cylinder(radius=radius, height=height, sections=24))


def without(surface, is_gone) -> tuple[np.ndarray, np.ndarray]:
    """The surface without the faces for which `gone(centroid, normal)` holds."""
    points, triangles = surface
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    remaining = [not is_gone(c, n) for c, n in zip(corners.mean(axis=1), normals, strict=True)]
    return points, triangles[remaining]


def lidless(surface) -> tuple[np.ndarray, np.ndarray]:
    """Without the faces that look straight up."""
    return without(surface, lambda _, normal: normal[2] > 0.99)


def together(*surfaces) -> tuple[np.ndarray, np.ndarray]:
    starts = np.cumsum([0, *(len(points) for points, _ in surfaces)])
    triangles = [t + s for (_, t), s in zip(surfaces, starts[:-1], strict=True)]
    return np.concatenate([points for points, _ in surfaces]), np.concatenate(triangles).astype(np.int32)


def inside_out(surface) -> tuple[np.ndarray, np.ndarray]:
    points, triangles = surface
    return points, triangles[:, [0, 2, 1]]
