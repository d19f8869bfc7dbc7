"""What parts are made of: names, usual materials and looks, each alone and against each other."""

from __future__ import annotations

import io
from collections.abc import Sequence

import hypothesis.strategies as st
import numpy as np
import pytest
import trimesh
from hypothesis import given
from PIL import Image

from assetkit.materials.part_materials import face_materials, material_of, part_materials
from assetkit.materials.surface_appearance import AppearanceSampler, SurfaceAppearance, tones_of
from assetkit.parts.find import find_parts
from assetkit.taxonomy.category_materials import appearance_table, category_materials, class_names, material_prior
from assetkit.taxonomy.material_classes import UNKNOWN, materials
from assetkit.taxonomy.tables import categories
from schemas.appearance.material import Material, Texture, TextureUse
from schemas.evidence import declared, default
from schemas.model import Mesh, Model

NOTHING = default(UNKNOWN)
OAK = (0.30, 0.16, 0.06)  # linear


def model_of(meshes: Sequence[Mesh], looks: Sequence[Material] = (), textures: Sequence[Texture] = ()) -> Model:
    return Model(tuple(meshes), tuple(looks), tuple(textures), (), default(1.0), default("z"))


def box(name: str, material: int | None = None, at: float = 0.0, uvs: bool = False) -> Mesh:
    """A cube of 2 cm at height `at`; with uvs its lower half shows the left half of the image."""
    shape = trimesh.creation.box((0.02, 0.02, 0.02)).apply_translation((0.0, 0.0, at))
    points, triangles = np.array(shape.vertices), np.array(shape.faces, dtype=np.int32)
    heights = (points[triangles][:, :, 2] - at) / 0.021 + 0.5  # Off the edges, where the image begins again.
    listed = (np.stack([heights, np.full_like(heights, 0.5)], axis=2).astype(np.float32),) if uvs else ()
    return Mesh(name, points, triangles, uvs=listed, material=material, source_path=f"/{name}")


def test_tables_speak_of_what_there_is() -> None:
    """Classes are those of the material table, categories those of the vocabulary; shares sum to one."""
    known = set(materials()) - {UNKNOWN, "unknown_full", "metal"}
    assert set(class_names()) == known
    assert {row.category for row in category_materials()} <= {*categories(), "any"}
    assert all(set(row.materials) <= known for row in category_materials())
    assert set(categories()) <= {row.category for row in category_materials() if not row.parts}
    for row in category_materials():
        told = categories().get(row.category)
        assert told is None or set(row.parts) <= set(told.parts), row
    for row in appearance_table().values():
        for columns in (("dark", "grey", "white", "earthy", "muted", "vivid"), ("smooth", "satin", "rough")):
            assert sum(row[c] for c in columns) == pytest.approx(1.0)


def test_nothing_is_said_of_nothing() -> None:
    """Without names, category or looks the material is unknown."""
    assert material_of(SurfaceAppearance(), NOTHING).value == UNKNOWN


def test_what_things_are_usually_made_of_counts() -> None:
    """A mug is of ceramic while nothing else is known, and less surely when the category is less sure."""
    sure = material_of(SurfaceAppearance(), declared("mug", "user"))
    doubted = material_of(SurfaceAppearance(), declared("mug", "user", confidence=0.75))
    assert sure.value == "ceramic"
    assert 0.5 < doubted.confidence < sure.confidence < 0.95
    assert sure.method == "usual for mug"
    assert material_of(SurfaceAppearance(), declared("pan", "user"), label="handle").value == "plastic"


def test_a_name_weighs_more_than_what_is_usual() -> None:
    """The name of the render material counts first, then that of the file; the method names it."""
    evidence = material_of(
        SurfaceAppearance(), declared("mug", "user"), own_names=["Steel_brushed"], of_whole=["mug.obj"]
    )
    assert evidence.value == "steel"
    assert evidence.method.startswith("name says steel")
    assert material_of(SurfaceAppearance(), NOTHING, of_whole=["granite_slab.obj"]).value == "stone"
    assert material_of(SurfaceAppearance(), declared("bowl", "user"), of_whole=["wooden_bowl.obj"]).value == "wood"


def test_what_is_in_a_can_is_not_what_it_is_made_of() -> None:
    """A can of meat is of steel, an apple of food."""
    assert material_of(SurfaceAppearance(), declared("can", "user"), of_whole=["potted_meat_can.obj"]).value == "steel"
    assert material_of(SurfaceAppearance(), declared("fruit", "user"), of_whole=["apple.obj"]).value == "food"


def test_several_metals_together_are_metal() -> None:
    """Metal is sure where no single metal is."""
    assert material_of(SurfaceAppearance(), declared("pan", "user"), own_names=["metal"]).value == "metal"
    assert material_of(SurfaceAppearance(), declared("knife", "user"), own_names=["metal"]).value == "steel"
    assert material_of(SurfaceAppearance(), NOTHING, own_names=["copper pipe"]).value == "copper"


def test_words_of_parts_count_by_their_head() -> None:
    """Tyres are of rubber; motor mounts are mounts."""
    assert material_of(SurfaceAppearance(), NOTHING, own_names=["tyre_front"]).value == "rubber"
    assert material_prior("", "", ("motor", "mounts"))[1] == "a mount"


def test_metallic_maps_and_glass_are_seen() -> None:
    """Maps that say metal make a metal, light that gets through makes glass of a window pane."""
    metallic = np.array([0.0, 0.0, 1.0])
    grey = np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    assert material_of(SurfaceAppearance(grey, True, None, metallic), NOTHING).value in ("steel", "metal")
    assert (
        material_of(SurfaceAppearance(see_through=1.0), declared("bottle", "user"), own_names=["glass"]).value
        == "glass"
    )


@given(st.permutations(["dark", "earthy"]), st.floats(0.0, 1.0))
def test_shares_are_shares(order: list[str], share: float) -> None:
    """Mixed colours are between those they are mixed of, in any order."""
    dark, brown = np.zeros((100, 3)), np.tile(OAK, (100, 1))
    kept = int(100 * share)
    mixed = [dark[:kept], brown[kept:]] if order[0] == "dark" else [brown[kept:], dark[:kept]]
    tones = tones_of(np.concatenate(mixed))
    assert tones.sum() == pytest.approx(1.0)
    assert tones[0] == pytest.approx(kept / 100)
    assert tones[3] == pytest.approx(1.0 - kept / 100)


def test_each_part_looks_where_its_own_texels_are() -> None:
    """Two cubes share one image, brown on its left and black on its right: each is seen as it is."""
    pixels = np.zeros((8, 8, 3), dtype=np.uint8)
    pixels[:, :4] = (148, 111, 70)
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    image = Texture("both", stream.getvalue(), "png", 8, 8)
    look = Material("m", (1.0, 1.0, 1.0), base_color_texture=TextureUse("both"))
    mesh = box("cube", 0, uvs=True)
    looks = AppearanceSampler(model_of([mesh], [look], [image]))
    heights = mesh.points[mesh.triangles][:, :, 2].max(axis=1)
    flat = np.ptp(mesh.points[mesh.triangles][:, :, 2], axis=1) < 1e-9
    lower = looks.of([(mesh, np.flatnonzero(flat & (heights < 0.0)))])
    assert lower.painted
    assert lower.tones is not None
    assert lower.tones[3] == pytest.approx(1.0)
    whole = looks.of([(mesh, np.arange(12))])
    assert whole.tones is not None
    assert whole.tones[3] == pytest.approx(0.5, abs=0.1)


def test_grey_that_tools_give_says_nothing() -> None:
    """A light grey for all is what nobody painted; metallic 1 with roughness 1 is what glTF has for silence."""
    silent = Material("default", (0.8, 0.8, 0.8), metallic=1.0, roughness=1.0)
    mesh = box("cube", 0)
    look = AppearanceSampler(model_of([mesh], [silent])).of([(mesh, np.arange(12))])
    assert look == SurfaceAppearance()


def test_parts_have_their_own_material_and_share_it_by_face() -> None:
    """A wooden knob on a steel box: each part its own, and each triangle that of the smallest part that holds it."""
    meshes = {"body": box("body", 0), "knob": box("knob", 1, at=0.03)}
    model = model_of(list(meshes.values()), [Material("steel"), Material("oak")])
    found = find_parts(meshes, model.materials, NOTHING).parts
    parts, whole = part_materials(meshes, model, found, NOTHING, "thing.obj")
    assert sorted(p.value.material.value for p in parts) == ["steel", "wood"]
    assert whole.value == UNKNOWN
    evidence, of_face = face_materials(meshes, parts, whole)
    assert {evidence[int(k)].value for k in of_face[0]} == {"steel"}
    assert {evidence[int(k)].value for k in of_face[1]} == {"wood"}
