"""Baked maps hold what the source shows: colours at their places to the edge of charts, relief as shading.

Pictures are read by Pillow and compared with closed forms, not by the code that bakes.
"""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import KDTree

from assetkit.retopo import bake as baking
from assetkit.retopo.bake import Baked, bake, varying_fields
from assetkit.retopo.remesh import remeshed
from assetkit.retopo.surface_values import NORMAL_FIELD, surfaces_of
from geom.mesh.surface_distance import sample_surface
from schemas.appearance.material import Material, TextureUse
from schemas.model import Mesh, Model
from tests.assetkit.retopo.things import (
    away_from_lines,
    bumpy_sphere,
    checker_colour,
    checkered_cube,
    model_of,
    picture,
    side_uvs,
)

SIZE_PX = 512


def light_of(model: Model, faces: int) -> tuple[Mesh, ...]:
    light = remeshed(model.meshes, faces, SIZE_PX)
    assert not isinstance(light, str), light
    return light


def levels(baked: Baked, name: str) -> np.ndarray:
    (texture,) = [t for t in baked.textures if t.name == name]
    return np.asarray(Image.open(io.BytesIO(texture.data)).convert("RGB")).astype(np.float64)


def read_off(pixels: np.ndarray, uvs: np.ndarray) -> np.ndarray:
    """(k, 3) bilinear values, rows from the top, as every renderer of USD reads a picture."""
    height, width = pixels.shape[:2]
    x, y = uvs[:, 0] * width - 0.5, (1.0 - uvs[:, 1]) * height - 0.5
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    s, t = (x - column)[:, None], (y - row)[:, None]

    def texel(i: int, j: int) -> np.ndarray:
        return pixels[(row + j).clip(0, height - 1), (column + i).clip(0, width - 1)]

    upper = texel(0, 0) * (1 - s) + texel(1, 0) * s
    return upper * (1 - t) + (texel(0, 1) * (1 - s) + texel(1, 1) * s) * t


def places(mesh: Mesh, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (k, 3) on a mesh and their coordinates (k, 2), from the triangles' own corners."""
    points, faces = sample_surface(mesh.points, mesh.triangles, count, 0)
    a, b, c = (mesh.points[mesh.triangles[faces, k]] for k in range(3))
    basis = np.stack([b - a, c - a], axis=2)
    second = np.einsum("kij,kj->ki", np.linalg.pinv(basis), points - a)
    weights = np.concatenate([1.0 - second.sum(axis=1, keepdims=True), second], axis=1)
    return points, np.einsum("kc,kcx->kx", weights, mesh.uvs[0][faces].astype(np.float64))


def colour_errors(baked: Baked) -> np.ndarray:
    """(k,) differences from the checker at places away from its lines."""
    points, uvs = places(baked.meshes[0], 20_000)
    expected = side_uvs(points)
    far = away_from_lines(expected)
    sampled = read_off(levels(baked, "retopo_base_color"), uvs[far])
    return np.abs(sampled - checker_colour(expected[far])).mean(axis=1)


@pytest.fixture(scope="module")
def cube() -> tuple[Model, tuple[Mesh, ...]]:
    model = checkered_cube()
    return model, light_of(model, 100)


def test_a_checkered_cube_keeps_its_colours(cube: tuple[Model, tuple[Mesh, ...]]) -> None:
    model, light = cube
    errors = colour_errors(bake(model, model.meshes, light, SIZE_PX))
    assert errors.mean() < 0.5
    assert np.percentile(errors, 99.9) < 6.0


def test_a_picture_upside_down_is_noticed(cube: tuple[Model, tuple[Mesh, ...]]) -> None:
    """What the errors above are without care for v: the test would let nothing of the kind pass."""
    model, light = cube
    baked = bake(model, model.meshes, light, SIZE_PX)
    (texture,) = [t for t in baked.textures if t.name == "retopo_base_color"]
    turned = picture("retopo_base_color", np.asarray(Image.open(io.BytesIO(texture.data)))[::-1])
    assert colour_errors(replace(baked, textures=(turned,))).mean() > 20.0


def seam_errors(light: Mesh, pixels: np.ndarray, reduction: int) -> np.ndarray:
    """(k, 3) colours of a reduced picture at places close to the edges of triangles, where seams are."""
    small = pixels.reshape(SIZE_PX // reduction, reduction, SIZE_PX // reduction, reduction, 3).mean(axis=(1, 3))
    corners = light.uvs[0].astype(np.float64)
    steps = np.linspace(0.02, 0.98, 25)
    edges = np.concatenate(
        [corners[:, a, None] * (1 - steps[:, None]) + corners[:, b, None] * steps[:, None] for a, b in ((0, 1), (1, 2))]
    )
    return read_off(small, edges.reshape(-1, 2))


def test_without_dilation_seams_show_the_background(
    cube: tuple[Model, tuple[Mesh, ...]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A cube of one colour on a background of another: with dilation no reduction of the picture mixes them."""
    model, light = cube
    red = np.zeros((8, 8, 3), dtype=np.uint8)
    red[:] = (220, 20, 20)
    painted = replace(model, textures=(picture("checker", red),))
    seams = seam_errors(light[0], levels(bake(painted, model.meshes, light, SIZE_PX), "retopo_base_color"), 4)
    assert np.abs(seams - red[0, 0]).max() < 2.0

    def undilated(values: np.ndarray, shown: np.ndarray, reach_px: int) -> np.ndarray:
        return np.where(shown[..., None], values, 0.0)

    monkeypatch.setattr(baking, "dilated", undilated)
    bare = seam_errors(light[0], levels(bake(painted, model.meshes, light, SIZE_PX), "retopo_base_color"), 4)
    assert np.abs(bare - red[0, 0]).max() > 20.0


def test_bumps_become_normals_of_the_source_in_the_frame_of_the_coordinates() -> None:
    """The map, read by Pillow and turned by a frame from least squares on the coordinates, gives back the bumps."""
    model = bumpy_sphere()
    source = model.meshes[0]
    mesh = (baked := bake(model, model.meshes, light_of(model, 600), SIZE_PX)).meshes[0]
    points, uvs = places(mesh, 2000)
    _, faces = sample_surface(mesh.points, mesh.triangles, 2000, 0)
    smooth = shading_at(mesh, points, faces)
    local = read_off(levels(baked, "retopo_normal"), uvs) / 127.5 - 1.0
    table = np.zeros_like(source.points)
    assert source.normals is not None
    table[source.triangles.reshape(-1)] = source.normals.reshape(-1, 3)
    true = table[KDTree(source.points).query(points)[1]]
    shaded = np.stack([frame_at(mesh, face, N) @ n for face, N, n in zip(faces, smooth, local, strict=True)])
    with_map, without = (degrees_between(sampled, true).mean() for sampled in (shaded, smooth))
    assert with_map < 0.35 * without
    downward = np.stack(
        [frame_at(mesh, face, N) @ (n * (1, -1, 1)) for face, N, n in zip(faces, smooth, local, strict=True)]
    )
    assert degrees_between(downward, true).mean() > 0.8 * without


def shading_at(mesh: Mesh, points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(k, 3) interpolated normals; weights from the least squares of the corners."""
    assert mesh.normals is not None
    sampled = []
    for point, face in zip(points, faces, strict=True):
        system = np.concatenate([mesh.points[mesh.triangles[face]].T, np.ones((1, 3))])
        weights = np.linalg.lstsq(system, np.append(point, 1.0), rcond=None)[0]
        sampled.append(weights @ mesh.normals[face])
    return np.stack(sampled) / np.linalg.norm(sampled, axis=1, keepdims=True)


def frame_at(mesh: Mesh, face: int, N: np.ndarray) -> np.ndarray:
    """(3, 3) columns T, B, N: T along growing u, B on the side of growing v, perpendicular to N and each other."""
    corners, uv = mesh.points[mesh.triangles[face]], mesh.uvs[0][face].astype(np.float64)
    along_u, along_v = np.linalg.solve(uv[1:] - uv[0], corners[1:] - corners[0])
    T = along_u - N * (N @ along_u)
    T /= np.linalg.norm(T)
    B = along_v - N * (N @ along_v) - T * (T @ along_v)
    return np.stack([T, B / np.linalg.norm(B), N], axis=1)


def degrees_between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
    return np.degrees(np.arccos(np.clip(np.einsum("ki,ki->k", first, second) / lengths, -1.0, 1.0)))


def test_only_inputs_that_vary_get_a_map_and_factors_stay(cube: tuple[Model, tuple[Mesh, ...]]) -> None:
    model, light = cube
    grey = picture("rough", np.full((4, 4, 3), (0, 128, 0), dtype=np.uint8))
    paint = Material("paint", (0.5, 0.6, 0.7), TextureUse("checker"), metallic=0.25, roughness=0.8)
    paint = replace(paint, roughness_texture=TextureUse("rough", "g"), normal_scale=3.0, emissive=(0.0, 0.0, 2.0))
    textured = replace(model, materials=(paint,), textures=(*model.textures, grey))
    baked = bake(textured, model.meshes, light, SIZE_PX)
    (made,) = baked.materials
    assert (made.base_color, made.metallic, made.roughness, made.emissive) == ((0.5, 0.6, 0.7), 0.25, 0.8, (0, 0, 2.0))
    assert set(made.texture_uses) == {"base_color_texture", "roughness_texture", "normal_texture"}
    assert (made.roughness_texture and made.roughness_texture.channel, made.normal_scale) == ("g", 1.0)
    assert np.percentile(np.abs(levels(baked, "retopo_orm")[..., 1] - 128), 99) <= 1.0
    assert made.origins["normal_texture"].source == "measured"


def test_each_map_of_a_material_lands_in_its_channel_and_emission_is_linear(
    cube: tuple[Model, tuple[Mesh, ...]],
) -> None:
    """The source packs its values in an order of its own; metalness is scaled, and occlusion inverted, on the way."""
    model, light = cube
    packed = picture("packed", np.full((4, 4, 3), (30, 60, 90), dtype=np.uint8))
    glow = picture("glow", np.full((4, 4, 3), (200, 100, 50), dtype=np.uint8))
    paint = Material(
        "paint",
        emissive=(5.0, 5.0, 5.0),
        emissive_texture=TextureUse("glow"),
        occlusion_texture=TextureUse("packed", "b", scale=-1.0, bias=1.0),
        roughness_texture=TextureUse("packed", "r"),
        metallic_texture=TextureUse("packed", "g", scale=2.0),
    )
    baked = bake(replace(model, materials=(paint,), textures=(packed, glow)), model.meshes, light, SIZE_PX)
    (material,) = baked.materials
    channels = [material.texture_uses[f"{name}_texture"].channel for name in ("occlusion", "roughness", "metallic")]
    assert channels == ["r", "g", "b"]
    assert material.emissive == (5.0, 5.0, 5.0)
    _, uvs = places(baked.meshes[0], 2000)
    orm, emitted = (read_off(levels(baked, name), uvs) for name in ("retopo_orm", "retopo_emissive"))
    np.testing.assert_allclose(orm, np.tile((165.0, 30.0, 120.0), (len(uvs), 1)), atol=1.0)
    np.testing.assert_allclose(emitted, np.tile((200.0, 100.0, 50.0), (len(uvs), 1)), atol=1.0)


def test_meshes_of_one_material_share_their_inputs_and_colours_of_corners_become_a_map() -> None:
    (mesh,) = checkered_cube(4).meshes
    green = np.tile(np.array([0.0, 1.0, 0.0, 1.0], dtype=np.float32), (len(mesh.triangles), 3, 1))
    coloured = replace(mesh, colors=green)
    bare = replace(mesh, material=None)
    pair = model_of(mesh, coloured, bare, replace(coloured, material=None), materials=(Material("m"),))
    fields = varying_fields(surfaces_of(pair, pair.meshes))
    both = frozenset({"base_color_texture", NORMAL_FIELD})
    assert fields == (both, both, frozenset(), both)


def test_a_mesh_whose_colours_are_on_its_corners_gets_a_material() -> None:
    (mesh,) = checkered_cube(8).meshes
    half = np.where(mesh.points[mesh.triangles][..., :1] > 0.0, [1.0, 0, 0, 1], [0, 0, 1.0, 1]).astype(np.float32)
    model = model_of(replace(mesh, colors=half, material=None))
    baked = bake(model, model.meshes, light_of(model, 100), SIZE_PX)
    (index, material) = baked.meshes[0].material, baked.materials[0]
    assert (index, material.base_color) == (0, (1.0, 1.0, 1.0))
    points, uvs = places(baked.meshes[0], 2000)
    sampled = read_off(levels(baked, "retopo_base_color"), uvs)
    far = np.abs(points[:, 0]) > 0.02
    assert ((sampled[far, 0] > 200) == (points[far, 0] > 0.0)).mean() > 0.99
