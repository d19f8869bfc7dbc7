"""Off-screen OpenGL window without display or GPU, and the RGB pictures rendered in it."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
from PIL import Image
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
from vtkmodules.vtkRenderingOpenGL2 import vtkEGLRenderWindow, vtkOSOpenGLRenderWindow

from render.camera import FIELD_OF_VIEW_RAD, PinholeCamera

SUPERSAMPLING = 2  # Samples per pixel and axis; on llvmpipe cheaper and sharper than multisampling or FXAA.


class NoOpenGL(Exception):
    """No software OpenGL library was found; the message names the system packages that hold one."""


def offscreen_window() -> vtkRenderWindow:
    """A window that draws into memory: through OSMesa, else through EGL.

    The libraries are probed first because VTK dies of a segmentation fault when they are missing. Raises NoOpenGL.
    """
    if _loads("libOSMesa.so.8"):
        window: vtkRenderWindow = vtkOSOpenGLRenderWindow()
    elif _loads("libEGL.so.1") and _loads("libEGL_mesa.so.0"):
        window = vtkEGLRenderWindow()
    else:
        raise NoOpenGL(
            "No software OpenGL: install the system package libosmesa6, or libegl1 with libgl1-mesa-dri (Debian names)."
        )
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(True)
    return window


def take_picture(window: vtkRenderWindow, renderer: vtkRenderer, camera: PinholeCamera, size_px: int) -> Image.Image:
    """The square RGB picture that `renderer` shows through `camera`, `SUPERSAMPLING`² samples averaged per pixel."""
    edge = size_px * SUPERSAMPLING
    window.SetSize(edge, edge)
    _aim_camera(renderer, camera)
    window.Render()
    pixels = vtkUnsignedCharArray()
    window.GetPixelData(0, 0, edge - 1, edge - 1, 0, pixels, 0)
    rows = vtk_to_numpy(pixels).reshape(edge, edge, 3)[::-1]  # OpenGL counts rows from the bottom.
    return Image.fromarray(np.ascontiguousarray(rows)).reduce(SUPERSAMPLING)


def enable_depth_peeling(renderer: vtkRenderer) -> None:
    """Sort translucent surfaces per pixel."""
    renderer.SetUseDepthPeeling(True)
    renderer.SetMaximumNumberOfPeels(6)
    renderer.SetOcclusionRatio(0.0)


def save_png(image: Image.Image, path: Path) -> None:
    """Write `image` as PNG without any metadata: equal pixels give equal bytes."""
    image.save(path, format="PNG", compress_level=6)


def _aim_camera(renderer: vtkRenderer, camera: PinholeCamera) -> None:
    lens = renderer.GetActiveCamera()
    lens.SetPosition(*camera.position)
    lens.SetFocalPoint(0.0, 0.0, 0.0)
    lens.SetViewUp(*camera.R_NC[:, 1])
    lens.SetViewAngle(np.degrees(FIELD_OF_VIEW_RAD))
    lens.SetClippingRange(camera.near, camera.far)
    # The studio turns with the camera, so that every view has the same light on its visible side.
    renderer.SetEnvironmentRight(*camera.R_NC[:, 0])


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
