"""Triangles as VTK takes them."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

from schemas.model import FloatArray


def triangle_soup(points: FloatArray, normals: FloatArray, attributes: dict[str, FloatArray]) -> vtkPolyData:
    """Polydata of m separate triangles: `points` and `normals` (m, 3, 3), `attributes` name -> (m, 3, k); all copied.

    Corners are not shared, so that each keeps its own normal, texture coordinates and colour.
    """
    count = len(points)
    data = vtkPolyData()
    vertices = vtkPoints()
    vertices.SetData(_vtk(points.reshape(-1, 3)))
    data.SetPoints(vertices)
    cells = vtkCellArray()
    offsets = np.arange(0, 3 * count + 1, 3, dtype=np.int32)
    corners = np.arange(3 * count, dtype=np.int32)
    cells.SetData(numpy_to_vtk(offsets, deep=True), numpy_to_vtk(corners, deep=True))
    data.SetPolys(cells)
    data.GetPointData().SetNormals(_vtk(normals.reshape(-1, 3)))
    for name, values in attributes.items():
        array = _vtk(values.reshape(3 * count, -1))
        array.SetName(name)
        data.GetPointData().AddArray(array)
    return data


def _vtk(values: FloatArray) -> object:
    return numpy_to_vtk(np.ascontiguousarray(values, dtype=np.float32), deep=True)
