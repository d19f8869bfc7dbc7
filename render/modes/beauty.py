"""The object as it looks: materials and textures under the light of the studio."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkRenderingCore import vtkActor

from render.camera import AnnotationFrame
from render.modes.request import ModeRequest
from render.modes.sheet import Legend
from render.surfaces import ShadedSurface, actor
from render.textures import TextureSet
from render.window import SUPERSAMPLING

THIN = 0.01  # needles thinner than this share of their length are drawn as lines, else they fall between samples


def beauty(
    request: ModeRequest, frame: AnnotationFrame, parts: tuple[ShadedSurface, ...]
) -> tuple[tuple[vtkActor, ...], bool, Legend]:
    """The visible surfaces; whether some are translucent; no legend."""
    textures = TextureSet(request.model.textures)
    actors = tuple(actor(part, textures) for part in parts)
    if np.sort(frame.extent)[1] < THIN:
        for each in actors:
            each.GetProperty().SetRepresentationToWireframe()
            each.GetProperty().SetLineWidth(2.0 * SUPERSAMPLING)
    return actors, any(each.GetForceTranslucent() for each in actors), ()
