"""Which materials are degraded: those without a stated colour, with a lost picture, or with a tool's grey."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assetkit.materials.recovery.degraded import RECOVERABLE, degradation, degraded_materials, is_tool_name, open_fields
from schemas.appearance.material import Material, Origin, TextureUse
from schemas.appearance.record import DegradedReason
from schemas.evidence import BY_STANDARD
from tests.assetkit.materials.recovery.samples import box, model_of

STATED = Origin("declared", "Kd")
GREY, RED = (0.8, 0.8, 0.8), (0.6, 0.05, 0.05)


def painted(name: str, color: tuple[float, float, float], **fields: object) -> Material:
    return replace(Material(name, base_color=color, origins={"base_color": STATED}), **fields)


@pytest.mark.parametrize(
    ("material", "reason"),
    [
        (Material("Steel"), DegradedReason.UNSTATED_COLOUR),
        (
            replace(Material("x"), origins={"base_color": Origin("declared", "left out", BY_STANDARD)}),
            DegradedReason.UNSTATED_COLOUR,
        ),
        (painted("Material.001", GREY), DegradedReason.DEFAULT_GREY),
        (painted("lambert1", (0.5, 0.5, 0.5)), DegradedReason.DEFAULT_GREY),
        (painted("label", RED, lost_textures=("base_color_texture",)), DegradedReason.LOST_TEXTURE),
        (painted("label", GREY, base_color_texture=TextureUse("gone")), DegradedReason.LOST_TEXTURE),
        (painted("label", GREY, base_color_texture=TextureUse("here")), None),
        (painted("Material.001", RED), None),
        (painted("Material.001", (0.02, 0.02, 0.02)), None),
        (painted("White_plastik", GREY), None),
        (painted("steel", GREY), None),
        (painted("grey", GREY), None),
    ],
)
def test_reasons(material: Material, reason: DegradedReason | None) -> None:
    """A uniform colour is trusted under an author's name, and any tone or dark under a tool's name."""
    assert degradation(material, {"here"}) == reason


def test_a_tone_beside_a_lost_picture_stays_and_white_does_not() -> None:
    for color, expected in ((RED, False), ((1.0, 1.0, 1.0), True)):
        lost = painted("label", color, lost_textures=("base_color_texture",))
        assert ("base_color" in open_fields(lost, DegradedReason.LOST_TEXTURE)) is expected


def test_what_a_map_states_is_not_open() -> None:
    mapped = replace(Material("x"), roughness_texture=TextureUse("r"), metallic_texture=TextureUse("m"))
    assert not {"roughness", "metallic"} & set(open_fields(mapped, DegradedReason.UNSTATED_COLOUR))


def test_a_stated_metal_is_no_tools_default() -> None:
    origins = {"base_color": STATED, "metallic": STATED, "roughness": STATED}
    for metallic, opened in ((0.0, True), (0.4, False)):
        material = replace(painted("Material", GREY, metallic=metallic), origins=origins)
        assert ("metallic" in open_fields(material, DegradedReason.DEFAULT_GREY)) is opened


def test_meshes_without_material_are_degraded_unless_their_vertices_have_colours() -> None:
    plain = box("plain")
    colors = np.ones((len(plain.triangles), 3, 4), dtype=np.float32)
    varied = colors.copy()
    varied[0, 0, 0] = 0.0
    degraded = degraded_materials(model_of([plain, replace(box("white"), colors=colors)]))
    assert [(d.index, d.reason, d.fields) for d in degraded] == [(None, DegradedReason.NO_MATERIAL, RECOVERABLE)]
    assert degraded_materials(model_of([replace(plain, colors=varied)])) == ()


@pytest.mark.parametrize(
    "name", ["Material.001", "DefaultMaterial", "lambert1", "blinn3-fx", "None", "", "initialShadingGroup"]
)
def test_names_that_tools_give(name: str) -> None:
    assert is_tool_name(name)


@pytest.mark.parametrize("name", ["Steel", "red", "faucet_metal", "chair", "White.001"])
def test_names_that_authors_give(name: str) -> None:
    assert not is_tool_name(name)
