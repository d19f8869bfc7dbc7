"""Convex collision shapes of a recording's bodies: hulls are exact, so that a shape contains its source."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from formats.mesh_points import in_shape_frame
from geom.convex.hull import convex_hull
from geom.pose import apply, pose
from replay.recording.recorded_numbers import invalid_recording
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape
from schemas.robot_description import MeshReference

MESH_FILES = (".obj", ".stl", ".ply", ".dae", ".glb")
UNSCALED = (1.0, 1.0, 1.0)
PLANE_THICKNESS_M, PLANE_HALF_M = 0.1, 10.0


def hull(points: FloatArray, name: str, file: str) -> CollisionShape:
    """The convex hull of points (n, 3) as a shape in their frame. Raises InvalidInput where they span no volume."""
    try:
        return CollisionShape("hull", (), np.eye(4), *convex_hull(np.asarray(points, dtype=np.float64)))
    except ValueError as error:
        raise invalid_recording("replay/bad-mesh", f"mesh of '{name}': {error}", file) from None


def ellipsoid(half_m: tuple[float, ...], X_BG: FloatArray) -> CollisionShape:
    """A hull around an ellipsoid: a subdivided icosahedron whose faces touch it from outside."""
    ball = trimesh.creation.icosphere(subdivisions=2)
    inner = float(np.einsum("ij,ij->i", ball.face_normals, ball.triangles[:, 0]).min())
    points, triangles = convex_hull(np.asarray(ball.vertices) / inner * np.asarray(half_m))
    return CollisionShape("hull", (), np.eye(4), apply(X_BG, points), triangles)


def plane(size_m: tuple[float, ...], X_BG: FloatArray) -> CollisionShape:
    """A plane of full lengths as a slab below its surface; an infinite one (0) ends 10 m from its origin."""
    x, y = (length if length > 0.0 else 2.0 * PLANE_HALF_M for length in size_m[:2])
    down = pose(None, (0.0, 0.0, -PLANE_THICKNESS_M / 2.0))
    return CollisionShape("box", (x, y, PLANE_THICKNESS_M), X_BG @ down)


def mesh_points(path: Path, scale: tuple[float, ...], file: str) -> FloatArray:
    """Vertices (n, 3) of a mesh file, scaled. Raises InvalidInput."""
    try:
        mesh = trimesh.load(path, force="mesh", process=False, skip_materials=True)
        points = np.asarray(mesh.vertices, dtype=np.float64) * scale  # pyright: ignore[reportAttributeAccessIssue]
    except Exception as error:  # Readers of foreign formats raise what they like.
        raise invalid_recording("replay/bad-mesh", f"'{path.name}' cannot be read: {error}", file) from None
    if not len(points) or not np.isfinite(points).all():
        raise invalid_recording("replay/bad-mesh", f"'{path.name}' has no finite vertices", file)
    return points


def described_mesh(mesh: MeshReference, root: Path, meshes: Path | None, file: str) -> FloatArray:
    """Vertices (n, 3) of a mesh of a robot description in the frame of its shape.

    Its file lies inside `root`, else in the folder `meshes`. Raises InvalidInput.
    """
    if mesh.vertices is not None:
        return in_shape_frame(mesh, mesh.vertices)
    readable = mesh.path and Path(mesh.path).suffix.lower() in MESH_FILES
    path = root / mesh.path if readable else locate_mesh(mesh.uri, root, meshes, file)
    return in_shape_frame(mesh, mesh_points(path, UNSCALED, file))


def locate_mesh(name: str, folder: Path, meshes: Path | None, file: str) -> Path:
    """The file that a model names: inside `folder`, else the one in `meshes` that shares the longest end of its path.

    Raises InvalidInput.
    """
    words = [word for word in name.replace("\\", "/").removeprefix("package://").split("/") if word not in ("", ".")]
    if not words or Path(words[-1]).suffix.lower() not in MESH_FILES:
        raise invalid_recording("replay/missing-mesh", f"'{name}' is no mesh file that Mana reads", file)
    inside = (folder / "/".join(words)).resolve()
    if ".." not in words and inside.is_relative_to(folder.resolve()) and inside.is_file():
        return inside
    if meshes is None:
        relative = not name.startswith(("/", "package:")) and ":" not in name
        code = (
            "replay/path-escape" if relative and not inside.is_relative_to(folder.resolve()) else "replay/missing-mesh"
        )
        raise invalid_recording(
            code, f"mesh '{name}' is not in the folder of the recording; name its folder with --meshes", file
        )
    words = [word for word in words if word != ".."]
    for start in range(len(words)):
        end = "/".join(words[start:])
        hits = sorted(p for p in meshes.rglob(words[-1]) if p.is_file() and ("/" + p.as_posix()).endswith("/" + end))
        if len(hits) == 1:
            return hits[0]
        if hits:
            raise invalid_recording(
                "replay/missing-mesh", f"'{name}': {len(hits)} files in the folder of meshes fit", file
            )
    raise invalid_recording("replay/missing-mesh", f"'{name}' is not in the folder of meshes", file)
