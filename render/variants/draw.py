"""Draws a model under each of several sets of materials, and its regions in flat colours, in the same views."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from render.camera import camera, model_frame
from render.ready_studio import take_studio
from render.surfaces import actor, set_material, surfaces
from render.textures import TextureSet
from render.variants.regions import OTHER, region_rgb
from render.variants.request import VariantsRequest
from render.window import enable_depth_peeling, save_png, take_picture


def draw_variants(request: VariantsRequest) -> None:
    """Write `K_VIEW.png` of each variant and `regions_VIEW.png`. Raises NoOpenGL as `offscreen_window`."""
    window, renderer = take_studio()
    frame = model_frame(request.model)
    cameras = {view.name: camera(view, frame.extent) for view in request.views}
    out = Path(request.out_dir)
    textures = TextureSet(request.model.textures)
    named = tuple(replace(material, name=f"{index}") for index, material in enumerate(request.model.materials))
    parts = [part for part in surfaces(replace(request.model, materials=named), frame) if len(part.points)]
    visuals = [(int(part.material.name), actor(part, textures)) for part in parts]
    for _, visual in visuals:
        renderer.AddActor(visual)
    for number, materials in enumerate(request.variants):
        for index, visual in visuals:
            set_material(visual, materials[index])
        if any(visual.GetForceTranslucent() for _, visual in visuals):
            enable_depth_peeling(renderer)
        else:
            renderer.SetUseDepthPeeling(False)
        for name, lens in cameras.items():
            save_png(take_picture(window, renderer, lens, request.size_px), out / f"{number}_{name}.png")
    renderer.SetUseDepthPeeling(False)
    region_of = {index: number for number, index in enumerate(request.regions)}
    for index, visual in visuals:
        renderer.RemoveActor(visual)
        renderer.AddActor(_flat(visual, region_rgb(region_of.get(index, OTHER))))
    for name, lens in cameras.items():
        save_png(take_picture(window, renderer, lens, request.size_px), out / f"regions_{name}.png")


def _flat(visual: vtkActor, rgb: tuple[int, int, int]) -> vtkActor:
    """The surface of an actor in one colour whatever the light."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputDataObject(visual.GetMapper().GetInputDataObject(0, 0))
    mapper.ScalarVisibilityOff()
    result = vtkActor()
    result.SetMapper(mapper)
    result.GetProperty().LightingOff()
    result.GetProperty().SetColor(*(value / 255.0 for value in rgb))
    result.ForceOpaqueOn()
    return result
