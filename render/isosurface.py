"""Zero isosurface of a scalar field on a regular grid, as triangles (flying edges, Schroeder et al. 2015)."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

from schemas.arrays import AnyFloatArray, FloatArray, IntArray


def zero_surface(field: AnyFloatArray, origin: FloatArray, step: float) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) and triangles (m, 3) where `field` (x, y, z) changes sign; its first value is at `origin`."""
    grid = vtkImageData()
    grid.SetDimensions(*field.shape)
    grid.SetOrigin(*origin)
    grid.SetSpacing(step, step, step)
    grid.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(field.ravel(order="F"))))
    surface = vtkFlyingEdges3D()
    surface.SetInputData(grid)
    surface.SetValue(0, 0.0)
    surface.ComputeNormalsOff()
    surface.Update()
    triangulated = surface.GetOutput()
    if triangulated.GetNumberOfPoints() == 0:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32)
    points = vtk_to_numpy(triangulated.GetPoints().GetData()).astype(np.float64)
    return points, vtk_to_numpy(triangulated.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int32)
