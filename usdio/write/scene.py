"""Writes a compiled scene as a USD stage with copies of the packages it uses beside it: a self-contained folder.

Packages are copied, not referenced in the library: ingest replaces packages in place, and a checked scene must not
change afterwards; a self-contained folder also opens on any machine.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdSemantics

from geom.mechanism_pose import link_frames
from geom.pose import matrix_of, pose, quat_of
from schemas.arrays import FloatArray
from schemas.identifiers import unique_identifiers
from schemas.physical_constants import GRAVITY_MPS2
from schemas.scene.compiled import CompiledScene, PlacedObject
from usdio.reread.body import reread_linkage
from usdio.write.package import USD_FOLDER
from usdio.write.physics import author_contact_material
from usdio.write.primitive import CONTACT, DENSITY_KGM3, author_primitive

PACKAGES = "packages"
LAMP_INTENSITY = 1200.0
_ROOT = Sdf.Path("/World")
_PREVIEWS = "previews"
_SAME_M = 1e-9  # m, and of a rotation matrix: the pose of the package itself


def write_scene(scene: CompiledScene, library: Path | None, file: Path) -> Path:
    """Write the stage `file` (.usda) and copy the packages of `library` that it uses to `packages/` beside it.

    `/World/Background` is static, every object is a rigid body below `/World/Objects`; poses are those of the
    compiled scene. The same scene gives the same bytes. Returns `file`; raises OSError when writing fails.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    placed = [*([scene.background] if scene.background is not None else []), *scene.objects]
    for package in sorted({item.package for item in placed if item.package is not None}):
        if library is None:
            raise FileNotFoundError(package)
        copy_package(library / package, file.parent / PACKAGES / package)
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    world = UsdGeom.Xform.Define(stage, _ROOT).GetPrim()
    stage.SetDefaultPrim(world)
    Usd.ModelAPI(world).SetKind(Kind.Tokens.assembly)
    author_physics_scene(stage)
    author_lights(stage)
    contact = author_contact_material(stage, _ROOT, CONTACT, DENSITY_KGM3, "inline")
    background = _ROOT.AppendChild("Background")
    if scene.background is not None:
        author_object(stage, background, scene.background, contact, file.parent, moves=False)
    group = UsdGeom.Xform.Define(stage, _ROOT.AppendChild("Objects")).GetPrim()
    Usd.ModelAPI(group).SetKind(Kind.Tokens.group)
    objects = [group.GetPath().AppendChild(name) for name in object_prims(scene)]
    for path, item in zip(objects, scene.objects, strict=True):
        author_object(stage, path, item, contact, file.parent, moves=True)
    del stage, world, group  # A live stage would resolve the packages at once, relative to the anonymous layer.
    for path, item in zip([background, *objects] if scene.background is not None else objects, placed, strict=True):
        if item.package is not None:
            main = f"./{main_file(file.parent, item.package).relative_to(file.parent).as_posix()}"
            layer.GetPrimAtPath(path).referenceList.prependedItems = [Sdf.Reference(main)]
    layer.customLayerData = {
        "mana:scene": scene.scene,
        "mana:seed": scene.seed,
        "mana:combination": {key: scene.combination[key] for key in sorted(scene.combination)},
    }
    if not layer.Export(str(file)):
        raise OSError(f"USD could not write {file.name}")
    return file


def object_prims(scene: CompiledScene) -> Sequence[str]:
    """The prim names below `/World/Objects`, in the order of the objects of the scene."""
    return tuple(unique_identifiers([item.id for item in scene.objects], "object"))


def author_physics_scene(stage: Usd.Stage) -> None:
    """`/World/PhysicsScene`: gravity along -z."""
    physics = UsdPhysics.Scene.Define(stage, _ROOT.AppendChild("PhysicsScene"))
    physics.CreateGravityDirectionAttr(Gf.Vec3f(0.0, 0.0, -1.0))
    physics.CreateGravityMagnitudeAttr(GRAVITY_MPS2)


def author_lights(stage: Usd.Stage) -> None:
    """`/World/Lights`: a soft dome and one lamp, so that the stage is not dark in a viewer."""
    scope = UsdGeom.Scope.Define(stage, _ROOT.AppendChild("Lights")).GetPath()
    UsdLux.DomeLight.Define(stage, scope.AppendChild("Dome")).CreateIntensityAttr(700.0)
    lamp = UsdLux.DistantLight.Define(stage, scope.AppendChild("Lamp"))
    lamp.CreateIntensityAttr(LAMP_INTENSITY)
    lamp.CreateAngleAttr(2.0)
    lamp.AddRotateXYZOp().Set(Gf.Vec3f(35.0, -25.0, 0.0))


def author_object(
    stage: Usd.Stage, path: Sdf.Path, item: PlacedObject, contact: Sdf.Path, folder: Path, *, moves: bool
) -> None:
    """One object at its pose: a reference to its package, or the primitive with collider and mass."""
    prim = UsdGeom.Xform.Define(stage, path).GetPrim()
    if item.primitive is not None:
        author_primitive(stage, path, item.primitive, item.scale, item.mass_kg, contact, moves=moves)
        Usd.ModelAPI(prim).SetKind(Kind.Tokens.component)
    elif item.joints and item.package is not None:
        author_joint_state(stage, path, item, main_file(folder, item.package), moves=moves)
    elif item.package is not None:
        _adapt_body(prim, item, main_file(folder, item.package), moves=moves)
    form = UsdGeom.Xformable(prim)
    form.ClearXformOpOrder()
    form.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*item.position_m))
    w, x, y, z = item.quat_wxyz
    form.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(w, x, y, z))
    if item.package is not None and item.scale != 1.0:
        form.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(item.scale))
    if item.semantic_tags:
        UsdSemantics.LabelsAPI.Apply(prim, "tags").CreateLabelsAttr(list(item.semantic_tags))
    prim.SetCustomDataByKey("mana:id", item.id)
    if item.parent:
        prim.SetCustomDataByKey("mana:on", item.parent)


def main_file(folder: Path, package: str) -> Path:
    """The main USD file of a copied package, the only one in its folder."""
    return min((folder / PACKAGES / package / USD_FOLDER).glob("*.usda"))


def _adapt_body(prim: Usd.Prim, item: PlacedObject, main: Path, *, moves: bool) -> None:
    """Disable the body of a static object, which keeps its colliders; scale the mass of a dynamic one.

    A scaled body keeps its density: mass goes with the cube of the scale, moments of inertia with the fifth power.
    """
    if not moves:
        UsdPhysics.RigidBodyAPI.Apply(prim).CreateRigidBodyEnabledAttr(False)
    elif item.scale != 1.0:
        author_scaled_mass(prim, main, item.scale)


def author_joint_state(stage: Usd.Stage, path: Sdf.Path, item: PlacedObject, main: Path, *, moves: bool) -> None:
    """Poses of the links of an articulated object in its joint state, over those of its package, where they differ.

    Simulators take the positions of joints from the poses of their bodies. `mana:joints` of the object names them (m,
    rad). An object that does not move has its root link held in the world by a fixed joint; its other links are free.
    """
    linkage = reread_linkage(main)
    frames = link_frames(linkage.mechanism, item.joints)
    for link in linkage.mechanism.links:
        X_AL = frames[link.name]
        if not np.allclose(X_AL, pose(None, link.origin), atol=_SAME_M):
            _author_pose(stage, path.AppendChild(link.name), X_AL)
    if not moves:
        root = linkage.mechanism.root
        held = UsdPhysics.FixedJoint.Define(stage, path.AppendChild("HeldInWorld"))
        held.CreateBody1Rel().SetTargets([path.AppendChild(root.name)])
        p_WL = matrix_of(np.array(item.quat_wxyz)) @ root.origin + np.array(item.position_m)
        held.CreateLocalPos0Attr(Gf.Vec3f(*(float(v) for v in p_WL)))
        held.CreateLocalRot0Attr(Gf.Quatf(*item.quat_wxyz))
        held.CreateLocalPos1Attr(Gf.Vec3f(0.0))
        held.CreateLocalRot1Attr(Gf.Quatf(1.0))
    prim = stage.GetPrimAtPath(path)
    for joint in sorted(item.joints):
        prim.SetCustomDataByKey(f"mana:joints:{joint}", item.joints[joint])


def _author_pose(stage: Usd.Stage, path: Sdf.Path, X_AL: FloatArray) -> None:
    """The pose of a link in the frame of its object, as an opinion over the package."""
    form = UsdGeom.Xform.Define(stage, path)
    form.ClearXformOpOrder()
    form.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*(float(v) for v in X_AL[:3, 3])))
    form.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(*(float(v) for v in quat_of(X_AL[:3, :3]))))
    stage.GetRootLayer().GetPrimAtPath(path).specifier = Sdf.SpecifierOver


def author_scaled_mass(prim: Usd.Prim, main: Path, scale: float) -> None:
    """Mass and moments of inertia of the package with the stage `main` at another scale."""
    source = Usd.Stage.Open(str(main))
    stated = UsdPhysics.MassAPI(source.GetDefaultPrim())
    mass = UsdPhysics.MassAPI.Apply(prim)
    mass.CreateMassAttr(stated.GetMassAttr().Get() * scale**3)
    mass.CreateDiagonalInertiaAttr(stated.GetDiagonalInertiaAttr().Get() * scale**5)


def copy_package(source: Path, target: Path) -> None:
    """Copy a package without its previews; files that exist with the same bytes stay untouched."""
    if not source.is_dir():
        raise FileNotFoundError(source)
    for file in sorted(path for path in source.rglob("*") if path.is_file()):
        inside = file.relative_to(source)
        copy = target / inside
        if inside.parts[0] == _PREVIEWS or (copy.is_file() and copy.read_bytes() == file.read_bytes()):
            continue
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, copy)
