"""Retopology as a whole: what is released looks alike, what does not is dropped, and who refers to meshes still can."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from assetkit.options import Options
from assetkit.pipeline import STAGES, run_stages
from assetkit.retopo import remesh
from assetkit.retopo import retopologize as whole
from assetkit.retopo.retopologize import LEAST_IOU, MOST_COLOUR_ERROR_255, retopologize
from assetkit.stage import Appearance, Canonical, Draft, Intake, Tools
from assetkit.stage_log import StageLog
from benchmarks.assets.heavy_scans import heavy, read_model
from jobs.cache import Cache
from schemas.appearance.material import Anisotropy, Material, TextureUse
from sim.fake import FakeSimulator
from tests.assetkit.retopo.things import bumpy_sphere, checkered_cube, model_of

PX = 512


def test_a_heavy_cube_becomes_a_light_one_with_its_figures(tmp_path: Path) -> None:
    model = checkered_cube()
    outcome = retopologize(model, 100, PX, tmp_path)
    assert outcome.value is not None
    light, section = outcome.value, outcome.value.section
    assert section is not None
    assert section.released
    assert [d.code for d in outcome.diagnostics] == ["asset/retopology"]
    assert len(light.meshes[0].triangles) == section.triangles_after <= 100 < section.triangles_before == 3072
    assert section.silhouette_iou.value >= LEAST_IOU
    assert section.colour_error_255.value <= MOST_COLOUR_ERROR_255
    assert set(section.maps) == {"base_color", "normal"}
    assert {t.name for t in light.textures} == {"retopo_base_color", "retopo_normal"}
    (repair,) = outcome.repairs
    assert repair.after["silhouette_iou"] == section.silhouette_iou.value


@pytest.mark.parametrize(("name", "bound"), [("LEAST_IOU", 1.1), ("MOST_COLOUR_ERROR_255", 0.0)])
def test_a_missed_bound_keeps_the_source_and_the_record_of_the_try(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, bound: float
) -> None:
    monkeypatch.setattr(whole, name, bound)
    model = checkered_cube()
    outcome = retopologize(model, 100, 64, tmp_path)
    assert outcome.value is not None
    assert outcome.value.meshes == model.meshes
    assert outcome.value.textures == model.textures
    assert outcome.value.section is not None
    assert not outcome.value.section.released
    (note,) = outcome.diagnostics
    assert (note.code, note.bound, outcome.repairs) == ("asset/retopology-unlike-source", bound, ())


def test_a_light_source_and_a_library_that_ends_leave_the_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = checkered_cube(4)
    light = retopologize(model, 5000, PX, tmp_path)
    monkeypatch.setattr(remesh, "REMESH_CPU_S", 0)
    ended = retopologize(model, 64, PX, tmp_path)
    for outcome in (light, ended):
        assert [d.code for d in outcome.diagnostics] == ["asset/retopology-skipped"]
        assert outcome.value is not None
        assert outcome.value.meshes == model.meshes
    assert "192 triangles" in light.diagnostics[0].headline
    assert "remeshing" in ended.diagnostics[0].headline


@pytest.mark.parametrize(
    "layered",
    [
        Material("leaf", base_color_texture=TextureUse("checker"), alpha_mode="mask"),
        Material("hair", base_color_texture=TextureUse("checker"), anisotropy=Anisotropy(0.5)),
        Material("coat", clearcoat=1.0, clearcoat_texture=TextureUse("checker")),
    ],
    ids=lambda material: material.name,
)
def test_a_mesh_whose_material_needs_its_own_coordinates_stays_as_it_is(tmp_path: Path, layered: Material) -> None:
    model = checkered_cube()
    (mesh,) = model.meshes
    beside = replace(mesh, name="own", points=mesh.points + np.array([0.15, 0.0, 0.0]), material=1)
    pair = replace(model, meshes=(mesh, beside), materials=(*model.materials, layered)).with_mesh_ids()
    outcome = retopologize(pair, 100, PX, tmp_path)
    assert outcome.value is not None
    section = outcome.value.section
    assert section is not None
    assert (section.meshes, section.kept) == (("cube",), ("own",))
    assert outcome.value.meshes[1] is pair.meshes[1]
    assert outcome.value.materials[1] == layered
    assert "checker" in {texture.name for texture in outcome.value.textures}


def test_later_stages_go_on_with_the_light_mesh_and_its_maps(tmp_path: Path) -> None:
    """Without the option the stage does not run; with it mesh, material and textures are those of the atlas."""
    model = checkered_cube()
    draft = Draft("cube", "cube.obj", Intake("obj", (), model, (0.1, 0.1, 0.1)))
    pipeline, cache = STAGES.up_to("appearance"), Cache(tmp_path / "store")
    drafts = {}
    for faces in (None, 100):
        log, tools = StageLog(), Tools(FakeSimulator(), tmp_path, Options(retopo=faces, units="m"))
        made = run_stages(draft, tools, log, cache, "key", pipeline)
        assert made is not None
        drafts[faces] = made
        assert ("retopology" in log.entries) == (faces is not None)
    assert len(drafts[None].model.meshes[0].triangles) == 3072
    light = drafts[100]
    assert len(light[Canonical].meshes[0].triangles) <= 100
    assert {texture.name for texture in light[Appearance].textures} == {"retopo_base_color", "retopo_normal"}
    assert light.model.meshes[0].id == drafts[None].model.meshes[0].id
    assert light[Canonical].solid.kind == "closed"


def test_values_out_of_range_are_mended_before_they_are_baked_and_reported(tmp_path: Path) -> None:
    model = checkered_cube()
    wild = replace(model, materials=(replace(model.materials[0], metallic=7.0),))
    outcome = retopologize(wild, 100, PX, tmp_path)
    codes = [d.code for d in outcome.diagnostics]
    assert codes.count("asset/invalid-material-value") == 1
    assert outcome.value is not None
    assert outcome.value.materials[0].metallic == 1.0


def test_a_bumpy_sphere_without_pictures_keeps_its_relief(tmp_path: Path) -> None:
    outcome = retopologize(bumpy_sphere(), 600, PX, tmp_path)
    assert outcome.value is not None
    assert outcome.value.section is not None
    assert outcome.value.section.released
    assert outcome.value.section.maps["normal"].mean.value < 1.5


def test_an_uncoloured_mesh_without_material_is_made_light_without_maps(tmp_path: Path) -> None:
    (ball,) = bumpy_sphere(5).meshes
    outcome = retopologize(model_of(replace(ball, material=None)), 2000, PX, tmp_path)
    assert outcome.value is not None
    assert outcome.value.textures == ()
    assert outcome.value.materials == ()


@pytest.mark.shared
def test_a_scan_of_a_quarter_million_faces_looks_alike_with_five_thousand(shared_assets: Path, tmp_path: Path) -> None:
    """Issue 32: silhouettes to 0.98, colours to 3 of 255; the relief of its ripples is in the normal map."""
    scan = heavy(read_model(shared_assets / "obj/hope_ketchup_obj_cm/textured.obj"), 200_000)
    outcome = retopologize(scan, 5000, 2048, tmp_path)
    assert outcome.value is not None
    section = outcome.value.section
    assert section is not None
    assert section.released
    assert (section.triangles_before, section.triangles_after) == (248_560, 5000)
    assert section.silhouette_iou.value > 0.99
    assert section.colour_error_255.value < 2.0
    assert section.maps["base_color"].mean.value < 0.5
    assert section.maps["normal"].p95 < 3.0
    assert np.isclose(section.texels_by_ray, 1.0, atol=0.01)
