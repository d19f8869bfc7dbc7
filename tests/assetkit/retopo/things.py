"""Models whose colours and shapes are known in closed form: a checkered cube and a sphere with bumps."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import trimesh
from PIL import Image

from geom.mesh.corner_normals import corner_normals
from geom.mesh.weld import weld_points
from schemas.appearance.material import Material, Texture, TextureUse
from schemas.arrays import FloatArray
from schemas.evidence import declared
from schemas.model import Mesh, Model

EDGE_M, CELLS = 0.1, 4
COLOURS = np.array([[200, 40, 30], [30, 60, 210]], dtype=np.uint8)
BUMP, WAVES = 0.01, 9.0


def model_of(*meshes: Mesh, materials: tuple[Material, ...] = (), textures: tuple[Texture, ...] = ()) -> Model:
    return Model(meshes, materials, textures, (), declared(1.0, "test"), declared("z", "test")).with_mesh_ids()


def picture(name: str, levels: np.ndarray) -> Texture:
    stream = io.BytesIO()
    Image.fromarray(levels).save(stream, "PNG")
    return Texture(name, stream.getvalue(), "png", levels.shape[1], levels.shape[0])


def checkered_cube(cuts: int = 16) -> Model:
    """A cube of CELLS by CELLS fields a side; every side shows the picture, whose upper left quarter is green."""
    steps = np.arange(cuts + 1) / cuts
    u, v = np.meshgrid(steps, steps, indexing="ij")
    grid = np.arange((cuts + 1) ** 2).reshape(cuts + 1, cuts + 1)
    low, right, up, far = grid[:-1, :-1].ravel(), grid[1:, :-1].ravel(), grid[:-1, 1:].ravel(), grid[1:, 1:].ravel()
    square = np.concatenate([np.stack([low, right, far], axis=1), np.stack([low, far, up], axis=1)])
    flat = np.stack([u.ravel(), v.ravel()], axis=1)
    corners, uvs = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            a, b = (flat[:, 0] - 0.5) * side, flat[:, 1] - 0.5
            points = np.insert(np.stack([a, b], axis=1), axis, 0.5 * side, axis=1)
            normal = np.cross(points[square[0, 1]] - points[square[0, 0]], points[square[0, 2]] - points[square[0, 0]])
            wound = square if normal[axis] * side > 0 else square[:, ::-1]
            corners.append(points[wound] * EDGE_M)
            uvs.append(flat[wound])
    soup = np.concatenate(corners).reshape(-1, 3)
    points, triangles = weld_points(soup, np.arange(len(soup)).reshape(-1, 3))
    coordinates = np.concatenate(uvs).astype(np.float32)
    mesh = Mesh("cube", points, triangles.astype(np.int32), uvs=(coordinates,), material=0)
    material = Material("paint", (1.0, 1.0, 1.0), TextureUse("checker"))
    return model_of(mesh, materials=(material,), textures=(checker(),))


def side_uvs(points: FloatArray) -> FloatArray:
    """(k, 2) coordinates of the picture at points (k, 3) on the cube, in closed form."""
    axis = np.abs(points).argmax(axis=1)
    side = np.sign(points[np.arange(len(points)), axis])
    others = np.array([[1, 2], [0, 2], [0, 1]])[axis]
    a, b = (points[np.arange(len(points)), others[:, k]] / EDGE_M for k in (0, 1))
    return np.stack([a * side + 0.5, b + 0.5], axis=1)


def checker(size_px: int = 256) -> Texture:
    """The checker, blue and red; the quarter of small u and large v has green in place of red."""
    field = np.arange(size_px) * CELLS // size_px
    levels = COLOURS[(field[:, None] + field[None, :]) % 2].copy()
    upper_left = levels[: size_px // 2, : size_px // 2]  # rows of a picture run from the top
    upper_left[upper_left[..., 0] == COLOURS[0, 0]] = (20, 180, 60)
    return picture("checker", levels)


def checker_colour(uvs: FloatArray) -> np.ndarray:
    """(k, 3) the colours of the checker at coordinates (k, 2), v up, in closed form."""
    column, row = np.floor(uvs[:, 0] * CELLS).astype(int), np.floor((1.0 - uvs[:, 1]) * CELLS).astype(int)
    colours = COLOURS[(column + row) % 2].astype(np.float64)
    green = (uvs[:, 0] < 0.5) & (uvs[:, 1] > 0.5) & ((column + row) % 2 == 0)
    colours[green] = (20, 180, 60)
    return colours


def away_from_lines(uvs: FloatArray, margin: float = 0.02) -> np.ndarray:
    """(k,) whether coordinates lie farther than `margin` from every line of the checker and from its border."""
    return np.abs(uvs * CELLS - np.round(uvs * CELLS)).min(axis=1) > margin * CELLS


def bumpy_sphere(subdivisions: int = 6) -> Model:
    """A grey sphere of radius 1 with bumps of BUMP, too fine for a few hundred triangles."""
    ball = trimesh.creation.icosphere(subdivisions, 1.0)
    points = np.asarray(ball.vertices)
    waves = np.prod(np.sin(WAVES * points), axis=1)
    bumpy = points * (1.0 + BUMP * waves)[:, None]
    triangles = np.asarray(ball.faces, dtype=np.int32)
    mesh = Mesh("ball", bumpy, triangles, normals=corner_normals(bumpy, triangles, np.pi), material=0)
    return model_of(mesh, materials=(Material("clay", (0.5, 0.5, 0.5), roughness=0.6),))


def with_meshes(model: Model, *meshes: Mesh) -> Model:
    return replace(model, meshes=meshes)
