"""What a mode shows of an object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vtkmodules.vtkRenderingCore import vtkActor

Legend = Sequence[tuple[tuple[float, float, float], str]]  # sRGB and words


@dataclass(frozen=True)
class Drawn:
    """Actors in the annotation frame, whether some are translucent, a legend."""

    actors: tuple[vtkActor, ...]
    translucent: bool = False
    legend: Legend = ()
