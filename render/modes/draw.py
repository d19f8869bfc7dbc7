"""Draws one mode of an object from each view, and the contact sheet. The modes stand in one table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from PIL import Image

from render.camera import AnnotationFrame, camera, model_frame
from render.modes.beauty import beauty
from render.modes.collision import collision
from render.modes.drawn import Drawn
from render.modes.painted_parts import painted_parts
from render.modes.physics import physics
from render.modes.request import Mode, ModeRequest
from render.modes.sheet import contact_sheet
from render.modes.wire import wire
from render.ready_studio import take_studio
from render.studio import floor
from render.surface_samples import surface_samples
from render.surfaces import ShadedSurface, surfaces
from render.window import enable_depth_peeling, save_png, take_picture

Draw = Callable[[ModeRequest, AnnotationFrame, tuple[ShadedSurface, ...]], Drawn]

MODES: Mapping[Mode, Draw] = {
    "beauty": beauty,
    "wire": wire,
    "parts": painted_parts,
    "collision": collision,
    "physics": physics,
}


def draw_mode(request: ModeRequest) -> dict[str, Path]:
    """Writes the picture of each view and the sheet; their paths by name.

    Raises NoOpenGL when the system has no software OpenGL. A driver without its back end may kill the process: run it
    in a cell (`python -m render mode`).
    """
    folder = Path(request.out_dir)
    frame = model_frame(request.model)
    parts = tuple(part for part in surfaces(request.model, frame) if len(part.points))
    window, renderer = take_studio()
    if request.mode != "physics":  # The box of inertia may reach below the floor.
        renderer.AddActor(floor(surface_samples(parts), bottom=-frame.extent[2] / 2.0))
    drawn = MODES[request.mode](request, frame, parts)
    for each in drawn.actors:
        renderer.AddActor(each)
    if drawn.translucent:
        enable_depth_peeling(renderer)
    pictures: dict[str, Image.Image] = {}
    for view in request.views:
        pictures[view.name] = take_picture(window, renderer, camera(view, frame.extent), request.size_px)
    written = {f"{request.mode}_{name.removeprefix('view_')}": picture for name, picture in pictures.items()}
    written[request.mode] = contact_sheet(pictures, request.title, request.facts, drawn.legend)
    paths = {name: folder / f"{name}.png" for name in written}
    for name, picture in written.items():
        save_png(picture, paths[name])
    return paths
