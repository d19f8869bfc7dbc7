"""The edges of all triangles over a pale body: how the mesh is made."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from render.camera import AnnotationFrame
from render.modes.drawn import Drawn
from render.modes.request import ModeRequest
from render.polydata import line_segments
from render.surfaces import ShadedSurface, plain_actor
from schemas.arrays import FloatArray

_BODY = (0.8, 0.8, 0.78)
_WIRE = (0.1, 0.16, 0.28)
_WIRE_PX = 1.0  # of the picture with several samples per pixel: half a pixel in the end


def wire(_request: ModeRequest, _frame: AnnotationFrame, parts: tuple[ShadedSurface, ...]) -> Drawn:
    """A pale body and its edges; the legend counts them."""
    if not parts:
        return Drawn(())
    edges = edges_of(np.concatenate([part.points for part in parts]).astype(np.float64))
    triangles = sum(len(part.points) for part in parts)
    legend = ((_WIRE, f"{triangles:,} triangles, {len(edges):,} edges"),)
    return Drawn((plain_actor(parts, _BODY), line_actor(edges, _WIRE, _WIRE_PX)), legend=legend)


def edges_of(corners: FloatArray) -> FloatArray:
    """(e, 2, 3) each edge of triangles (m, 3, 3) once; corners at one place count as one."""
    places, at = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    triangles = at.reshape(-1, 3)
    pairs = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    pairs = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
    return places[pairs]


def line_actor(ends: FloatArray, color: tuple[float, float, float], width_px: float) -> vtkActor:
    """Lines (e, 2, 3) of one sRGB colour, not lit."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputDataObject(line_segments(ends))
    result = vtkActor()
    result.SetMapper(mapper)
    line = result.GetProperty()
    line.SetColor(*color)
    line.SetLineWidth(width_px)
    line.LightingOff()
    return result
