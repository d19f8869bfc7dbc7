"""Light in the base colour is suspected where brightness follows the surface's direction everywhere, and only there."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from PIL import Image

from assetkit.materials.baked_lighting import POLICY, baked_lighting, directions, suspicion
from schemas.appearance.material import Material, Texture, TextureUse
from schemas.model import Mesh, Model
from tests.support import package_samples as samples

SIZE = 128
PATCHES = 27  # a seed whose patches a fit to all places takes for light
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


def painted_box(levels: tuple[int, ...], seed: int = 0) -> Model:
    """A box of 300 triangles a side, each side of its own grey level, with noise; the top is the last."""
    box = trimesh.creation.box((0.1, 0.1, 0.1)).subdivide().subdivide().subdivide()
    side = np.argmax(np.concatenate([-box.face_normals, box.face_normals], axis=1)[:, (0, 1, 3, 4, 2, 5)], axis=1)
    noise = np.random.default_rng(seed).normal(0.0, 3.0, (4, 6, 3))
    grey = (np.array(levels)[None, :, None] + noise).clip(0, 255).astype(np.uint8)
    stream = io.BytesIO()
    Image.fromarray(grey).save(stream, "PNG")
    uvs = np.zeros((len(side), 3, 2), dtype=np.float32)
    uvs[..., 0] = ((side + 0.5) / 6)[:, None]
    uvs[..., 1] = np.random.default_rng(seed).random((len(side), 3))
    mesh = samples.mesh_from(box, uvs=(uvs,), material=0)
    material = Material("m", base_color=(1, 1, 1), base_color_texture=TextureUse("t"))
    return samples.model([mesh], [material], [Texture("t", stream.getvalue(), "png", 6, 4)])


def test_few_faces_tell_nothing() -> None:
    """A box whose top is painted lighter looks as if lit from above; without the bound it would be suspected."""
    box = painted_box((60, 90, 80, 70, 40, 200))
    assert baked_lighting(box) is None
    unbounded = baked_lighting(box, replace(POLICY, least_directions=1.0))
    assert suspicion(unbounded)
    assert baked_lighting(samples.model([samples.box_mesh()])) is None


def test_the_fit_is_judged_in_places_that_it_has_not_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Coarse patches of paint can be fitted by chance; they are not predicted elsewhere."""
    patches = np.kron(np.random.default_rng(PATCHES).uniform(0.2, 0.7, (4, 4)), np.ones((SIZE // 4, SIZE // 4)))
    judged = baked_lighting(ball(patches))

    def fitted(terms: np.ndarray, values: np.ndarray, places: np.ndarray, folds: int) -> np.ndarray:
        return terms @ np.linalg.lstsq(terms, values, rcond=None)[0]

    monkeypatch.setattr("assetkit.materials.baked_lighting._predicted_elsewhere", fitted)
    seen = baked_lighting(ball(patches))
    assert judged is not None
    assert seen is not None
    assert seen.value > POLICY.suspected > judged.value


def test_directions_of_a_box_and_of_a_ball() -> None:
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    assert directions(np.repeat(axes, 50, axis=0)) == pytest.approx(6.0)
    rounded = np.concatenate([np.repeat(axes, 500, axis=0), normals_of_a_ball(60)])
    assert directions(rounded) < POLICY.least_directions  # rounded edges make no ball of a box
    assert directions(normals_of_a_ball(5000)) > 5 * POLICY.least_directions
    assert directions(np.zeros((0, 3))) == 0.0


def normals_of_a_ball(count: int) -> np.ndarray:
    vectors = np.random.default_rng(0).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
