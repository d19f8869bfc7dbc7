"""Layers beyond metallic-roughness in USD shaders: each input reaches its field, and its origin names it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from schemas.appearance.material import Anisotropy, Iridescence, Sheen, Specular
from schemas.evidence import BY_STANDARD
from tests.usdio.read.test_materials import BOUND, material_of, read, write

STANDARD = "ND_standard_surface_surfaceshader"
OPEN_PBR = "ND_open_pbr_surface_surfaceshader"
GLTF = "ND_gltf_pbr_surfaceshader"
# Shader, inputs, field, value, the origin's text.
ROWS: list[tuple[str, str, str, Any, str]] = [
    (STANDARD, "float inputs:transmission = 0.8", "transmission", 0.8, "standard_surface: transmission"),
    (
        STANDARD,
        "float inputs:transmission_dispersion = 50",
        "dispersion",
        0.4,
        "standard_surface: transmission_dispersion",
    ),
    (STANDARD, "float inputs:coat = 0.5", "clearcoat", 0.5, "standard_surface: coat"),
    (
        STANDARD,
        "float inputs:sheen = 0.5\n color3f inputs:sheen_color = (1, 0.5, 0)",
        "sheen",
        Sheen((0.5, 0.25, 0.0), None, 0.3),
        "standard_surface: sheen_color, sheen",
    ),
    (
        STANDARD,
        "float inputs:specular_anisotropy = 0.6\n float inputs:specular_rotation = 0.25",
        "anisotropy",
        Anisotropy(0.6, math.pi / 2),
        "standard_surface: specular_anisotropy",
    ),
    (
        OPEN_PBR,
        "float inputs:specular_weight = 0.4\n color3f inputs:specular_color = (1, 0.5, 0.25)",
        "specular",
        Specular(0.4, None, (1.0, 0.5, 0.25)),
        "open_pbr_surface: specular_weight",
    ),
    (
        OPEN_PBR,
        "float inputs:fuzz_weight = 1\n color3f inputs:fuzz_color = (0.2, 0.4, 0.6)\nfloat inputs:fuzz_roughness = 0.7",
        "sheen",
        Sheen((0.2, 0.4, 0.6), None, 0.7),
        "open_pbr_surface: fuzz_color, fuzz_weight",
    ),
    (
        OPEN_PBR,
        "float inputs:thin_film_weight = 0.9\n float inputs:thin_film_thickness = 0.3\n"
        "float inputs:thin_film_ior = 1.6",
        "iridescence",
        Iridescence(0.9, None, 1.6, (300.0, 300.0)),
        "open_pbr_surface: thin_film_weight",
    ),
    (OPEN_PBR, "float inputs:transmission_weight = 1", "transmission", 1.0, "open_pbr_surface: transmission_weight"),
    (
        GLTF,
        "color3f inputs:emissive = (1, 0.5, 0)\n float inputs:emissive_strength = 4",
        "emissive",
        (4.0, 2.0, 0.0),
        "gltf_pbr: emissive, emissive_strength",
    ),
    (GLTF, "float inputs:dispersion = 0.2", "dispersion", 0.2, "gltf_pbr: dispersion"),
    (
        GLTF,
        "color3f inputs:sheen_color = (0.1, 0.2, 0.3)\n float inputs:sheen_roughness = 0.4",
        "sheen",
        Sheen((0.1, 0.2, 0.3), None, 0.4),
        "gltf_pbr: sheen_color",
    ),
]


def shader(identifier: str, inputs: str) -> str:
    return f"""def Material "m" {{ token outputs:mtlx:surface.connect = </Root/m/s.outputs:out>
      def Shader "s" {{ uniform token info:id = "{identifier}"
        {inputs}
        token outputs:out
      }}
    }}"""


@pytest.mark.parametrize(("identifier", "inputs", "field", "value", "method"), ROWS)
def test_each_input_reaches_its_field_with_its_origin(
    identifier: str, inputs: str, field: str, value: Any, method: str, tmp_path: Path
) -> None:
    got = material_of(write(tmp_path, BOUND + shader(identifier, inputs)))
    read = getattr(got, field)
    if isinstance(value, float):
        assert math.isclose(read, value, rel_tol=1e-6)
    else:
        assert read == value
    origins = [origin for name, origin in got.origins.items() if name.partition(".")[0] == field]
    assert (origins[0].source, origins[0].method, origins[0].confidence) == ("declared", method, 1.0)
    assert got.unmapped.keys() <= {"shader", "network"}


@pytest.mark.parametrize("identifier", [STANDARD, OPEN_PBR, GLTF])
def test_layers_that_nobody_states_are_none_and_defaults_are_half_sure(identifier: str, tmp_path: Path) -> None:
    got = material_of(write(tmp_path, BOUND + shader(identifier, "")))
    assert got.sheen is got.specular is got.anisotropy is got.iridescence is None
    assert (got.transmission, got.clearcoat, got.dispersion) == (0.0, 0.0, 0.0)
    assert {origin.confidence for origin in got.origins.values()} == {BY_STANDARD}
    assert "base_color" in got.origins


def mdl(name: str, inputs: str) -> str:
    return f"""def Material "m" {{ token outputs:mdl:surface.connect = </Root/m/s.outputs:out>
      def Shader "s" {{ uniform token info:implementationSource = "sourceAsset"
        uniform asset info:mdl:sourceAsset = @{name}.mdl@
        uniform token info:mdl:sourceAsset:subIdentifier = "{name}"
        {inputs}
        token outputs:out
      }}
    }}"""


def test_omni_glass_lets_light_through(tmp_path: Path) -> None:
    inputs = """color3f inputs:glass_color = (0.9, 1, 0.9)
      float inputs:glass_ior = 1.45\n float inputs:frosting_roughness = 0.2"""
    got = material_of(write(tmp_path, BOUND + mdl("OmniGlass", inputs)))
    assert (got.base_color, got.roughness, got.transmission) == ((0.9, 1.0, 0.9), 0.2, 1.0)
    assert math.isclose(got.ior, 1.45, rel_tol=1e-6)
    assert got.metallic == 0.0


@pytest.mark.parametrize(("switch", "coat"), [("1", 0.6), ("0", 0.0)])
def test_the_coat_of_omni_pbr_has_a_switch(switch: str, coat: float, tmp_path: Path) -> None:
    inputs = f"bool inputs:enable_clearcoat = {switch}\n float inputs:clearcoat_weight = 0.6"
    got = material_of(write(tmp_path, BOUND + mdl("OmniPBR_ClearCoat", inputs)))
    assert math.isclose(got.clearcoat, coat, rel_tol=1e-6)


def test_pictures_that_only_another_surface_shows_are_not_missed(tmp_path: Path) -> None:
    """Of the surfaces beside UsdPreviewSurface, layers count; an absent picture of a base colour is not their loss."""
    body = (
        BOUND
        + """def Material "m" {
      token outputs:surface.connect = </Root/m/p.outputs:surface>
      token outputs:mtlx:surface.connect = </Root/m/s.outputs:surface>
      def Shader "p" { uniform token info:id = "UsdPreviewSurface"
        token outputs:surface
      }
      def Shader "s" { uniform token info:id = "ND_standard_surface_surfaceshader"
        color3f inputs:base_color.connect = </Root/m/t.outputs:out>
        float inputs:sheen = 0.5
        token outputs:surface
      }
      def Shader "t" { uniform token info:id = "ND_image_color3"
        asset inputs:file = @./absent.png@
        color3f outputs:out
      }
    }"""
    )
    outcome = read(write(tmp_path, body))
    assert outcome.value is not None
    (got,) = outcome.value.materials
    assert got.sheen is not None
    assert got.base_color_texture is None
    assert "asset/missing-texture" not in {diagnostic.code for diagnostic in outcome.diagnostics}
