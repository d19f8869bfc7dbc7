"""Renders all pictures of one asset: standard views, thumbnail, collision shapes, grasps, parts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

from render.camera import HERO_VIEW, AnnotationFrame, annotation_frame, camera, model_frame
from render.collision import collision_actors, shape_mesh
from render.grasps import grasp_actors, half_extents
from render.joints import draw_strip
from render.modes.beauty import is_translucent, looks
from render.parts import draw_parts
from render.ready_studio import take_studio
from render.request import RenderRequest
from render.studio import floor
from render.surface_samples import surface_samples
from render.surfaces import FAINT, ShadedSurface, plain_actor, surfaces
from render.window import enable_depth_peeling, save_png, take_picture

THUMBNAIL_PX = 256


def render_all(request: RenderRequest) -> dict[str, Path]:
    """Write the pictures of `request`; their paths by name: four views, `thumbnail`, `collision` if there are shapes,
    `parts` if there are parts, `joints` if the joints of a mechanism are to be shown.

    Raises NoOpenGL when the system has no software OpenGL. A driver without its back end may kill the process: run it
    in a cell (`python -m render previews`).
    """
    folder = Path(request.out_dir)
    folder.mkdir(parents=True, exist_ok=True)
    frame = model_frame(request.model) if request.box_m is None else annotation_frame(*request.box_m)
    parts = tuple(part for part in surfaces(request.model, frame) if len(part.points))
    window, renderer = take_studio()
    renderer.AddActor(floor(surface_samples(parts), bottom=-frame.extent[2] / 2.0))
    if request.grasps:
        pictures = {"grasps": _draw_grasps(request, frame, parts, window, renderer)}
    else:
        pictures = _draw_views(request, frame, parts, window, renderer)
    if request.shapes:
        pictures["collision"] = _draw_collision(request, frame, parts, window, renderer)
    if request.parts and request.part_of is not None and parts:
        renderer.RemoveAllViewProps()
        renderer.AddActor(floor(surface_samples(parts), bottom=-frame.extent[2] / 2.0))
        pictures["parts"] = draw_parts(request, request.part_of, frame, window, renderer)
    if request.joints and request.model.mechanism is not None:
        pictures["joints"] = draw_strip(request.model, request.model.mechanism, window, renderer, request.size_px)
    paths = {name: folder / f"{name}.png" for name in pictures}
    for name, picture in pictures.items():
        save_png(picture, paths[name])
    return paths


def _draw_views(
    request: RenderRequest,
    frame: AnnotationFrame,
    parts: tuple[ShadedSurface, ...],
    window: vtkRenderWindow,
    renderer: vtkRenderer,
) -> dict[str, Image.Image]:
    visuals = looks(request.model, frame, parts)
    for visual in visuals:
        renderer.AddActor(visual)
    if is_translucent(visuals):
        enable_depth_peeling(renderer)
    sizes = dict.fromkeys(request.views, request.size_px) | {HERO_VIEW: THUMBNAIL_PX}
    pictures = {v.name: take_picture(window, renderer, camera(v, frame.extent), px) for v, px in sizes.items()}
    for visual in visuals:
        renderer.RemoveActor(visual)
    return pictures


def _draw_collision(
    request: RenderRequest,
    frame: AnnotationFrame,
    parts: tuple[ShadedSurface, ...],
    window: vtkRenderWindow,
    renderer: vtkRenderer,
) -> Image.Image:
    meshes = [shape_mesh(shape, frame) for shape in request.shapes]
    if parts:
        renderer.AddActor(plain_actor(parts, FAINT))
    for overlay in collision_actors(meshes):
        renderer.AddActor(overlay)
    enable_depth_peeling(renderer)
    # Shapes that protrude from the model must be in the picture, too.
    shape_half_extents = np.abs(np.concatenate([mesh.points for mesh in meshes])).max(axis=0)
    lens = camera(HERO_VIEW, np.maximum(frame.extent, 2.0 * shape_half_extents))
    return take_picture(window, renderer, lens, request.size_px)


def _draw_grasps(
    request: RenderRequest,
    frame: AnnotationFrame,
    parts: tuple[ShadedSurface, ...],
    window: vtkRenderWindow,
    renderer: vtkRenderer,
) -> Image.Image:
    if parts:
        renderer.AddActor(plain_actor(parts, FAINT))
    for lines in grasp_actors(request.grasps, frame):
        renderer.AddActor(lines)
    lens = camera(HERO_VIEW, np.maximum(frame.extent, 2.0 * half_extents(request.grasps, frame)))
    return take_picture(window, renderer, lens, request.size_px)
