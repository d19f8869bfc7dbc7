"""The object as it looks: materials and textures under the light of the studio."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkRenderingCore import vtkActor

from render.camera import AnnotationFrame
from render.modes.drawn import Drawn
from render.modes.request import ModeRequest
from render.surfaces import ShadedSurface, actor
from render.textures import TextureSet
from render.window import SUPERSAMPLING
from schemas.model import Model

THIN = 0.01  # needles thinner than this share of their length are drawn as lines, else they fall between samples


def beauty(request: ModeRequest, frame: AnnotationFrame, parts: tuple[ShadedSurface, ...]) -> Drawn:
    """The visible surfaces; no legend."""
    actors = looks(request.model, frame, parts)
    return Drawn(actors, is_translucent(actors))


def looks(model: Model, frame: AnnotationFrame, parts: tuple[ShadedSurface, ...]) -> tuple[vtkActor, ...]:
    """An actor for each surface of the model, with its material; lines where the object is a needle."""
    textures = TextureSet(model.textures)
    actors = tuple(actor(part, textures) for part in parts)
    if np.sort(frame.extent)[1] < THIN:
        for each in actors:
            each.GetProperty().SetRepresentationToWireframe()
            each.GetProperty().SetLineWidth(2.0 * SUPERSAMPLING)
    return actors


def is_translucent(actors: tuple[vtkActor, ...]) -> bool:
    """Whether light passes through one of them."""
    return any(each.GetForceTranslucent() for each in actors)
