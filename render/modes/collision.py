"""What a simulator collides with: the shapes, translucent, over the object in grey."""

from __future__ import annotations

from collections import Counter

from render.camera import AnnotationFrame
from render.collision import collision_actors, shape_color, shape_mesh
from render.modes.drawn import Drawn
from render.modes.request import ModeRequest
from render.surfaces import FAINT, ShadedSurface, plain_actor


def collision(request: ModeRequest, frame: AnnotationFrame, parts: tuple[ShadedSurface, ...]) -> Drawn:
    """The body and the shapes; the legend counts shapes by kind."""
    body = (plain_actor(parts, FAINT),) if parts else ()
    if not request.shapes:
        return Drawn(body, legend=((FAINT, "no collision shapes"),))
    kinds = Counter(shape.kind for shape in request.shapes)
    words = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    legend = ((shape_color(0), f"collision shapes, a colour each: {words}"),)
    return Drawn((*body, *collision_actors([shape_mesh(shape, frame) for shape in request.shapes])), True, legend)
