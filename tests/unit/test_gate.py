"""The static gate: a clean package gives nothing, each single defect gives exactly its rule."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import package_samples as samples
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, Vt

from usdio.gate import RULES, gate
from usdio.write_package import write_package

ROOT = "/sample_1"
HULL = f"{ROOT}/Colliders/collider_01"


def clean(folder: Path) -> Path:
    content = samples.full_content()
    mesh = content.model.meshes[0]
    content = samples.content(content.model, [*content.shapes, samples.hull_shape(mesh)])
    return write_package(content, folder / content.asset_id)


def scale_mass(stage: Usd.Stage, factor: float) -> None:
    """Mass and inertia together, so that only their relation to the size is wrong."""
    api = UsdPhysics.MassAPI(stage.GetDefaultPrim())
    api.GetMassAttr().Set(api.GetMassAttr().Get() * factor)
    scale_inertia(stage, factor)


def scale_inertia(stage: Usd.Stage, factor: float) -> None:
    attribute = UsdPhysics.MassAPI(stage.GetDefaultPrim()).GetDiagonalInertiaAttr()
    attribute.Set(attribute.Get() * factor)


def set_mass_attribute(name: str, value: object) -> Callable[[Usd.Stage], None]:
    return lambda stage: stage.GetDefaultPrim().GetAttribute(f"physics:{name}").Set(value)


def set_material(name: str, value: float) -> Callable[[Usd.Stage], None]:
    path = f"{ROOT}/PhysicsMaterials/wood"
    return lambda stage: stage.GetPrimAtPath(path).GetAttribute(f"physics:{name}").Set(value)


def skew_inertia(stage: Usd.Stage) -> None:
    attribute = UsdPhysics.MassAPI(stage.GetDefaultPrim()).GetDiagonalInertiaAttr()
    total = sum(attribute.Get())
    attribute.Set(Gf.Vec3f(0.2 * total, 0.2 * total, 0.6 * total))


def disable_colliders(stage: Usd.Stage) -> None:
    for prim in stage.Traverse():
        if prim.HasAPI(UsdPhysics.CollisionAPI):
            UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Set(False)


def displace_colliders(stage: Usd.Stage) -> None:
    """2 cm to the side, mass centre along with them."""
    UsdGeom.XformCommonAPI(stage.GetPrimAtPath(f"{ROOT}/Colliders")).SetTranslate((0.02, 0.0, 0.0))
    set_mass_attribute("centerOfMass", Gf.Vec3f(0.02, 0.0, 0.03))(stage)


def unbind_contact(stage: Usd.Stage) -> None:
    prim = stage.GetPrimAtPath(HULL)
    for name in ("material:binding:physics", "material:binding"):
        prim.GetRelationship(name).SetTargets([])


def joint_with_swapped_limits(stage: Usd.Stage) -> None:
    joint = UsdPhysics.RevoluteJoint.Define(stage, f"{ROOT}/hinge")
    joint.CreateLowerLimitAttr(90.0)
    joint.CreateUpperLimitAttr(-90.0)


def lose_texture(stage: Usd.Stage) -> None:
    for prim in stage.Traverse():
        attribute = prim.GetAttribute("inputs:file")
        if attribute:
            attribute.Set(Sdf.AssetPath("./nowhere.png"))
            return


def state_other_size(stage: Usd.Stage) -> None:
    layer = stage.GetRootLayer()
    metadata = {**layer.customLayerData["SimReady_Metadata"], "asset_extents": Gf.Vec3f(1.0, 1.0, 1.0)}
    layer.customLayerData = {**layer.customLayerData, "SimReady_Metadata": metadata}


def send_to_infinity(stage: Usd.Stage) -> None:
    points = UsdGeom.Mesh(stage.GetPrimAtPath(f"{ROOT}/Visuals/body")).GetPointsAttr()
    points.Set(Vt.Vec3fArray.FromNumpy(np.full((len(points.Get()), 3), np.inf, dtype=np.float32)))


DEFECTS: dict[str, tuple[str, Callable[[Usd.Stage], None]]] = {
    "centimetres": ("units", lambda stage: UsdGeom.SetStageMetersPerUnit(stage, 0.01)),
    "grams": ("units", lambda stage: UsdPhysics.SetStageKilogramsPerUnit(stage, 0.001)),
    "y up": ("units", lambda stage: UsdGeom.SetStageUpAxis(stage, "Y")),
    "two roots": ("default-prim", lambda stage: stage.DefinePrim("/Other", "Xform")),
    "no component": ("default-prim", lambda stage: Usd.ModelAPI(stage.GetDefaultPrim()).SetKind("group")),
    "no texture": ("missing-file", lose_texture),
    "other size stated": ("extent", state_other_size),
    "scaled body": ("body-scale", lambda stage: UsdGeom.XformCommonAPI(stage.GetDefaultPrim()).SetScale((2, 2, 2))),
    "mirrored body": ("body-scale", lambda stage: UsdGeom.XformCommonAPI(stage.GetDefaultPrim()).SetScale((-1, 1, 1))),
    "negative mass": ("mass", set_mass_attribute("mass", -1.0)),
    "no mass": ("mass", set_mass_attribute("mass", 0.0)),
    "nan mass": ("mass", set_mass_attribute("mass", float("nan"))),
    "500 times too heavy": ("density", lambda stage: scale_mass(stage, 500.0)),
    "lighter than air": ("density", lambda stage: scale_mass(stage, 1e-3)),
    "negative inertia": ("inertia", lambda stage: scale_inertia(stage, -1.0)),
    "no triangle": ("inertia", skew_inertia),
    "axes not unit": ("inertia", set_mass_attribute("principalAxes", Gf.Quatf(0.5, 0.0, 0.0, 0.0))),
    "inertia in g cm2": ("inertia-scale", lambda stage: scale_inertia(stage, 1e7)),
    "inertia tiny": ("inertia-scale", lambda stage: scale_inertia(stage, 1e-3)),
    "mass centre outside": ("mass-centre-outside", set_mass_attribute("centerOfMass", Gf.Vec3f(0.0, 0.0, 0.2))),
    "mass centre nan": ("mass-centre-outside", set_mass_attribute("centerOfMass", Gf.Vec3f(0.0, float("nan"), 0.0))),
    "nothing to touch": ("no-collider", disable_colliders),
    "concave collider": (
        "collider-not-convex",
        lambda stage: UsdPhysics.MeshCollisionAPI(stage.GetPrimAtPath(HULL)).GetApproximationAttr().Set("none"),
    ),
    "collider elsewhere": ("collider-displaced", displace_colliders),
    "static below dynamic": ("friction", set_material("staticFriction", 0.1)),
    "negative friction": ("friction", set_material("dynamicFriction", -0.1)),
    "no contact material": ("friction", unbind_contact),
    "bouncing up": ("restitution", set_material("restitution", 1.5)),
    "negative restitution": ("restitution", set_material("restitution", -0.5)),
    "swapped limits": ("joint-limits", joint_with_swapped_limits),
}


@pytest.mark.parametrize("name", DEFECTS)
def test_each_defect_fires_its_rule_alone(name: str, tmp_path: Path) -> None:
    slug, spoil = DEFECTS[name]
    main_file = clean(tmp_path)
    assert gate(main_file) == ()
    stage = Usd.Stage.Open(str(main_file))
    spoil(stage)
    stage.GetRootLayer().Save()
    del stage
    found = gate(main_file)
    assert {d.code for d in found} == {f"asset/gate-{slug}"}
    assert all(d.severity == "error" and d.help for d in found)


def test_every_rule_has_a_defect() -> None:
    assert len({slug for slug, _ in DEFECTS.values()}) == len(RULES)


def test_infinite_points_are_found_not_raised(tmp_path: Path) -> None:
    main_file = clean(tmp_path)
    stage = Usd.Stage.Open(str(main_file))
    send_to_infinity(stage)
    stage.GetRootLayer().Save()
    assert "asset/gate-extent" in {d.code for d in gate(main_file)}


def test_unreadable_and_foreign_files_are_findings(tmp_path: Path) -> None:
    file = tmp_path / "x.usda"
    file.write_text("not usd")
    assert [d.code for d in gate(file)] == ["asset/package-invalid"]
    file.write_text('#usda 1.0\ndef Mesh "bare" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {}\n')
    assert "asset/gate-mass" in {d.code for d in gate(file)}
