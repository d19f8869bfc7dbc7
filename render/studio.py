"""Lighting and floor of asset pictures: soft environment light, two camera lamps, grey floor with a shadow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageFilter
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkActor, vtkLight, vtkMapper, vtkPolyDataMapper, vtkRenderer, vtkTexture
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLRenderer, vtkOpenGLTexture

from render.polydata import triangle_soup
from schemas.arrays import AnyFloatArray, Float32Array, FloatArray

BACKGROUND_SRGB = 238  # Grey value of the empty picture.
_FLOOR_HALF = 1.6  # Half the edge of the floor that carries the shadow, in units of the largest box edge.
_FLOOR_PX = 128
# (upper height, blur, darkness): points close to the floor cast a dark, sharp shadow, higher ones a pale, wide one.
_SHADOW_LAYERS = ((0.05, 0.025, 0.42), (0.25, 0.08, 0.26), (1.01, 0.2, 0.16))


@dataclass(frozen=True)
class Lamp:
    """A far lamp that turns with the camera: the direction to it in camera axes (right, up, backward), irradiance."""

    towards_C: tuple[float, float, float]
    intensity: float


LAMPS = (Lamp((-1.3, 1.2, 0.9), 0.8), Lamp((1.2, 0.2, 1.0), 0.1))  # a key from the upper left, a faint fill


def studio_renderer() -> vtkRenderer:
    """An empty renderer with the light of the studio; the scene is the annotation frame (z up)."""
    vtkMapper.SetResolveCoincidentTopologyToPolygonOffset()  # A switch of the whole process, so set it always.
    renderer = vtkOpenGLRenderer()
    renderer.SetBackground(*([BACKGROUND_SRGB / 255.0] * 3))
    renderer.SetAutomaticLightCreation(False)
    for lamp in LAMPS:
        renderer.AddLight(_camera_light(lamp))
    add_environment_light(renderer)
    return renderer


def add_environment_light(renderer: vtkOpenGLRenderer, tint: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> None:
    """Light `renderer` by `environment` times `tint`, linear RGB."""
    renderer.UseImageBasedLightingOn()
    renderer.SetEnvironmentUp(0.0, 0.0, 1.0)
    renderer.SetEnvironmentTexture(_environment_texture(tint), False)
    renderer.SetUseSphericalHarmonics(True)
    # VTK's defaults (1024 samples, 1024 px table) cost 5 s of one core; these cost 0.2 s and look the same.
    renderer.GetEnvMapPrefiltered().SetPrefilterMaxSamples(64)
    renderer.GetEnvMapLookupTable().SetLUTSize(128)
    renderer.GetEnvMapLookupTable().SetLUTSamples(128)


def environment() -> Float32Array:
    """(64, 128, 3) float32 linear radiance: a dome, a soft box on the left and one behind on the right.

    Rows are elevations from the nadir up, columns azimuths from the viewer's side to the right.
    """
    elevation_deg, azimuth_deg = np.meshgrid(
        (np.arange(64) + 0.5) / 64.0 * 180.0 - 90.0, (np.arange(128) + 0.5) / 128.0 * 360.0, indexing="ij"
    )
    sine = np.sin(np.radians(elevation_deg))
    light = 0.44 + np.where(sine > 0.0, 0.25, 0.1) * sine  # Less from below: the floor reflects light.
    light += 2.6 * _near(azimuth_deg, -55.0, 32.0) * _near(elevation_deg, 38.0, 18.0)
    light += 1.8 * _near(azimuth_deg, 140.0, 45.0) * _near(elevation_deg, 30.0, 14.0)
    return np.repeat(light[..., None], 3, axis=2).astype(np.float32)


def _near(angle_deg: AnyFloatArray, centre_deg: float, half_width_deg: float) -> AnyFloatArray:
    """1 around `centre_deg`, 0 beyond 1.25 half widths, smooth between."""
    distance = np.abs((angle_deg - centre_deg + 180.0) % 360.0 - 180.0)
    t = np.clip((1.25 - distance / half_width_deg) / 0.5, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _environment_texture(tint: tuple[float, float, float]) -> vtkTexture:
    pixels = environment() * np.array(tint, dtype=np.float32)
    image = vtkImageData()
    image.SetDimensions(pixels.shape[1], pixels.shape[0], 1)
    image.GetPointData().SetScalars(numpy_to_vtk(pixels.reshape(-1, 3), deep=True))
    texture = vtkOpenGLTexture()
    texture.SetInputData(image)
    texture.SetColorModeToDirectScalars()
    texture.MipmapOn()
    texture.InterpolateOn()
    return texture


def _camera_light(lamp: Lamp) -> vtkLight:
    light = vtkLight()
    light.SetLightTypeToCameraLight()
    light.SetPosition(*lamp.towards_C)
    light.SetFocalPoint(0.0, 0.0, 0.0)
    light.SetIntensity(lamp.intensity)
    return light


def floor(points: FloatArray, bottom: float) -> vtkActor:
    """A floor in the colour of the background at height `bottom`, darkened below `points` (n, 3)."""
    shade = 1.0 - contact_shadow(points, bottom)
    pixels = np.repeat(np.round(shade * BACKGROUND_SRGB).astype(np.uint8)[..., None], 3, axis=2)
    image = vtkImageData()
    image.SetDimensions(_FLOOR_PX, _FLOOR_PX, 1)
    image.GetPointData().SetScalars(numpy_to_vtk(pixels.reshape(-1, 3), deep=True))
    texture = vtkOpenGLTexture()
    texture.SetInputData(image)
    texture.SetColorModeToDirectScalars()
    texture.InterpolateOn()
    texture.SetWrap(vtkTexture.ClampToEdge)
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    height = bottom - 2e-3  # Below flat sheets that lie on the floor.
    square = np.concatenate([corners * _FLOOR_HALF, np.full((4, 1), height)], axis=1)
    halves = np.array([[0, 1, 2], [0, 2, 3]])
    up = np.tile([0.0, 0.0, 1.0], (2, 3, 1))
    data = triangle_soup(square[halves], up, {"uv": (corners[halves] + 1.0) / 2.0})
    data.GetPointData().SetActiveTCoords("uv")
    mapper = vtkPolyDataMapper()
    mapper.SetInputDataObject(data)
    result = vtkActor()
    result.SetMapper(mapper)
    result.SetTexture(texture)
    result.GetProperty().LightingOff()
    return result


def contact_shadow(points: FloatArray, bottom: float) -> FloatArray:
    """(px, px) darkness 0..1 of the floor, rows along +y: soft occlusion by `points` (n, 3), the lower the stronger."""
    light = np.ones((_FLOOR_PX, _FLOOR_PX))
    height = points[:, 2] - bottom
    cell = np.floor((points[:, :2] / _FLOOR_HALF + 1.0) * _FLOOR_PX / 2.0).astype(np.int64)
    cell = cell.clip(0, _FLOOR_PX - 1)
    for top, blur, darkness in _SHADOW_LAYERS:
        covered = np.zeros((_FLOOR_PX, _FLOOR_PX), dtype=np.uint8)
        below = height <= top
        covered[cell[below, 1], cell[below, 0]] = 255
        radius = blur / (2.0 * _FLOOR_HALF) * _FLOOR_PX
        soft = np.asarray(Image.fromarray(covered).filter(ImageFilter.GaussianBlur(radius)), dtype=np.float64) / 255.0
        light *= 1.0 - darkness * soft
    return 1.0 - light
