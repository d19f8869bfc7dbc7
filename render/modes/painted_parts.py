"""Every triangle in the colour of its part's label."""

from __future__ import annotations

from render.camera import AnnotationFrame
from render.modes.drawn import Drawn
from render.modes.request import ModeRequest
from render.parts import GREY, label_colors, painted
from render.surfaces import ShadedSurface, actor, surfaces
from render.textures import TextureSet


def painted_parts(request: ModeRequest, frame: AnnotationFrame, parts: tuple[ShadedSurface, ...]) -> Drawn:
    """The painted surfaces and the labels; all grey where the object has no parts on record."""
    colors = label_colors(request.parts)
    if request.part_of is None:
        shown = parts
    else:
        shown = tuple(s for s in surfaces(painted(request.model, request.part_of, colors), frame) if len(s.points))
    legend = tuple(zip(colors, request.parts, strict=True)) or ((GREY, "no parts on record"),)
    return Drawn(tuple(actor(surface, TextureSet(())) for surface in shown), legend=legend)
