"""Collision shapes as tinted, see-through bodies with drawn edges."""

from __future__ import annotations

import colorsys

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkCleanPolyData, vtkFeatureEdges
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from geom.gprims import capsule, cube, cylinder, sphere
from render.camera import AnnotationFrame
from render.polydata import triangle_soup
from schemas.model import FloatArray
from schemas.physics import CollisionShape

_OPACITY = 0.5
_EDGE_ANGLE_DEG = 20.0  # Edges of hulls sharper than this are drawn; flat triangulation is not.
_GOLDEN_RATIO = 0.61803398875
_SEGMENTS = 32


def shape_color(index: int) -> tuple[float, float, float]:
    """The sRGB colour of shape `index`: hues far apart for neighbours (golden-ratio steps), never grey or black."""
    return colorsys.hsv_to_rgb((0.58 + index * _GOLDEN_RATIO) % 1.0, (0.85, 0.6)[index // 8 % 2], 0.95)


def collision_actors(shapes: tuple[CollisionShape, ...], frame: AnnotationFrame) -> tuple[vtkActor, vtkActor]:
    """The bodies and the edges of `shapes` (at least one), each in its `shape_color`."""
    corners = [_corners(shape, frame) for shape in shapes]
    return _bodies(corners), _edges(corners)


def _bodies(corners: list[FloatArray]) -> vtkActor:
    points = np.concatenate(corners)
    face = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    length = np.linalg.norm(face, axis=1, keepdims=True)
    normals = np.repeat((face / np.where(length > 0.0, length, 1.0))[:, None], 3, axis=1)
    colors = np.concatenate([np.tile(shape_color(i), (3 * len(c), 1)) for i, c in enumerate(corners)])
    data = triangle_soup(points, normals, {})
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


def _edges(corners: list[FloatArray]) -> vtkActor:
    together = vtkAppendPolyData()
    for shape in corners:
        welded = vtkCleanPolyData()  # Each shape by itself: touching shapes keep their own edges.
        welded.SetInputDataObject(triangle_soup(shape, np.zeros_like(shape), {}))
        welded.SetTolerance(1e-6)
        edges = vtkFeatureEdges()
        edges.SetInputConnection(welded.GetOutputPort())
        edges.SetFeatureAngle(_EDGE_ANGLE_DEG)
        edges.ColoringOff()
        together.AddInputConnection(edges.GetOutputPort())
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(together.GetOutputPort())
    mapper.ScalarVisibilityOff()
    result = vtkActor()
    result.SetMapper(mapper)
    line = result.GetProperty()
    line.SetColor(0.16, 0.18, 0.22)
    line.SetLineWidth(1.5)
    line.LightingOff()
    return result


def _corners(shape: CollisionShape, frame: AnnotationFrame) -> FloatArray:
    """(m, 3, 3) triangle corners of `shape` in the annotation frame."""
    if shape.kind == "hull":
        if shape.points is None or shape.triangles is None:
            raise ValueError("a hull needs points and triangles")
        points, triangles = shape.points, shape.triangles
    elif shape.kind == "box":
        points, triangles, _ = cube(1.0)
        points = points * np.asarray(shape.size_m)
    elif shape.kind == "sphere":
        points, triangles, _ = sphere(shape.size_m[0], _SEGMENTS)
    elif shape.kind == "cylinder":
        radius, height = shape.size_m
        points, triangles, _ = cylinder(height, radius, radius, _SEGMENTS)
    else:
        radius, height = shape.size_m
        points, triangles, _ = capsule(height, radius, radius, _SEGMENTS)
    points_A = points @ shape.X_AS[:3, :3].T + shape.X_AS[:3, 3]
    return frame.from_asset(points_A)[triangles].astype(np.float32)
