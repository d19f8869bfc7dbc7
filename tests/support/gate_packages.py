"""Two clean packages to seed defects into: a textured prop, and a cabinet with a drawer and a door."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import trimesh
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade

from assetkit.package.write_urdf import write_urdf
from geom.mass.inertia import combine, moved, of_box
from geom.mesh.corner_normals import face_normals
from geom.mesh.topology import observe
from geom.pose import pose
from schemas.package import PackageContent
from schemas.physics import CollisionShape, Contact, MassProperties
from tests.support import package_samples as samples
from usdio.quiet import quiet
from usdio.reread.body import reread_body
from usdio.write.materials.author import label_material
from usdio.write.meshes import author_normals, define_mesh
from usdio.write.package import write_package
from usdio.write.physics import author_body, author_colliders, author_contact_material

DENSITY_KGM3 = 600.0
ROOT = Sdf.Path("/cabinet")


class Board(NamedTuple):
    """An axis-aligned wooden box: name, edges and centre in the frame of the whole cabinet (metres)."""

    name: str
    size_m: tuple[float, float, float]
    centre_m: tuple[float, float, float]


# 0.4 deep (x, front is +x), 0.5 wide (y), 0.8 high (z), boards of 2 cm; drawer above, door below; gaps of 3 mm.
LINKS: dict[str, tuple[Board, ...]] = {
    "base": (
        Board("left", (0.4, 0.02, 0.8), (0.0, -0.24, 0.4)),
        Board("right", (0.4, 0.02, 0.8), (0.0, 0.24, 0.4)),
        Board("bottom", (0.4, 0.46, 0.02), (0.0, 0.0, 0.01)),
        Board("middle", (0.38, 0.46, 0.02), (0.01, 0.0, 0.5)),
        Board("top", (0.4, 0.46, 0.02), (0.0, 0.0, 0.79)),
        Board("back", (0.02, 0.46, 0.76), (-0.19, 0.0, 0.4)),
    ),
    "drawer": (
        Board("floor", (0.34, 0.42, 0.01), (0.013, 0.0, 0.525)),
        Board("side_left", (0.34, 0.015, 0.15), (0.013, -0.2175, 0.605)),
        Board("side_right", (0.34, 0.015, 0.15), (0.013, 0.2175, 0.605)),
        Board("rear", (0.015, 0.42, 0.15), (-0.1495, 0.0, 0.605)),
        Board("front", (0.02, 0.454, 0.264), (0.193, 0.0, 0.645)),
    ),
    "door": (
        Board("panel", (0.02, 0.5, 0.49), (0.213, 0.0, 0.247)),
        Board("knob", (0.03, 0.03, 0.03), (0.238, -0.2, 0.25)),
    ),
}
HINGE_M = (0.213, 0.25, 0.247)  # the door turns about z at its right edge, opening towards +x


def prop(folder: Path) -> Path:
    """A textured box with a box and a hull collider, its URDF twin and its record; returns the main USD file."""
    content = samples.full_content()
    hull = samples.hull_shape(content.model.meshes[0])
    content = samples.content(content.model, [*content.shapes, hull], category="box", qcode="Q188075")
    main_file = write_package(content, folder / content.asset_id)
    write_urdf(reread_body(main_file), content, folder / content.asset_id)
    (folder / content.asset_id / "record.json").write_text(json.dumps(_record(content)))
    return main_file


def _record(content: PackageContent) -> dict:
    """The figures of an AssetRecord that the gate compares."""
    mesh = content.model.meshes[0]
    return {
        "asset_id": content.asset_id,
        "geometry": {
            "extent_m": {"value": np.ptp(mesh.points, axis=0).tolist()},
            "reobserved": observe(mesh.points, mesh.triangles, "merged").model_dump(mode="json"),
        },
        "semantics": {"category": {"value": content.category}},
        "physics": {
            "mass_kg": {"value": content.mass.mass_kg},
            "density_kgm3": {"value": content.density_kgm3},
            "centre_of_mass_m": {"value": content.mass.centre_of_mass_m.tolist()},
            "inertia_kgm2": {"value": content.mass.inertia_kgm2.tolist()},
            "collision_method": "hull",
            "candidates": [{"method": "hull", "shapes": len(content.shapes)}],
            "contacts": [{"value": content.contact.model_dump(mode="json")}],
        },
    }


def cabinet(folder: Path, scale: float = 1.0) -> Path:
    """A cabinet of three links with a prismatic and a revolute joint, all lengths times `scale`; the main USD file."""
    main_file = folder / "cabinet" / "usd" / "cabinet.usda"
    main_file.parent.mkdir(parents=True)
    stage = Usd.Stage.CreateNew(str(main_file))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, ROOT).GetPrim()
    stage.SetDefaultPrim(root)
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    UsdPhysics.ArticulationRootAPI.Apply(root)
    UsdSemantics.LabelsAPI.Apply(root, "class").CreateLabelsAttr(["cabinet"])
    UsdSemantics.LabelsAPI.Apply(root, "wikidata_qcode").CreateLabelsAttr(["Q614806"])
    contact = Contact(static_friction=0.5, dynamic_friction=0.4, restitution=0.1)
    material = author_contact_material(stage, ROOT, contact, DENSITY_KGM3, "wood")
    visual_material = _visual_material(stage)
    masses = {name: _link(stage, name, scale, material, visual_material) for name in LINKS}
    _joints(stage, scale)
    _metadata(stage, sum(m.mass_kg for m in masses.values()))
    stage.GetRootLayer().Save()
    thumbnail = main_file.parent / ".thumbs" / "256x256" / f"{main_file.name}.png"
    thumbnail.parent.mkdir(parents=True)
    thumbnail.write_bytes(samples.png())
    return main_file


def seeded(edit: Callable[[Usd.Stage], object], main_file: Path, folder: Path) -> Path:
    """The main file of a copy of a package with one edit in it; `folder` is emptied first."""
    package = main_file.parent.parent
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(package, folder / package.name)
    copy = folder / package.name / main_file.relative_to(package)
    with quiet():
        stage = Usd.Stage.Open(str(copy))
        edit(stage)
        stage.GetRootLayer().Save()
        del stage
    return copy


def origin_of(link: str) -> np.ndarray:
    """(3,) origin of a link's frame in the asset at scale 1: the hinge for the door, else the drawing's origin."""
    return _shift() + (np.array(HINGE_M) if link == "door" else np.zeros(3))


def _shift() -> np.ndarray:
    """(3,) moves the cabinet so that its bottom centre is the origin."""
    boards = [b for link in LINKS.values() for b in link]
    low = np.min([np.array(b.centre_m) - np.array(b.size_m) / 2 for b in boards], axis=0)
    high = np.max([np.array(b.centre_m) + np.array(b.size_m) / 2 for b in boards], axis=0)
    return -np.array([*(0.5 * (low + high)[:2]), low[2]])


def _link(stage: Usd.Stage, name: str, scale: float, material: Sdf.Path, visual_material: Sdf.Path) -> MassProperties:
    path = ROOT.AppendChild(name)
    link = UsdGeom.Xform.Define(stage, path)
    origin = scale * origin_of(name)
    boards = [Board(b.name, _times(scale, b.size_m), _times(scale, b.centre_m)) for b in LINKS[name]]
    link.AddTranslateOp().Set(Gf.Vec3d(*origin.tolist()))
    poses = [pose(None, tuple(np.array(b.centre_m) + scale * _shift() - origin)) for b in boards]
    shapes = [CollisionShape("box", b.size_m, X) for b, X in zip(boards, poses, strict=True)]
    mass = combine([moved(of_box(b.size_m, DENSITY_KGM3), X) for b, X in zip(boards, poses, strict=True)])
    author_body(link.GetPrim(), mass)
    for board, X_LB in zip(boards, poses, strict=True):
        box = trimesh.creation.box(board.size_m, transform=X_LB)
        points, triangles = np.array(box.vertices), np.array(box.faces, dtype=np.int32)
        mesh = define_mesh(stage, path.AppendPath(f"Visuals/{board.name}"), points, triangles)
        author_normals(mesh, face_normals(points, triangles), UsdGeom.Tokens.uniform)
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(UsdShade.Material.Get(stage, visual_material))
    UsdGeom.Xform.Define(stage, path.AppendChild("Visuals"))
    author_colliders(stage, path, shapes, [material] * len(shapes), set())
    return mass


def _times(scale: float, lengths: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = lengths
    return scale * x, scale * y, scale * z


def _visual_material(stage: Usd.Stage) -> Sdf.Path:
    material = UsdShade.Material.Define(stage, ROOT.AppendPath("Materials/oak"))
    UsdGeom.Scope.Define(stage, ROOT.AppendChild("Materials"))
    label_material(material, "wood")
    shader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("surface"))
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(0.6, 0.45, 0.3))
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.6)
    shader.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(0.0)
    material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", Sdf.ValueTypeNames.Token))
    return material.GetPath()


def _joints(stage: Usd.Stage, scale: float) -> None:
    scope = UsdGeom.Scope.Define(stage, ROOT.AppendChild("Joints")).GetPath()
    anchor = UsdPhysics.FixedJoint.Define(stage, scope.AppendChild("anchor"))
    anchor.CreateBody1Rel().SetTargets([ROOT.AppendChild("base")])
    _frames(anchor, np.zeros(3), -scale * origin_of("base"))
    slide = UsdPhysics.PrismaticJoint.Define(stage, scope.AppendChild("slide"))
    hinge = UsdPhysics.RevoluteJoint.Define(stage, scope.AppendChild("hinge"))
    for joint, link, axis, (lower, upper) in (
        (slide, "drawer", "X", (0.0, 0.3 * scale)),
        (hinge, "door", "Z", (0.0, 110.0)),
    ):
        joint.CreateBody0Rel().SetTargets([ROOT.AppendChild("base")])
        joint.CreateBody1Rel().SetTargets([ROOT.AppendChild(link)])
        joint.CreateAxisAttr(axis)
        joint.CreateLowerLimitAttr(lower)
        joint.CreateUpperLimitAttr(upper)
        _frames(joint, scale * (origin_of(link) - origin_of("base")), np.zeros(3))
    for joint, kind in ((slide, "linear"), (hinge, "angular")):
        drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), kind)
        drive.CreateTypeAttr("force")
        drive.CreateStiffnessAttr(0.0)
        drive.CreateDampingAttr(0.5)
        drive.CreateMaxForceAttr(20.0)


def _frames(joint: UsdPhysics.Joint, p_0: np.ndarray, p_1: np.ndarray) -> None:
    joint.CreateLocalPos0Attr(Gf.Vec3f(*p_0.tolist()))
    joint.CreateLocalPos1Attr(Gf.Vec3f(*p_1.tolist()))
    joint.CreateLocalRot0Attr(Gf.Quatf(1.0))
    joint.CreateLocalRot1Attr(Gf.Quatf(1.0))


def _metadata(stage: Usd.Stage, mass_kg: float) -> None:
    bounds = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"]).ComputeWorldBound(stage.GetDefaultPrim())
    stated = {
        "asset_name": "cabinet",
        "asset_type": "prop",
        "asset_license": "unknown",
        "author": "unknown",
        "category": "cabinet",
        "source_file": "cabinet.urdf",
        "usd_date_generated": "1980-01-01",
        "qcode": "Q614806",
        "rigid_body_count": len(LINKS),
        "asset_extents": Gf.Vec3f(bounds.ComputeAlignedRange().GetSize()),
        "mass": mass_kg,
    }
    repeated = {key: stated[key] for key in ("asset_name", "asset_type", "source_file", "usd_date_generated")}
    stage.GetRootLayer().customLayerData = {"SimReady_Metadata": stated, **repeated}
