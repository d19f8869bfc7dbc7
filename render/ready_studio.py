"""A window and a studio renderer made once in a process for its forks: context, light and usual shaders are ready.

A process that draws pictures spends a fifth of a second on its OpenGL context and the tables of the environment light,
and as much on shaders. `prepare_studio` does this in the parent with a sample object; a fork takes the pair over with
`take_studio` and draws the same pixels. Forking is sound for a process of one thread only, so Mesa's shader cache on
disk, which has a thread of its own, is off then: preparing takes a second and pays from a few assets on.
"""

from __future__ import annotations

import io
import os
import tempfile
from dataclasses import replace

import numpy as np
from PIL import Image
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

from geom.mesh.primitives import cube
from render.drawn_grasp import DrawnGrasp
from render.request import RenderRequest
from render.studio import studio_renderer
from render.window import offscreen_window
from schemas.appearance.material import Material, Texture, TextureUse
from schemas.evidence import default
from schemas.model import Mesh, Model
from schemas.physics import CollisionShape

_SAMPLE_PX = 16  # Shaders do not depend on the size of a picture.
_PEELS, _OCCLUSION = 4, 0.0  # VTK's defaults of depth peeling
_ready: tuple[vtkRenderWindow, vtkRenderer] | None = None


def prepare_studio() -> None:
    """Make the pair and draw the sample with it. Call it before VTK is used in a process that forks.

    Raises NoOpenGL when the system has no software OpenGL. A driver without its back end kills the process.
    """
    from render.views import render_all

    global _ready
    os.environ["LP_NUM_THREADS"] = "0"
    os.environ["MESA_SHADER_CACHE_DISABLE"] = "true"
    window, renderer = offscreen_window(), studio_renderer()
    window.AddRenderer(renderer)
    with tempfile.TemporaryDirectory() as folder:
        for request in _samples(folder):
            _ready = window, renderer
            render_all(request)
            renderer.RemoveAllViewProps()
            renderer.SetUseDepthPeeling(False)
            renderer.SetMaximumNumberOfPeels(_PEELS)
            renderer.SetOcclusionRatio(_OCCLUSION)
    _ready = window, renderer


def take_studio() -> tuple[vtkRenderWindow, vtkRenderer]:
    """The prepared pair, once; else a new window with a new studio renderer. Raises NoOpenGL as `offscreen_window`."""
    global _ready
    pair, _ready = _ready, None
    if pair is None:
        pair = offscreen_window(), studio_renderer()
        pair[0].AddRenderer(pair[1])
    return pair


def _samples(folder: str) -> tuple[RenderRequest, RenderRequest]:
    """A plain and a textured cube with a collider and a part, and the same with a grasp."""
    points, triangles, normals = cube(1.0)
    picture = io.BytesIO()
    Image.new("RGB", (2, 2)).save(picture, "PNG")
    uvs = np.tile(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], dtype=np.float32), (len(triangles), 1, 1))
    plain = Mesh("plain", points, triangles.astype(np.int32), normals.astype(np.float32), id="plain")
    textured = replace(plain, name="textured", points=points + 1.0, uvs=(uvs,), material=0, id="textured")
    material = Material("textured", base_color_texture=TextureUse("texture"))
    texture = Texture("texture", picture.getvalue(), "png", 2, 2)
    model = Model((plain, textured), (material,), (texture,), (), default(1.0), default("z"))
    collider = CollisionShape("box", (1.0, 1.0, 1.0), np.eye(4))
    part_of = np.zeros(2 * len(triangles), dtype=np.int64)
    request = RenderRequest(model, (collider,), folder, _SAMPLE_PX, parts=("part",), part_of=part_of)
    return request, replace(request, shapes=(), parts=(), grasps=(DrawnGrasp(points[None, :2], "held"),))
