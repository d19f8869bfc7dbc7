"""Converts triangle and line arrays into VTK polydata (copies, float32)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkDataArray, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

from schemas.arrays import AnyFloatArray, FloatArray


def triangle_soup(
    points: AnyFloatArray, normals: AnyFloatArray, attributes: Mapping[str, AnyFloatArray]
) -> vtkPolyData:
    """Polydata of m separate triangles: `points` and `normals` (m, 3, 3), `attributes` name -> (m, 3, k); all copied.

    Corners are not shared, so that each keeps its own normal, texture coordinates and colour.
    """
    count = len(points)
    data = vtkPolyData()
    vertices = vtkPoints()
    vertices.SetData(_vtk(points.reshape(-1, 3)))
    data.SetPoints(vertices)
    data.SetPolys(_cells(count, 3))
    data.GetPointData().SetNormals(_vtk(normals.reshape(-1, 3)))
    for name, values in attributes.items():
        array = _vtk(values.reshape(3 * count, -1))
        array.SetName(name)
        data.GetPointData().AddArray(array)
    return data


def line_segments(ends: FloatArray) -> vtkPolyData:
    """Polydata of e separate lines between the points `ends` (e, 2, 3); copied."""
    data = vtkPolyData()
    vertices = vtkPoints()
    vertices.SetData(_vtk(ends.reshape(-1, 3)))
    data.SetPoints(vertices)
    data.SetLines(_cells(len(ends), 2))
    return data


def _cells(count: int, corners: int) -> vtkCellArray:
    """`count` cells of `corners` consecutive points each."""
    cells = vtkCellArray()
    offsets = np.arange(0, corners * count + 1, corners, dtype=np.int32)
    cells.SetData(numpy_to_vtk(offsets, deep=True), numpy_to_vtk(np.arange(corners * count, dtype=np.int32), deep=True))
    return cells


def _vtk(values: AnyFloatArray) -> vtkDataArray:
    return numpy_to_vtk(np.ascontiguousarray(values, dtype=np.float32), deep=True)
