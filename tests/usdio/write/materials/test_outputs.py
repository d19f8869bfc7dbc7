"""Which shaders are written for a material: one for its optics, and none that would only show less."""

from __future__ import annotations

from typing import Any

from hypothesis import given, settings

from schemas.appearance.material import Material, Sheen, TextureUse
from schemas.appearance.optics import effective, optics_of
from tests.support.appearance.random_materials import IMAGES, materials
from usdio.write.materials.mesh_materials import MeshMaterial
from usdio.write.materials.outputs import OUTPUTS, lost_by_shader, outputs_of

GLASS: dict[str, Any] = {"transmission": 1.0, "roughness": 0.0}


def names(vertex_colors: bool = False, **fields: Any) -> list[str]:
    mesh_material = MeshMaterial("m", Material("m", **fields), vertex_colors)
    return [output.name for output in outputs_of(mesh_material, IMAGES)]


def test_each_optics_has_its_shaders() -> None:
    assert names() == ["UsdPreviewSurface", "OpenPBR", "OmniPBR"]
    assert names(**GLASS) == ["UsdPreviewSurface", "OpenPBR", "OmniGlass"]
    assert names(clearcoat=1.0) == ["UsdPreviewSurface", "OpenPBR", "OmniPBR_ClearCoat"]
    assert names(sheen=Sheen((1.0, 1.0, 1.0)))[1] == "OpenPBR"


def test_a_shader_that_only_shows_less_is_not_written() -> None:
    """OmniPBR reads no vertex colours and no clamped pictures; a renderer would prefer it to UsdPreviewSurface."""
    assert names(vertex_colors=True) == ["UsdPreviewSurface", "OpenPBR"]
    assert names(base_color_texture=TextureUse("packed", wrap_s="clamp")) == ["UsdPreviewSurface", "OpenPBR"]
    assert "OmniGlass" in names(vertex_colors=True, **GLASS)  # less of the colour, but clear


def test_a_map_of_occlusion_keeps_no_shader_away() -> None:
    assert "OpenPBR" in names(occlusion_texture=TextureUse("grey", "r"))


@settings(max_examples=20, deadline=None)
@given(materials())
def test_openpbr_shows_all_that_usdpreviewsurface_shows(material: Material) -> None:
    by_shader = lost_by_shader(MeshMaterial("m", material), IMAGES)
    assert list(by_shader)[:2] == ["UsdPreviewSurface", "OpenPBR"]
    assert by_shader["OpenPBR"] <= by_shader["UsdPreviewSurface"]
    assert set(by_shader) <= {output.name for output in OUTPUTS[optics_of(material)]}
    assert lost_by_shader(MeshMaterial("m", effective(material)), IMAGES) == by_shader
