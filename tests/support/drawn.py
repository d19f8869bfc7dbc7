"""Small models for the renderer, and colours read from its pictures."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from PIL import Image

from geom.mesh.primitives import cube
from render.camera import STANDARD_VIEWS, CameraView, PinholeCamera, camera, model_frame
from render.request import RenderRequest
from render.views import render_all
from schemas.appearance.material import Material, Texture, TextureUse
from schemas.evidence import Evidence
from schemas.model import Mesh, Model
from schemas.physics import CollisionShape

PX = 128
FRONT, LEFT, BACK, TOP = STANDARD_VIEWS
QUAD = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
UNIT_UVS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float32)
RED = (0.6, 0.02, 0.02)
CORNERS = np.zeros((64, 64, 3))
CORNERS[:32, :32] = (220, 0, 0)  # top left of the file
CORNERS[:32, 32:] = (0, 220, 0)
CORNERS[32:, :32] = (0, 0, 220)
CORNERS[32:, 32:] = (220, 220, 0)


def model(*meshes: Mesh, materials: tuple[Material, ...] = (), textures: tuple[Texture, ...] = ()) -> Model:
    metres = Evidence[float](value=1.0, source="declared", method="test", confidence=1.0)
    up = Evidence(value="z", source="declared", method="test", confidence=1.0)
    return Model(meshes, materials, textures, (), metres, up)  # pyright: ignore[reportArgumentType]  # the Literal


def box(size: tuple[float, float, float], at: tuple[float, float, float] = (0, 0, 0), material: int | None = 0) -> Mesh:
    shape = cube(1.0)
    return Mesh(
        "box",
        shape.points * size + at,
        shape.triangles.astype(np.int32),
        shape.normals.astype(np.float32),
        (),
        None,
        material,
    )


def upright(uvs: np.ndarray = UNIT_UVS, x: float = 0.0, half: float = 1.0, material: int = 0) -> Mesh:
    """A square sheet that faces +x: seen from the front, +y is to the right and the u axis of `uvs` follows it."""
    points = np.array([[x, -half, 0], [x, half, 0], [x, half, 2 * half], [x, -half, 2 * half]], dtype=np.float64)
    return Mesh("sheet", points, QUAD, None, (uvs[QUAD],), None, material)


def png(pixels: np.ndarray) -> bytes:
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    return file.getvalue()


def image(name: str, pixels: np.ndarray) -> Texture:
    return Texture(name, png(pixels.astype(np.uint8)), "png", pixels.shape[1], pixels.shape[0])


def pictures(
    content: Model, folder: Path, shapes: tuple[CollisionShape, ...] = (), size_px: int = PX
) -> dict[str, np.ndarray]:
    """(px, px, 3) int pictures by name."""
    paths = render_all(RenderRequest(content, shapes, str(folder), size_px))
    return {name: np.asarray(Image.open(path)).astype(int) for name, path in paths.items()}


def linear(srgb: np.ndarray) -> np.ndarray:
    value = np.asarray(srgb) / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def lens(content: Model, view: CameraView) -> tuple[PinholeCamera, np.ndarray]:
    """The camera of a view, and all points of the model in the annotation frame."""
    frame = model_frame(content)
    return camera(view, frame.extent), frame.from_asset(np.concatenate([mesh.points for mesh in content.meshes]))


def at(picture: np.ndarray, content: Model, view: CameraView, point_m: tuple[float, float, float]) -> np.ndarray:
    """Mean colour of the 3 x 3 pixels around the place where `point_m` is seen."""
    frame = model_frame(content)
    x, y = camera(view, frame.extent).project(frame.from_asset(np.array([point_m])), len(picture))[0].astype(int)
    return picture[y - 1 : y + 2, x - 1 : x + 2].reshape(-1, 3).mean(axis=0)


def textured(use: TextureUse) -> Model:
    return model(
        upright(),
        materials=(Material("print", base_color=(1, 1, 1), base_color_texture=use, roughness=1.0),),
        textures=(image("corners", CORNERS),),
    )
