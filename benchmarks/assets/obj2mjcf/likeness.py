"""How close two decompositions come to the same source mesh, by the same code, in the frame of the source file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from assetkit.library.validate import main_usd_files
from assetkit.package.record import read_record
from geom.convex.hull import convex_hull
from geom.convex.support_function import surface
from geom.decomposition.fidelity import measure_fidelity, union_surface
from geom.mesh.surface_distance import two_way_distance
from geom.pose import matrix_of
from schemas.arrays import FloatArray, IntArray
from schemas.physics import CollisionShape, Solid
from usdio.reread.body import reread_body


@dataclass(frozen=True)
class Likeness:
    """Distances in percent of the diagonal of the source mesh.

    p95      95th percentile from the surface of the hulls to the mesh, or from the mesh to the hulls, whichever is more
             (a point of the mesh inside a hull counts 0).
    mean     mean of both one-sided mean distances between the two surfaces.
    largest  the larger of both maxima over samples and corners.
    """

    hulls: int
    p95: float
    mean: float
    largest: float


def source_mesh(obj_file: Path) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) and triangles (m, 3) of all parts of an OBJ file, as trimesh reads it."""
    mesh = trimesh.load_mesh(obj_file, process=False)
    return np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int32)


def likeness(parts: Sequence[FloatArray], points: FloatArray, triangles: IntArray) -> Likeness:
    """Figures of convex parts (corner points each) against a mesh; all in one frame and unit.

    Raises ValueError when no part has a volume.
    """
    low, size = points.min(axis=0), float(np.linalg.norm(np.ptp(points, axis=0)))
    shapes = [shape for part in parts if (shape := _hull((part - low) / size)) is not None]
    solid = Solid((points - low) / size, triangles, "shell")
    figures = measure_fidelity("any", shapes, solid, ())
    union = two_way_distance(*union_surface(shapes), solid.points, triangles)
    return Likeness(
        hulls=len(parts),
        p95=100 * max(figures.outside_p95, figures.missing_p95),
        mean=50 * (union.a_to_b_mean + union.b_to_a_mean),
        largest=100 * max(figures.outside_max, figures.missing_max),
    )


def package_parts(package: Path) -> list[FloatArray]:
    """Corner points of a package's collision shapes, taken back to the frame and unit of the source file.

    Curved shapes are inscribed polyhedra. Raises ValueError when the folder is no package.
    """
    record = read_record(package)
    if record is None:
        raise ValueError(f"{package.name} is no package")
    R_AS = matrix_of(np.asarray(record.geometry.source_quat_wxyz))
    offset, scale = np.asarray(record.geometry.origin_offset_m), record.source.meters_per_unit.value
    shapes = reread_body(main_usd_files(package)[0]).shapes
    return [((surface(shape)[0] - offset) / scale) @ R_AS for shape in shapes]


def _hull(points: FloatArray) -> CollisionShape | None:
    """All corners, however many; None for a part without volume."""
    try:
        corners, faces = convex_hull(points)
    except ValueError:
        return None
    return CollisionShape("hull", (), np.eye(4), corners, faces)
