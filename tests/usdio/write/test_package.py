"""Written packages: external validators pass them, nothing is lost, the same content gives the same bytes."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from pxr import Usd, UsdGeom, UsdShade

from gate.external_validators import external_verdicts, simready, simready_optional
from gate.static_gate import gate
from schemas.appearance.material import Material, TextureUse
from schemas.package import PackageContent
from tests.support import package_samples as samples
from usdio.write.package import write_package

VARIANTS = samples.variants()


def write(content: PackageContent, folder: Path) -> Path:
    return write_package(content, folder / content.asset_id)


def hashes(folder: Path) -> dict[str, str]:
    files = sorted(p for p in folder.rglob("*") if p.is_file())
    return {p.relative_to(folder).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def input_of(stage: Usd.Stage, path: str, name: str) -> UsdShade.Input:
    return UsdShade.Shader(stage.GetPrimAtPath(path)).GetInput(name)


@pytest.mark.parametrize("name", VARIANTS)
def test_outside_judges_pass(name: str, tmp_path: Path) -> None:
    main_file = write(VARIANTS[name], tmp_path)
    for verdict in external_verdicts(main_file):
        assert verdict.passed, verdict.findings
    assert not [d for d in gate(main_file) if d.severity == "error"]


def test_the_judge_is_awake_and_silent(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    main_file = write(VARIANTS["plain"], tmp_path / "a folder (1) with ümlaut")
    assert simready(main_file).passed
    (main_file.parent / ".thumbs" / "256x256" / "sample-1.usda.png").unlink()
    assert [remark.rule for remark in simready(main_file).findings] == ["com.nvidia.simready.SR.002"]
    assert capfd.readouterr() == ("", "")


def test_grasps_are_written_as_simready_reads_them(tmp_path: Path) -> None:
    lines = (((-0.02, 0.0, 0.05), (0.02, 0.0, 0.05)), ((0.0, -0.03, 0.02), (0.0, 0.03, 0.02)))
    main_file = write(replace(VARIANTS["plain"], grasp_lines_m=lines), tmp_path)
    stage = Usd.Stage.Open(str(main_file))
    root = stage.GetDefaultPrim()
    for selected, schema in (("points", "Scope"), ("curves", "BasisCurves")):
        assert root.GetVariantSet("grasp_lines").GetVariantSelection() == selected
        for number, ends in enumerate(lines, start=1):
            path = root.GetPath().AppendChild(f"grasp_identifier_{number:02d}")
            assert stage.GetPrimAtPath(path).IsA(UsdGeom.Xform)
            line = stage.GetPrimAtPath(path.AppendChild(f"{path.name}_line"))
            assert line.GetTypeName() == schema
            assert np.allclose(line.GetAttribute("points").Get(), ends)
        for verdict in external_verdicts(main_file):
            assert verdict.passed, verdict.findings
        assert not [d for d in gate(main_file) if d.severity == "error"]
        remarks = {remark.rule for remark in simready_optional(main_file)}
        assert ("com.nvidia.simready.GSP.001" in remarks) is (selected == "points")
        root.GetVariantSet("grasp_lines").SetVariantSelection("curves")
        stage.Save()


def test_same_content_same_bytes_in_any_process(tmp_path: Path) -> None:
    content = samples.full_content()
    write(content, tmp_path / "here")
    code = (
        "import sys; from pathlib import Path; from tests.support import package_samples as s; "
        "from usdio.write.package import write_package; write_package(s.full_content(), Path(sys.argv[1]) / 'sample-1')"
    )
    for seed in ("1", "2"):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(Path(__file__).parents[3])}
        subprocess.run([sys.executable, "-c", code, str(tmp_path / seed)], check=True, env=environment)
        assert hashes(tmp_path / seed) == hashes(tmp_path / "here")
    assert len(hashes(tmp_path / "here")) == 8


def test_nothing_names_this_machine_or_this_day(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    main_file = write(samples.full_content(), tmp_path)
    assert 'usd_date_generated = "1970-01-02"' in main_file.read_text()
    for file in main_file.parent.rglob("*"):
        assert file.is_dir() or str(tmp_path).encode() not in file.read_bytes()


def test_unknown_stays_unknown(tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(write(VARIANTS["plain"], tmp_path)))
    metadata = stage.GetRootLayer().customLayerData
    for key in ("asset_license", "author", "category"):
        assert metadata["SimReady_Metadata"][key] == "unknown"


def test_meshes_round_trip(tmp_path: Path) -> None:
    content = samples.full_content()
    stage = Usd.Stage.Open(str(write(content, tmp_path)))
    source = content.model.meshes[0]
    prim = stage.GetPrimAtPath("/sample_1/Visuals/body")
    mesh = UsdGeom.Mesh(prim)
    assert np.array_equal(np.array(mesh.GetPointsAttr().Get()), source.points.astype(np.float32))
    assert np.array_equal(np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3), source.triangles)
    for uv_set, name in enumerate(("st", "st1")):
        values = np.array(UsdGeom.PrimvarsAPI(prim).GetPrimvar(name).Get()).reshape(-1, 3, 2)
        assert np.array_equal(values, source.uvs[uv_set])
    assert prim.GetCustomDataByKey("mana:sourcePath") == "/scene/body/mesh_0"
    assert prim.GetCustomDataByKey("mana:sourceName") == "body"
    assert mesh.GetDoubleSidedAttr().Get()
    assert mesh.GetSubdivisionSchemeAttr().Get() == "none"


def test_materials_round_trip(tmp_path: Path) -> None:
    content = samples.full_content()
    main_file = write(content, tmp_path)
    stage = Usd.Stage.Open(str(main_file))
    source = content.model.materials[0]
    root = "/sample_1/Materials/Alles_dran"
    values = {"ior": 1.45, "clearcoat": 0.2, "clearcoatRoughness": 0.1, "opacityThreshold": 0.25, "opacity": 0.9}
    for name, value in values.items():
        assert input_of(stage, f"{root}/surface", name).Get() == pytest.approx(value)
    assert tuple(input_of(stage, f"{root}/surface", "diffuseColor").Get()) == pytest.approx(source.base_color)

    def reader(name: str) -> tuple[UsdShade.Shader, str]:
        connected = input_of(stage, f"{root}/surface", name).GetConnectedSources()[0][0]
        return UsdShade.Shader(connected.source.GetPrim()), connected.sourceName

    def texture_value(name: str, value: str) -> tuple[float, ...] | str:
        return reader(name)[0].GetInput(value).Get()

    assert tuple(texture_value("diffuseColor", "scale")) == pytest.approx((0.5, 0.6, 0.7, 1.0))
    assert tuple(texture_value("occlusion", "scale")) == pytest.approx((0.8,) * 4)
    assert tuple(texture_value("occlusion", "bias")) == pytest.approx((0.2,) * 4)
    assert tuple(texture_value("normal", "scale")) == (2.0, 2.0, 2.0, 1.0)
    assert tuple(texture_value("normal", "bias")) == (-1.0, -1.0, -1.0, 0.0)
    assert (texture_value("emissiveColor", "wrapS"), texture_value("emissiveColor", "wrapT")) == ("clamp", "mirror")
    channels = {"metallic": "b", "roughness": "g", "occlusion": "r", "opacity": "a", "diffuseColor": "rgb"}
    assert {name: reader(name)[1] for name in channels} == channels
    assert reader("metallic")[0].GetPath() == reader("roughness")[0].GetPath()
    spaces = {"diffuseColor": "sRGB", "emissiveColor": "sRGB", "opacity": "raw", "normal": "raw", "metallic": "raw"}
    assert {name: texture_value(name, "sourceColorSpace") for name in spaces} == spaces

    placement = reader("diffuseColor")[0].GetInput("st").GetConnectedSources()[0][0].source
    assert tuple(placement.GetInput("scale").Get()) == (2.0, 3.0)
    assert placement.GetInput("rotation").Get() == pytest.approx(np.degrees(0.3))
    assert tuple(placement.GetInput("translation").Get()) == pytest.approx((0.1, 0.2))
    second = reader("normal")[0].GetInput("st").GetConnectedSources()[0][0].source
    assert second.GetInput("varname").Get() == "st1"

    data = {p.name: p.read_bytes() for p in (main_file.parent / "textures").iterdir()}
    assert data == {"picture.png": samples.PICTURE.data, "Foto_1.jpg": samples.PHOTO.data}


def test_vertex_colours_show_where_no_texture_stands_against_them(tmp_path: Path) -> None:
    plain = Usd.Stage.Open(str(write(VARIANTS["vertex colours"], tmp_path / "1")))
    surface = "/sample_1/Materials/neutral_vertex_colors/surface"
    connected = input_of(plain, surface, "diffuseColor").GetConnectedSources()[0][0].source
    assert connected.GetInput("varname").Get() == "displayColor"
    shown = np.array(UsdGeom.Mesh(plain.GetPrimAtPath("/sample_1/Visuals/body")).GetDisplayColorAttr().Get())
    mesh = VARIANTS["vertex colours"].model.meshes[0]
    assert mesh.colors is not None
    np.testing.assert_array_equal(shown, mesh.colors.reshape(-1, 4)[:, :3])
    textured = Usd.Stage.Open(str(write(VARIANTS["vertex colours and texture"], tmp_path / "2")))
    connected = input_of(textured, "/sample_1/Materials/t/surface", "diffuseColor").GetConnectedSources()[0][0].source
    assert UsdShade.Shader(connected.GetPrim()).GetIdAttr().Get() == "UsdUVTexture"


def test_equal_meshes_are_written_once_and_layers_stay(tmp_path: Path) -> None:
    once = Usd.Stage.Open(str(write(VARIANTS["the same mesh twice"], tmp_path / "1")))
    layered = Usd.Stage.Open(str(write(VARIANTS["the same shape in two materials"], tmp_path / "2")))
    assert [len(s.GetPrimAtPath("/sample_1/Visuals").GetChildren()) for s in (once, layered)] == [1, 2]


def test_only_used_textures_are_packed(tmp_path: Path) -> None:
    mesh = replace(samples.box_mesh(), material=0)
    opaque = Material("m", opacity_texture=TextureUse("picture", "a"))
    main_file = write(samples.content(samples.model([mesh], [opaque], [samples.PICTURE])), tmp_path)
    assert not (main_file.parent / "textures").exists()


def test_fifty_thousand_triangles_take_little_time(tmp_path: Path) -> None:
    ball = samples.mesh_from(trimesh.creation.icosphere(6, 0.05))
    ball = replace(ball, points=ball.points + np.array([0.0, 0.0, 0.05]))
    ball = replace(ball, uvs=(samples.uvs(ball),), colors=samples.colors(ball))
    content = samples.content(samples.model([ball]))
    start = time.perf_counter()
    write(content, tmp_path)
    assert time.perf_counter() - start < 5.0


def test_a_texture_named_after_its_file_gets_one_extension(tmp_path: Path):
    mesh = samples.box_mesh(material=0)
    mesh = replace(mesh, uvs=(samples.uvs(mesh),))
    photo = replace(samples.PHOTO, name="wood_diff.png")
    wood = Material("wood", base_color_texture=TextureUse("wood_diff.png"))
    main_file = write(samples.content(samples.model([mesh], [wood], [photo])), tmp_path)
    assert [p.name for p in (main_file.parent / "textures").iterdir()] == ["wood_diff.jpg"]
