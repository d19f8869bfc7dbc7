"""Every row of `material_features.toml`: its example is read, and becomes what the row says, with an origin."""

from __future__ import annotations

import base64
import io
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from assetkit.readers import by_format
from assetkit.readers.gltf.material_layers import LAYERS
from assetkit.readers.material_features import TREATMENTS, Feature, material_features
from assetkit.readers.obj import mtl
from assetkit.readers.robot.materials import stated_material
from assetkit.sources.source_file import SourceFile
from schemas.appearance.material import Material, TextureUse
from schemas.appearance.optics import stated_values
from schemas.model import Model
from schemas.outcome import Outcome
from schemas.robot_description import DescribedMaterial
from tests.support.present import present
from tests.support.usd_files import QUAD, write
from usdio.read.shader_dialects import DIALECTS

FEATURES = material_features()
CORNERS = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
FACE = "f 1/1 2/2 3/3 4/4\n"


def png(color: tuple[int, int, int, int]) -> bytes:
    stream = io.BytesIO()
    Image.new("RGBA", (4, 4), color).save(stream, "PNG")
    return stream.getvalue()


EVEN, NORMALS = png((200, 100, 50, 128)), png((128, 128, 255, 255))


def of_gltf(folder: Path, example: str) -> Path:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
    uvs = np.array([[0, 0], [1, 0], [0, 1]], "<f4")
    data = points.tobytes() + uvs.tobytes()
    payload = base64.b64encode(data).decode()
    material = json.loads(example or "{}")
    names = sorted(material.get("extensions", {}))
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": f"data:application/octet-stream;base64,{payload}", "byteLength": 60}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
        ],
        "images": [{"uri": "even.png"}],
        "textures": [{"source": 0}],
        "materials": [material],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 1}, "material": 0}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
        "extensionsUsed": names,
    }
    path = folder / "part.gltf"
    path.write_text(json.dumps(document if names else {k: v for k, v in document.items() if k != "extensionsUsed"}))
    return path


def of_mtl(folder: Path, example: str) -> Path:
    (folder / "part.mtl").write_text(f"newmtl m\n{example}\n")
    path = folder / "part.obj"
    path.write_text(f"mtllib part.mtl\n{CORNERS}usemtl m\n{FACE}")
    return path


def of_dae(folder: Path, example: str) -> Path:
    source = (
        '<source id="{0}"><float_array id="{0}a" count="{1}">{2}</float_array><technique_common>'
        '<accessor source="#{0}a" count="{3}" stride="{4}">{5}</accessor></technique_common></source>'
    )
    params = ['<param name="X" type="float"/>', '<param name="Y" type="float"/>', '<param name="Z" type="float"/>']
    points = source.format("p", 9, "0 0 0 1 0 0 0 1 0", 3, 3, "".join(params))
    uvs = source.format("t", 6, "0 0 1 0 0 1", 3, 2, "".join(params[:2]))
    path = folder / "part.dae"
    path.write_text(f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="1"/></asset>
<library_images><image id="even"><init_from>even.png</init_from></image></library_images>
<library_effects><effect id="e"><profile_COMMON><technique sid="c"><phong>{example}</phong></technique></profile_COMMON>
</effect></library_effects>
<library_materials><material id="m" name="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>{points}{uvs}
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles material="s" count="1"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="TEXCOORD" source="#t" offset="0" set="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node id="n"><instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="s" target="#m"><bind_vertex_input semantic="uv" input_semantic="TEXCOORD" input_set="0"/>
</instance_material></technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>""")
    return path


def of_ply(folder: Path, example: str) -> Path:
    path = folder / "part.ply"
    comment = f"{example}\n" if example else ""
    path.write_text(
        f"ply\nformat ascii 1.0\n{comment}element vertex 3\n"
        + "".join(f"property float {axis}\n" for axis in "xyzst")
        + "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n"
    )
    return path


def of_usd(folder: Path, example: str, shader: str) -> Path:
    identity = f'uniform token info:id = "{shader}"'
    if shader.startswith("Omni"):
        identity = f"""uniform token info:implementationSource = "sourceAsset"
        uniform asset info:mdl:sourceAsset = @{shader}.mdl@
        uniform token info:mdl:sourceAsset:subIdentifier = "{shader}\""""
    return write(
        folder,
        f"""def Mesh "q" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ {QUAD}
  rel material:binding = </Root/m>
  texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "vertex" )
}}
def Material "m" {{ token outputs:surface.connect = </Root/m/s.outputs:surface>
  def Shader "s" {{ {identity}
    {example}
    token outputs:surface
  }}
  def Shader "t" {{ uniform token info:id = "UsdUVTexture"
    asset inputs:file = @./even.png@
    float2 inputs:st.connect = </Root/m/uv.outputs:result>
    float3 outputs:rgb
  }}
  def Shader "uv" {{ uniform token info:id = "UsdPrimvarReader_float2"
    string inputs:varname = "st"
  }}
}}""",
    )


def of_urdf(folder: Path, example: str) -> Path:
    (folder / "part.obj").write_text(CORNERS + FACE)
    path = folder / "part.urdf"
    material = f'<material name="m">{example}</material>' if example else ""
    mesh = '<geometry><mesh filename="part.obj"/></geometry>'
    path.write_text(f'<robot name="r"><link name="a"><visual>{mesh}{material}</visual></link></robot>')
    return path


def of_mjcf(folder: Path, example: str) -> Path:
    (folder / "part.obj").write_text(CORNERS + FACE)
    path = folder / "part.xml"
    end = "></material>" if not example.startswith(">") else ">"
    path.write_text(f"""<mujoco><asset><texture name="even" type="2d" file="even.png"/>
<texture name="checker" type="2d" builtin="checker" width="8" height="8"/>
<mesh name="part" file="part.obj"/><material name="m" {example}{end}</asset>
<worldbody><body name="b"><geom type="mesh" mesh="part" material="m"/></body></worldbody></mujoco>""")
    return path


FILES: dict[str, Callable[[Path, str], Path]] = {
    "gltf": of_gltf,
    "mtl": of_mtl,
    "dae": of_dae,
    "ply": of_ply,
    "urdf": of_urdf,
    "mjcf": of_mjcf,
}


def outcome_of(folder: Path, feature: Feature, example: str) -> Outcome[Model]:
    folder.mkdir()
    (folder / "even.png").write_bytes(EVEN)
    (folder / "bumps.png").write_bytes(NORMALS)
    if feature.format == "usd":
        path = of_usd(folder, example, feature.name.partition(".")[0])
    else:
        path = FILES[feature.format](folder, example)
    return by_format.READERS[by_format.FORMAT_OF[path.suffix]](SourceFile(path, folder))


def material_of(outcome: Outcome[Model]) -> Material:
    materials = present(outcome.value).materials
    return materials[0] if materials else Material("m")


def keys_of(unmapped: object) -> Iterator[str]:
    if isinstance(unmapped, dict):
        for key, value in unmapped.items():
            yield key
            yield from keys_of(value)


@pytest.mark.parametrize("feature", FEATURES, ids=lambda feature: f"{feature.format}-{feature.name}")
def test_row(feature: Feature, tmp_path: Path) -> None:
    outcome = outcome_of(tmp_path / "with", feature, feature.example)
    material = material_of(outcome)
    codes = {diagnostic.code for diagnostic in outcome.diagnostics}
    if feature.treatment == "recorded":
        assert feature.becomes in keys_of(material.unmapped)
        assert "asset/material-extension-fallback" in codes
        return
    assert not codes - {"asset/material-extension-fallback", "robot/missing-inertial"}
    value = stated_values(material)[feature.becomes]
    plain = stated_values(material_of(outcome_of(tmp_path / "without", feature, "")))
    assert value != plain.get(feature.becomes)
    origin = material.origins[feature.becomes]
    assert origin.source == ("declared" if feature.treatment == "kept" else origin.source)
    assert origin.confidence > 0.0
    if isinstance(value, TextureUse):
        assert value.texture in {texture.name for texture in present(outcome.value).textures}


def named(format_name: str) -> str:
    return "\n".join(f"{feature.name}\n{feature.example}" for feature in FEATURES if feature.format == format_name)


def test_no_property_that_a_reader_names_lacks_a_row() -> None:
    words = re.compile(r"[A-Za-z_]\w*")
    gltf, usd = set(words.findall(named("gltf"))), set(words.findall(named("usd")))
    assert set(LAYERS) <= gltf
    inputs = {name for dialect in DIALECTS for name in (*dialect.inputs.values(), *dialect.maps.values())}
    assert inputs <= usd
    statements = {word.lower() for word in words.findall(named("mtl"))}
    assert statements >= mtl.KEYWORDS
    numbers = {field for field in DescribedMaterial.__dataclass_fields__ if field not in ("name", "source", "unread")}
    assert numbers - {"layers"} <= set(words.findall(named("mjcf")))


def test_layers_of_every_role_have_a_row() -> None:
    roles = set(re.findall(r"layer (\w+)", named("mjcf")))
    for role in ("occlusion", "roughness", "metallic", "normal", "opacity", "emissive", "orm"):
        described = DescribedMaterial("m", layers=((role, "even.png"),))
        assert stated_material(described, TextureUse).unmapped == {}
        assert role in roles


def test_treatments_are_the_three_of_the_page() -> None:
    assert {feature.treatment for feature in FEATURES} == set(TREATMENTS)
