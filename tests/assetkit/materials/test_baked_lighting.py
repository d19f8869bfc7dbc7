"""Light in the base colour is suspected where brightness follows the surface's direction everywhere, and only there."""

from __future__ import annotations

import io

import numpy as np
import pytest
import trimesh
from PIL import Image

from assetkit.materials.baked_lighting import POLICY, baked_lighting, directions, suspicion
from schemas.appearance.material import Material, Texture, TextureUse
from schemas.model import Mesh, Model
from tests.support import package_samples as samples

SIZE = 128
WARM = np.array([0.9, 0.7, 0.5])


def ball(brightness: np.ndarray) -> Model:
    """A ball of 10 cm; its picture is WARM times the brightness (SIZE, SIZE), a row per latitude, the top first."""
    sphere = trimesh.creation.uv_sphere(count=[32, 32])
    points, faces = np.array(sphere.vertices), np.array(sphere.faces, dtype=np.int32)
    u = (np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi)) % 1.0
    v = 1.0 - np.arccos(points[:, 2].clip(-1, 1)) / np.pi
    uvs = np.stack([u, v], axis=1)[faces].astype(np.float32)
    seam = np.ptp(uvs[..., 0], axis=1) > 0.5
    uvs[seam, :, 0] += uvs[seam, :, 0] < 0.5
    light = np.clip(brightness[..., None] * WARM, 0, 1)
    shown = np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
    stream = io.BytesIO()
    Image.fromarray(np.round(shown * 255).astype(np.uint8)).save(stream, "PNG")
    picture = Texture("t", stream.getvalue(), "png", SIZE, SIZE)
    mesh = Mesh("ball", points * 0.05, faces, uvs=(uvs,), material=0)
    return samples.model([mesh], [Material("m", base_color=(1, 1, 1), base_color_texture=TextureUse("t"))], [picture])


def light_from(direction: tuple[float, float, float]) -> np.ndarray:
    """Ambient and one lamp, on the texels of a ball."""
    polar = (np.arange(SIZE) + 0.5) / SIZE * np.pi
    round_ = (np.arange(SIZE) + 0.5) / SIZE * 2 * np.pi
    p, r = np.meshgrid(polar, round_, indexing="ij")
    normals = np.stack([np.sin(p) * np.cos(r), np.sin(p) * np.sin(r), np.cos(p)], axis=-1)
    lamp = np.array(direction) / np.linalg.norm(direction)
    return 0.35 + 0.65 * np.clip(normals @ lamp, 0, None)


def speckled(seed: int, spread: float) -> np.ndarray:
    return 0.5 * np.exp(spread * np.random.default_rng(seed).standard_normal((SIZE, SIZE)))


@pytest.mark.parametrize("direction", [(0.3, 0.2, 0.93), (1.0, 0.0, 0.2), (-0.4, -0.7, 0.6)])
def test_light_from_any_side_is_suspected(direction: tuple[float, float, float]) -> None:
    seen = baked_lighting(ball(speckled(1, 0.05) * light_from(direction)))
    assert seen is not None
    assert (seen.value > 0.5, seen.confidence > 0.75) == (True, True)
    assert [note.code for note in suspicion(seen)] == ["asset/baked-lighting-suspected"]


@pytest.mark.parametrize("seed", range(4))
def test_paint_is_not_taken_for_light(seed: int) -> None:
    rng = np.random.default_rng(seed)
    patches = np.kron(rng.uniform(0.2, 0.7, (16, 16)), np.ones((SIZE // 16, SIZE // 16)))
    bands = np.repeat(rng.uniform(0.2, 0.7, 16), SIZE // 16)[:, None] * np.ones((1, SIZE))
    for paint in (speckled(seed, 0.3), patches, bands):
        seen = baked_lighting(ball(paint))
        assert seen is not None
        assert suspicion(seen) == (), seen


def test_few_faces_tell_nothing() -> None:
    """A box whose top is painted lighter looks as if lit from above."""
    box = samples.box_mesh(uvs=(np.zeros((12, 3, 2), dtype=np.float32),), material=0)
    model = ball(np.full((SIZE, SIZE), 0.5))
    assert (
        baked_lighting(Model((box,), model.materials, model.textures, (), model.meters_per_unit, model.up_axis)) is None
    )
    assert baked_lighting(samples.model([samples.box_mesh()])) is None


def test_directions_of_a_box_and_of_a_ball() -> None:
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    assert directions(np.repeat(axes, 50, axis=0)) == 6
    ball_ = np.random.default_rng(0).normal(size=(5000, 3))
    assert directions(ball_ / np.linalg.norm(ball_, axis=1, keepdims=True)) == 54
    assert POLICY.least_directions > 6
