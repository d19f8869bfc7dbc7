"""VTK actors of grasps: line drawings of the gripper around the object, coloured by trial result."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from vtkmodules.vtkFiltersCore import vtkTubeFilter
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from render.camera import AnnotationFrame
from render.drawn_grasp import DrawnGrasp
from render.polydata import line_segments
from schemas.arrays import FloatArray

# Green, red and blue of different lightness, for people with weak red-green vision.
COLOURS = {"held": (0.05, 0.45, 0.12), "not_held": (0.85, 0.1, 0.05), "untried": (0.15, 0.3, 0.75)}
THICK = 0.007  # of the largest edge of the object; untried ones are thinner


def grasp_actors(grasps: Sequence[DrawnGrasp], frame: AnnotationFrame) -> list[vtkActor]:
    """One actor for each grasp, in the annotation frame."""
    return [_actor(grasp, frame) for grasp in grasps]


def half_extents(grasps: Sequence[DrawnGrasp], frame: AnnotationFrame) -> FloatArray:
    """(3,) the largest distance of the lines from the centre of the frame along each axis."""
    ends = np.concatenate([grasp.lines_m.reshape(-1, 3) for grasp in grasps])
    return np.abs(frame.from_asset(ends)).max(axis=0)


def _actor(grasp: DrawnGrasp, frame: AnnotationFrame) -> vtkActor:
    tube = vtkTubeFilter()
    tube.SetInputDataObject(line_segments(frame.from_asset(grasp.lines_m.reshape(-1, 3)).reshape(-1, 2, 3)))
    tube.SetRadius(THICK * (0.5 if grasp.trial == "untried" else 1.0))
    tube.SetNumberOfSides(8)
    tube.CappingOn()
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(tube.GetOutputPort())
    result = vtkActor()
    result.SetMapper(mapper)
    result.GetProperty().SetColor(*COLOURS[grasp.trial])
    result.GetProperty().SetAmbient(0.5)
    result.GetProperty().SetDiffuse(0.5)
    return result
