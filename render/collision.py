"""VTK actors of collision shapes: tinted, translucent bodies with drawn edges, in the annotation frame."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from geom.mesh.primitives import capsule, cube, cylinder, sphere
from render.camera import AnnotationFrame
from render.polydata import line_segments, triangle_soup
from schemas.arrays import FloatArray, IntArray
from schemas.physics import CollisionShape

_OPACITY = 0.5
_EDGE_ANGLE_DEG = 20.0  # Edges of hulls sharper than this are drawn; flat triangulation is not.
_GOLDEN_RATIO = 0.61803398875
_SEGMENTS = 32


class ShapeMesh(NamedTuple):
    """A closed mesh: points (n, 3) in the annotation frame and outward triangles (m, 3)."""

    points: FloatArray
    triangles: IntArray


def shape_color(index: int) -> tuple[float, float, float]:
    """The sRGB colour of shape `index`: hues far apart for neighbours (golden-ratio steps), never grey or black."""
    return colorsys.hsv_to_rgb((0.58 + index * _GOLDEN_RATIO) % 1.0, (0.85, 0.6)[index // 8 % 2], 0.95)


def shape_mesh(shape: CollisionShape, frame: AnnotationFrame) -> ShapeMesh:
    """`shape` as triangles in the annotation frame; curved shapes are inscribed with 32 segments.

    Raises ValueError for a hull without points or triangles.
    """
    points, triangles = _local_mesh(shape)
    return ShapeMesh(frame.from_asset(points @ shape.X_AS[:3, :3].T + shape.X_AS[:3, 3]), triangles)


def collision_actors(meshes: Sequence[ShapeMesh]) -> tuple[vtkActor, vtkActor]:
    """The bodies, each in its `shape_color`, and the edges of `meshes` (at least one)."""
    return _bodies(meshes), _edges(meshes)


def _bodies(meshes: Sequence[ShapeMesh]) -> vtkActor:
    corners = [points[triangles] for points, triangles in meshes]
    normals = np.repeat(_unit_normals(np.concatenate(corners))[:, None], 3, axis=1)
    colors = np.concatenate([np.tile(shape_color(i), (3 * len(c), 1)) for i, c in enumerate(corners)])
    data = triangle_soup(np.concatenate(corners), normals, {})
    data.GetPointData().SetScalars(numpy_to_vtk(np.round(colors * 255.0).astype(np.uint8), deep=True))
    mapper = vtkPolyDataMapper()
    mapper.SetInputDataObject(data)
    mapper.SetColorModeToDirectScalars()
    result = vtkActor()
    result.SetMapper(mapper)
    surface = result.GetProperty()
    surface.SetAmbient(0.45)
    surface.SetDiffuse(0.55)
    surface.SetOpacity(_OPACITY)
    surface.BackfaceCullingOn()  # Shapes are closed: their far sides would only muddy the colours.
    return result


def _edges(meshes: Sequence[ShapeMesh]) -> vtkActor:
    ends = np.concatenate([points[_sharp_edges(points, triangles)] for points, triangles in meshes])
    mapper = vtkPolyDataMapper()
    mapper.SetInputDataObject(line_segments(ends))
    result = vtkActor()
    result.SetMapper(mapper)
    line = result.GetProperty()
    line.SetColor(0.16, 0.18, 0.22)
    line.SetLineWidth(1.5)
    line.LightingOff()
    return result


def _sharp_edges(points: FloatArray, triangles: IntArray) -> IntArray:
    """(e, 2) point pairs of the edges at which a closed mesh bends by more than `_EDGE_ANGLE_DEG`."""
    normals = _unit_normals(points[triangles])
    half = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    order = np.lexsort((half[:, 1], half[:, 0]))
    pairs = order[: len(order) // 2 * 2].reshape(-1, 2)  # In a closed mesh every edge belongs to two faces.
    cosine = np.einsum("ij,ij->i", normals[pairs[:, 0] // 3], normals[pairs[:, 1] // 3])
    return half[pairs[cosine < np.cos(np.radians(_EDGE_ANGLE_DEG)), 0]]


def _unit_normals(corners: FloatArray) -> FloatArray:
    """(m, 3) unit normals of (m, 3, 3) triangles; zero for those without area."""
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(face, axis=1, keepdims=True)
    return face / np.where(length > 0.0, length, 1.0)


def _local_mesh(shape: CollisionShape) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) and triangles (m, 3) in the frame of the shape, metres."""
    if shape.kind == "hull":
        if shape.points is None or shape.triangles is None:
            raise ValueError("a hull needs points and triangles")
        return shape.points, shape.triangles
    if shape.kind == "box":
        unit = cube(1.0)
        return unit.points * np.asarray(shape.size_m), unit.triangles
    if shape.kind == "sphere":
        return sphere(shape.size_m[0], _SEGMENTS)[:2]
    radius, height = shape.size_m
    if shape.kind == "cylinder":
        return cylinder(height, radius, radius, _SEGMENTS)[:2]
    return capsule(height, radius, radius, _SEGMENTS)[:2]
