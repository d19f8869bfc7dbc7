"""Renders a recording from one of its cameras: colour, depth and instance images, one file per row.

Colour is lit, with ambient occlusion and smoothed edges; depth (mm) and instance numbers come from one unlit pass,
sampled at pixel centres.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkFloatArray, vtkUnsignedCharArray
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkActor, vtkLight, vtkMapper, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLRenderer

from geom.convex.support_function import surface
from geom.mesh.corner_normals import corner_normals
from render.camera import AnnotationFrame
from render.frames_request import DrawnBody, FramesRequest
from render.polydata import triangle_soup
from render.studio import add_environment_light
from render.surfaces import ShadedSurface, actor, surfaces
from render.textures import TextureSet
from render.window import offscreen_window
from schemas.appearance.material import Material
from schemas.arrays import Float32Array, FloatArray, IntArray

RGB, DEPTH, INSTANCES = "rgb", "depth", "instances"
MM_PER_M = 1000.0
_NEAR_M, _FAR_M = 0.01, 65.0  # What 16 bits hold in millimetres.
_WORLD = AnnotationFrame(np.zeros(3), 1.0, np.ones(3))
_SKY = (0.80, 0.84, 0.88)
_LAMP = (-0.346, -0.574, 0.742)  # Unit direction to the lamp of written stages, in W.
_LAMP_INTENSITY, _DOME = 0.8, 0.7
_CORNER_M = 0.1  # Radius within which surfaces shade one another.


def draw_frames(request: FramesRequest) -> None:
    """Write `rgb/`, `depth/` and `instances/` below the folder of the request, `000000.png` and so on by row.

    Depth is along the optical axis in millimetres, 16 bits, 0 where nothing is within 65 m; instances are the numbers
    of bodies, 0 for none. Raises NoOpenGL.
    """
    folder = Path(request.out_dir)
    for kind in (RGB, DEPTH, INSTANCES):
        (folder / kind).mkdir(parents=True, exist_ok=True)
    color_stage, label_stage = _color_stage(request), _label_stage(request)
    for k, row in enumerate(request.rows):
        name = f"{row:06d}.png"
        _save(color_stage.picture(k), folder / RGB / name)
        ids, depth_m = label_stage.labels(k)
        most = max([body.id for body in request.bodies] + [model.id for model in request.models], default=0)
        _save(Image.fromarray(ids.astype(np.uint8 if most < 256 else np.uint16)), folder / INSTANCES / name)
        mm = np.round(depth_m * MM_PER_M).astype(np.uint16)
        _save(Image.fromarray(mm), folder / DEPTH / name)


def _save(image: Image.Image, path: Path) -> None:
    """Save as PNG without metadata; stronger compression would take as long as the rendering."""
    image.save(path, format="PNG", compress_level=1)


class _PosableScene:
    """An off-screen window with a scene whose bodies can be posed at any of the rows."""

    def __init__(self, request: FramesRequest, renderer: vtkRenderer) -> None:
        self._request = request
        self.size_px = (request.width_px, request.height_px)
        self.renderer = renderer
        self.window: vtkRenderWindow = offscreen_window()
        self.window.SetSize(*self.size_px)
        self.window.AddRenderer(renderer)
        self._movers: list[tuple[vtkActor, FloatArray]] = []

    def add(self, visual: vtkActor, X_WB: FloatArray) -> None:
        """Add `visual`, in the frame of its body, at (k, 4, 4) poses or at one."""
        self.renderer.AddActor(visual)
        _place(visual, X_WB[0])
        if len(X_WB) > 1:
            self._movers.append((visual, X_WB))

    def _draw(self, k: int) -> None:
        for visual, X_WB in self._movers:
            _place(visual, X_WB[k])
        X_WC = self._request.X_WC[k]
        lens = self.renderer.GetActiveCamera()
        lens.SetPosition(*X_WC[:3, 3])
        lens.SetFocalPoint(*(X_WC[:3, 3] - X_WC[:3, 2]))
        lens.SetViewUp(*X_WC[:3, 1])
        lens.SetViewAngle(np.degrees(self._request.fovy_rad))
        lens.SetClippingRange(_NEAR_M, _FAR_M)
        self.window.Render()

    def _pixels(self) -> IntArray:
        width, height = self.size_px
        pixels = vtkUnsignedCharArray()
        self.window.GetPixelData(0, 0, width - 1, height - 1, 0, pixels, 0)
        return vtk_to_numpy(pixels).reshape(height, width, 3)[::-1]  # OpenGL counts rows from the bottom.

    def picture(self, k: int) -> Image.Image:
        """The RGB image of row number `k`."""
        self._draw(k)
        return Image.fromarray(np.ascontiguousarray(self._pixels()))

    def labels(self, k: int) -> tuple[IntArray, FloatArray]:
        """Numbers of bodies and depths along the optical axis (m), 0 where there is nothing: (height, width) both."""
        self._draw(k)
        width, height = self.size_px
        buffer = vtkFloatArray()
        self.window.GetZbufferData(0, 0, width - 1, height - 1, buffer)
        z = vtk_to_numpy(buffer).reshape(height, width)[::-1].astype(np.float64)
        depth_m = _NEAR_M * _FAR_M / (_FAR_M - z * (_FAR_M - _NEAR_M))
        pixels = self._pixels().astype(np.int64)
        return pixels[..., 0] + 256 * pixels[..., 1], np.where(z < 1.0, depth_m, 0.0)


def _color_stage(request: FramesRequest) -> _PosableScene:
    vtkMapper.SetResolveCoincidentTopologyToPolygonOffset()
    renderer = vtkOpenGLRenderer()
    renderer.SetBackground(*_SKY)
    renderer.SetAutomaticLightCreation(False)
    red, green, blue = request.dome
    add_environment_light(renderer, (_DOME * red, _DOME * green, _DOME * blue))
    renderer.SetEnvironmentRight(float(np.cos(request.dome_rad)), float(np.sin(request.dome_rad)), 0.0)
    lamp = vtkLight()
    lamp.SetLightTypeToSceneLight()
    lamp.SetPosition(*_LAMP)
    lamp.SetFocalPoint(0.0, 0.0, 0.0)
    lamp.SetColor(*request.lamp)
    lamp.SetIntensity(_LAMP_INTENSITY)
    renderer.AddLight(lamp)
    # On llvmpipe half the cost of 2 x 2 samples, which show no corners.
    renderer.SetUseFXAA(True)
    renderer.SetUseSSAO(True)
    renderer.SetSSAORadius(_CORNER_M)
    renderer.SetSSAOBias(0.004)
    renderer.SetSSAOKernelSize(32)
    renderer.SetSSAOBlur(True)
    stage = _PosableScene(request, renderer)
    for body in request.bodies:
        if body.shapes:
            material = Material(name="plain", base_color=body.color, roughness=0.6)
            corners, normals = _corners(body)
            stage.add(actor(ShadedSurface(material, (), corners, normals, {}), TextureSet(())), body.X_WB)
    for drawn in request.models:
        textures = TextureSet(drawn.model.textures)
        for part in surfaces(drawn.model, _WORLD):
            if len(part.points):
                stage.add(actor(part, textures), np.eye(4)[None])
    return stage


def _label_stage(request: FramesRequest) -> _PosableScene:
    renderer = vtkOpenGLRenderer()
    renderer.SetBackground(0.0, 0.0, 0.0)
    stage = _PosableScene(request, renderer)
    for body in request.bodies:
        if body.shapes:
            stage.add(_label(body.id, _corners(body)[0]), body.X_WB)
    for drawn in request.models:
        parts = [part.points for part in surfaces(replace(drawn.model, textures=()), _WORLD)]
        if parts:
            stage.add(_label(drawn.id, np.concatenate(parts)), np.eye(4)[None])
    return stage


def _label(number: int, corners: Float32Array) -> vtkActor:
    """Triangles (m, 3, 3) in the flat colour that encodes their instance number."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputDataObject(triangle_soup(corners, np.zeros_like(corners), {}))
    result = vtkActor()
    result.SetMapper(mapper)
    result.GetProperty().SetColor(number % 256 / 255.0, number // 256 / 255.0, 0.0)
    result.GetProperty().LightingOff()
    return result


def _corners(body: DrawnBody) -> tuple[Float32Array, Float32Array]:
    """Corners and normals (m, 3, 3) of the shapes of a body, in its frame."""
    meshes = [surface(shape) for shape in body.shapes]
    corners = np.concatenate([points[triangles] for points, triangles in meshes])
    normals = np.concatenate([corner_normals(points, triangles) for points, triangles in meshes])
    return corners.astype(np.float32), normals.astype(np.float32)


def _place(visual: vtkActor, X_WB: FloatArray) -> None:
    matrix = vtkMatrix4x4()
    matrix.DeepCopy(X_WB.ravel().tolist())
    visual.SetUserMatrix(matrix)
