"""Picture of an object's parts: the hero view with one colour per part label, and a legend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

from render.camera import HERO_VIEW, AnnotationFrame, camera
from render.collision import shape_color
from render.request import RenderRequest
from render.surfaces import actor, surfaces
from render.textures import TextureSet
from render.window import take_picture
from schemas.appearance.material import Material
from schemas.arrays import IntArray
from schemas.model import Mesh, Model

GREY = (0.72, 0.72, 0.72)
UNLABELLED = "unlabelled"
_LINE_PX, _FONT_PX = 22, 14


def draw_parts(
    request: RenderRequest, part_of: IntArray, frame: AnnotationFrame, window: vtkRenderWindow, renderer: vtkRenderer
) -> Image.Image:
    """The hero view with every triangle in the colour of its label; unlabelled ones are grey; with a legend."""
    colors = label_colors(request.parts)
    for surface in surfaces(painted(request.model, part_of, colors), frame):
        if len(surface.points):
            renderer.AddActor(actor(surface, TextureSet(())))
    picture = take_picture(window, renderer, camera(HERO_VIEW, frame.extent), request.size_px)
    return _with_legend(picture, request.parts, colors)


def label_colors(labels: Sequence[str]) -> list[tuple[float, float, float]]:
    """The sRGB colour of each label; grey for unlabelled ones."""
    return [GREY if label.startswith(UNLABELLED) else shape_color(i) for i, label in enumerate(labels)]


def painted(model: Model, part_of: IntArray, colors: list[tuple[float, float, float]]) -> Model:
    """The model cut up by label, each piece with a matte material of its colour."""
    palette = [*colors, GREY]
    materials = tuple(
        Material(name=f"part {i}", base_color=_linear(color), roughness=0.9) for i, color in enumerate(palette)
    )
    meshes: list[Mesh] = []
    first = 0
    for mesh in model.meshes:
        mesh_parts = part_of[first : first + len(mesh.triangles)]
        first += len(mesh.triangles)
        for index in np.unique(mesh_parts):
            faces = mesh_parts == index
            normals = None if mesh.normals is None else mesh.normals[faces]
            triangles = mesh.triangles[faces]
            painted = replace(mesh, triangles=triangles, normals=normals, uvs=(), colors=None, material=int(index))
            meshes.append(painted if index >= 0 else replace(painted, material=len(colors)))
    return replace(model, meshes=tuple(meshes), materials=materials, textures=())


def _linear(color: tuple[float, float, float]) -> tuple[float, float, float]:
    """sRGB as linear RGB, by the plain power law."""
    red, green, blue = (c**2.2 for c in color)
    return red, green, blue


def _with_legend(
    picture: Image.Image, labels: tuple[str, ...], colors: list[tuple[float, float, float]]
) -> Image.Image:
    result = picture.convert("RGB")
    drawn, font = ImageDraw.Draw(result), ImageFont.load_default(_FONT_PX)
    for row, (label, color) in enumerate(zip(labels, colors, strict=True)):
        top = 10 + row * _LINE_PX
        red, green, blue = (round(255.0 * c) for c in color)
        drawn.rectangle((10, top, 24, top + 14), fill=(red, green, blue))
        drawn.text((32, top - 1), label, fill=(30, 34, 40), font=font)
    return result
