"""`mana assets export`: MuJoCo, PyBullet and OpenUSD hold of an export what the package's own USD holds."""

from __future__ import annotations

import hashlib
import json
import os
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pybullet
import pytest
import trimesh
from pxr import Usd, UsdShade, UsdValidation
from typer.testing import CliRunner

from cli.main import app
from schemas.appearance.material import Material, TextureUse
from schemas.package import PackageContent
from schemas.physics import Contact, SurfaceMaterial
from tests.support.library.library_samples import packaged
from tests.support.mechanism.mechanism_samples import articulated
from tests.support.package_samples import PHOTO, box_mesh, content, full_material, hull_shape, model, uvs
from tests.support.present import present
from usdio.quiet import quiet
from usdio.reread.body import RereadPackage, reread_package

ROUGH = SurfaceMaterial("rubber", 1100.0, Contact(static_friction=0.9, dynamic_friction=0.7, restitution=0.3))
SMOOTH = SurfaceMaterial("wood", 500.0, Contact(static_friction=0.4, dynamic_friction=0.4, restitution=0.0))
# The usd-core wheel registers no node of MaterialX, so it calls each of them missing (gate/external_validators.py).
UNREGISTERED = "usdShadeValidators:ShaderSdrCompliance.MissingShaderIdInRegistry"


def textured() -> PackageContent:
    """A board with a JPEG whose coordinates are turned and scaled, beside a flat sheet, and two contact materials."""
    look = Material("Photo", (0.5, 1.0, 1.0), TextureUse("Föto 1", uv_scale=(2.0, 3.0), uv_rotation_rad=0.5))
    board = box_mesh(name="board", material=0)
    board = replace(board, uvs=(uvs(board),))
    sheet = trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0.1, 0.05, 0], [0, 0.05, 0]], [[0, 1, 2], [0, 2, 3]])
    flat = replace(box_mesh(name="sheet"), points=np.array(sheet.vertices), triangles=np.array(sheet.faces, np.int32))
    plain = content(model([board, flat], (look,), (PHOTO,)), (hull_shape(board), hull_shape(box_mesh((0.05,) * 3))))
    return replace(plain, surfaces=(SMOOTH, ROUGH), shape_surfaces=(0, 1))


def run(*arguments: object) -> tuple[int, list[dict[str, Any]]]:
    result = CliRunner().invoke(app, ["assets", "export", *map(str, arguments), "--json"], catch_exceptions=False)
    return result.exit_code, json.loads(result.output)


def exported(package: Path, format_: str, out: Path) -> tuple[RereadPackage, Path, str]:
    """The package as its USD holds it, the exported file, and the headlines of what was lost."""
    code, [row] = run(package.name, "--library", package.parent, "--format", format_, "--out", out)
    assert code == 0
    assert {finding["code"] for finding in row["findings"]} == {"asset/export-loss"}
    note = json.loads((Path(row["file"]).parent / "export.json").read_text())
    assert note["lost"] == row["findings"]
    lost = "\n".join(finding["headline"] for finding in row["findings"])
    return reread_package(package / "usd" / f"{package.name}.usda"), Path(row["file"]), lost


def moved_away(file: Path, place: Path) -> Path:
    """The exported folder elsewhere, where nothing of the library or the first place can help it."""
    return file.parent.rename(place / "elsewhere") / file.name


@pytest.mark.parametrize("made", [articulated, textured])
def test_mujoco_holds_mass_inertia_friction_and_ranges_of_the_package(made: Any, tmp_path: Path) -> None:
    package, file, _ = exported(packaged(tmp_path / "library", made()), "mjcf", tmp_path / "out")
    mj = mujoco.MjModel.from_xml_path(str(moved_away(file, tmp_path)))
    for body in package.bodies:
        held = mj.body(body.name)
        axes = np.empty(9)
        mujoco.mju_quat2Mat(axes, held.iquat)
        R = axes.reshape(3, 3)
        assert held.mass[0] == body.mass.mass_kg
        np.testing.assert_allclose(held.ipos, body.mass.centre_of_mass_m, atol=1e-15)
        np.testing.assert_allclose(R @ np.diag(held.inertia) @ R.T, body.mass.inertia_kgm2, rtol=1e-9, atol=1e-12)
    colliding = [k for k in range(mj.ngeom) if mj.geom_contype[k]]
    assert mj.geom_friction[colliding, 0].tolist() == [c.dynamic_friction for c in package.shape_contacts]
    names = [mj.joint(k).name for k in range(mj.njnt)]
    assert names[0] == f"{package.bodies[0].name}_free"
    joints = {} if package.mechanism is None else {j.name: j.limits for j in package.mechanism.tree}
    assert {n: tuple(mj.joint(n).range) for n in names[1:]} == {n: r or (0.0, 0.0) for n, r in joints.items()}


def test_links_that_never_collide_are_excluded_in_mujoco(tmp_path: Path) -> None:
    package, file, _ = exported(packaged(tmp_path / "library", articulated()), "mjcf", tmp_path / "out")
    mj = mujoco.MjModel.from_xml_path(str(file))
    excluded = {frozenset((mj.body(s >> 16).name, mj.body(s & 0xFFFF).name)) for s in mj.exclude_signature.tolist()}
    assert excluded == {frozenset(pair) for pair in package.filtered_pairs} == {frozenset(("door", "tray"))}


def test_pybullet_holds_mass_inertia_friction_and_limits_of_the_package(tmp_path: Path) -> None:
    package, file, lost = exported(packaged(tmp_path / "library", articulated()), "urdf", tmp_path / "out")
    client = pybullet.connect(pybullet.DIRECT)
    try:
        file = moved_away(file, tmp_path)
        body = pybullet.loadURDF(str(file), flags=pybullet.URDF_USE_INERTIA_FROM_FILE, physicsClientId=client)
        infos = [pybullet.getJointInfo(body, k, client) for k in range(pybullet.getNumJoints(body, client))]
        links = {package.bodies[0].name: -1} | {info[12].decode(): info[0] for info in infos}
        for part in package.bodies:
            mass_kg, friction, inertia, *_ = pybullet.getDynamicsInfo(body, links[part.name], client)
            assert (mass_kg, friction) == (part.mass.mass_kg, part.contact.dynamic_friction)
            assert sorted(inertia) == pytest.approx(sorted(np.linalg.eigvalsh(part.mass.inertia_kgm2)), rel=1e-5)
        limits = {info[1].decode(): info[8:10] for info in infos}
        assert package.mechanism is not None
        for joint in package.mechanism.tree:
            assert joint.limits is None or limits[joint.name] == joint.limits
    finally:
        pybullet.disconnect(client)
    for words in (
        "armature of joint 'hinge'",
        "stiffness of joint 'hinge'",
        "exclude pairs of links",
        "effort and velocity",
    ):
        assert words in lost


def test_shapes_of_a_urdf_have_both_frictions_and_their_restitutions_are_named(tmp_path: Path) -> None:
    _, file, lost = exported(packaged(tmp_path / "library", textured()), "urdf", tmp_path / "out")
    drake = "{http://drake.mit.edu}"
    shapes = list(ET.parse(file).iter(f"{drake}proximity_properties"))
    pairs = [
        [float(present(shape.find(f"{drake}mu_{kind}")).attrib["value"]) for kind in ("static", "dynamic")]
        for shape in shapes
    ]
    assert pairs == [pytest.approx([0.4, 0.4]), pytest.approx([0.9, 0.7])]
    assert "one restitution" in lost


def test_the_picture_lies_on_the_exported_mesh_as_on_the_package(tmp_path: Path) -> None:
    """Texture coordinates with the transform applied, as trimesh reads OBJ and MTL; the JPEG has become a PNG."""
    made = textured()
    _, file, _ = exported(packaged(tmp_path / "library", made), "urdf", tmp_path / "out")
    mesh: Any = trimesh.load(file.parent / "meshes" / "visual_board.obj", process=False, force="mesh")
    cos, sin = np.cos(0.5), np.sin(0.5)
    u, v = (made.model.meshes[0].uvs[0].reshape(-1, 2) * (2.0, 3.0)).T
    expected = np.stack([cos * u - sin * v, sin * u + cos * v], axis=1)
    rows = {tuple(row) for row in np.round(expected, 4)}
    assert rows == {tuple(row) for row in np.round(mesh.visual.uv, 4)}
    picture = mesh.visual.material.image
    assert picture.format == "PNG"
    assert picture.size == (PHOTO.width, PHOTO.height)
    assert [t.attrib["filename"] for t in ET.parse(file).iter("texture")] == ["meshes/Foto_1.png"]


def test_what_no_field_of_the_files_holds_of_a_material_is_named(tmp_path: Path) -> None:
    board = replace(box_mesh(name="board", material=0), uvs=())
    board = replace(board, uvs=(uvs(board), uvs(board, 1)))
    rich = content(model([board], (full_material(),), (PHOTO, replace(PHOTO, name="picture"))))
    _, _, lost = exported(packaged(tmp_path / "library", rich), "mjcf", tmp_path / "out")
    for words in ("normal_texture", "emissive", "clearcoat", "alpha_mode", "roughness_texture", "static one is not"):
        assert words in lost


def test_usdz_passes_every_validator_of_openusd_and_lacks_its_mdl_alone(tmp_path: Path) -> None:
    package, file, lost = exported(packaged(tmp_path / "library", textured()), "usdz", tmp_path / "out")
    file = moved_away(file, tmp_path)
    assert "no MDL modules: Photo, neutral" in lost
    with quiet():
        stage = Usd.Stage.Open(str(file))
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        errors = UsdValidation.ValidationContext(validators).Validate(stage)
    names = {e.GetIdentifier() for e in errors if not e.HasNoError()}
    assert any("UsdzPackage" in v.GetMetadata().name for v in validators)
    assert names <= {UNREGISTERED}
    packed = reread_package(file)
    assert packed.body.mass.mass_kg == package.body.mass.mass_kg
    np.testing.assert_array_equal(packed.body.mass.inertia_kgm2, package.body.mass.inertia_kgm2)
    np.testing.assert_array_equal(packed.visual_points, package.visual_points)
    assert packed.shape_contacts == package.shape_contacts
    materials = [UsdShade.Material(p) for p in stage.Traverse() if p.IsA(UsdShade.Material)]
    outputs = {o.GetBaseName() for m in materials for o in m.GetOutputs() if o.HasConnectedSource()}
    assert outputs == {"surface", "mtlx:surface"}


@pytest.mark.parametrize("format_", ["mjcf", "urdf", "usdz"])
def test_the_same_package_gives_the_same_bytes(format_: str, tmp_path: Path) -> None:
    package = packaged(tmp_path / "library", textured())
    digests = []
    for place, written_s in (("one", 1e9), ("two", 1.5e9)):
        for source in package.rglob("*"):
            os.utime(source, (written_s, written_s))
        file = exported(package, format_, tmp_path / place)[1]
        files = sorted(p for p in file.parent.rglob("*") if p.is_file())
        digests.append([(p.relative_to(file.parent), hashlib.sha256(p.read_bytes()).hexdigest()) for p in files])
    assert digests[0] == digests[1]


def test_refusals_name_their_code_and_leave_what_lies_there(tmp_path: Path) -> None:
    package = packaged(tmp_path / "library", textured())
    taken = tmp_path / "out" / "urdf" / package.name
    taken.mkdir(parents=True)
    (taken / "mine.txt").write_text("mine")
    code, [row] = run(package, "--format", "urdf", "--out", tmp_path / "out")
    assert (code, row["findings"][0]["code"]) == (1, "asset/output-occupied")
    assert (taken / "mine.txt").read_text() == "mine"
    next(package.glob("usd/textures/*")).write_bytes(b"other")
    code, [row] = run(package, "--format", "mjcf", "--out", tmp_path / "out")
    assert (code, row["findings"][0]["code"]) == (1, "asset/library-package-damaged")
    (package / "record.json").unlink()
    code, [row] = run(package, "--format", "mjcf", "--out", tmp_path / "out")
    assert (code, row["findings"][0]["code"]) == (1, "asset/package-invalid")
    assert not (tmp_path / "out" / "mjcf" / package.name).exists()
