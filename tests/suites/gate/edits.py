"""Edits of a USD stage that break one thing in a clean package, and the prim paths they use."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade, Vt

Edit = Callable[[Usd.Stage], Any]
NAN, INF = math.nan, math.inf


class Defect(NamedTuple):
    """What is broken, in which clean package (`prop` or `cabinet`), how, and what the gate must report."""

    name: str
    package: str
    edit: Edit
    code: str
    severity: str = "error"


class Sound(NamedTuple):
    """What is changed, in which clean package and how, without making it wrong: the gate must report nothing."""

    name: str
    package: str
    edit: Edit


def prop(name: str, edit: Edit, code: str, severity: str = "error") -> Defect:
    """A defect of the prop."""
    return Defect(name, "prop", edit, f"asset/gate-{code}", severity)


def cabinet(name: str, edit: Edit, code: str, severity: str = "error") -> Defect:
    """A defect of the cabinet."""
    return Defect(name, "cabinet", edit, f"asset/gate-{code}", severity)


PROP, HULL = "/sample_1", "/sample_1/Colliders/collider_01"
BODY_MESH = "/sample_1/Visuals/body"
PROP_MATERIAL = "/sample_1/PhysicsMaterials/wood"
SURFACE = "/sample_1/Materials/Alles_dran/surface"
CABINET, BASE, DRAWER, DOOR = "/cabinet", "/cabinet/base", "/cabinet/drawer", "/cabinet/door"
SLIDE, HINGE, ANCHOR = "/cabinet/Joints/slide", "/cabinet/Joints/hinge", "/cabinet/Joints/anchor"
OAK = "/cabinet/Materials/oak/surface"
TYPES = Sdf.ValueTypeNames


def put(path: str, name: str, value: Any, kind: Any = None) -> Edit:
    """Set an attribute, which is created when a type is given."""

    def edit(stage: Usd.Stage) -> None:
        prim = stage.GetPrimAtPath(path)
        attribute = prim.GetAttribute(name) if kind is None else prim.CreateAttribute(name, kind)
        assert attribute.Set(value)

    return edit


def shift(path: str, name: str, by: Any) -> Edit:
    """Add to an attribute."""

    def edit(stage: Usd.Stage) -> None:
        attribute = stage.GetPrimAtPath(path).GetAttribute(name)
        assert attribute.Set(attribute.Get() + by)

    return edit


def times(path: str, name: str, factor: float) -> Edit:
    """Multiply an attribute."""

    def edit(stage: Usd.Stage) -> None:
        attribute = stage.GetPrimAtPath(path).GetAttribute(name)
        assert attribute.Set(attribute.Get() * factor)

    return edit


def remove(path: str, name: str) -> Edit:
    """Leave an attribute or relationship without opinion in the whole layer stack."""

    def edit(stage: Usd.Stage) -> None:
        for layer in stage.GetUsedLayers():
            prim = layer.GetPrimAtPath(path)
            if prim is not None and name in prim.properties:
                del prim.properties[name]
            layer.Save() if layer.permissionToSave else None

    return edit


def unapply(path: str, schema: Any, *instance: str) -> Edit:
    """Take an API schema away."""
    return lambda stage: stage.GetPrimAtPath(path).RemoveAPI(schema, *instance)


def target(path: str, name: str, *targets: str) -> Edit:
    """Point a relationship elsewhere; nowhere without targets."""
    return lambda stage: stage.GetPrimAtPath(path).CreateRelationship(name).SetTargets([Sdf.Path(t) for t in targets])


def both(*edits: Edit) -> Edit:
    """Several edits."""
    return lambda stage: [edit(stage) for edit in edits] and None


def after_release(edit: Callable[[Usd.Stage, Path], Any]) -> Edit:
    """Write the hashes of all files into the record, as a release does, then edit stage or package folder."""

    def sealed(stage: Usd.Stage) -> None:
        package = Path(stage.GetRootLayer().realPath).parents[1]
        note = package / "record.json"
        files = [path for path in sorted(package.rglob("*")) if path.is_file() and path != note]
        hashes = {p.relative_to(package).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}
        note.write_text(json.dumps({**json.loads(note.read_text()), "hashes": hashes}))
        edit(stage, package)

    return sealed


def place(path: str, translate=(0.0, 0.0, 0.0), scale=None, rotate=None) -> Edit:
    """Add transform operations in front of those a prim has."""

    def edit(stage: Usd.Stage) -> None:
        xformable = UsdGeom.Xformable(stage.GetPrimAtPath(path))
        operations = xformable.GetOrderedXformOps()
        new = [xformable.AddTranslateOp(opSuffix="seeded")]
        new[0].Set(Gf.Vec3d(*translate))
        if rotate is not None:
            new.append(xformable.AddRotateXYZOp(opSuffix="seeded"))
            new[-1].Set(Gf.Vec3f(*rotate))
        if scale is not None:
            new.append(xformable.AddScaleOp(opSuffix="seeded"))
            new[-1].Set(Gf.Vec3f(*scale))
        xformable.SetXformOpOrder([*new, *operations])

    return edit


def metadata(key: str, value: Any) -> Edit:
    """State something else in the SimReady metadata."""

    def edit(stage: Usd.Stage) -> None:
        layer = stage.GetRootLayer()
        stated = {**layer.customLayerData["SimReady_Metadata"], key: value}
        layer.customLayerData = {**layer.customLayerData, "SimReady_Metadata": stated}

    return edit


def points(path: str, change: Callable[[np.ndarray], np.ndarray]) -> Edit:
    """Change the points of a mesh."""

    def edit(stage: Usd.Stage) -> None:
        attribute = UsdGeom.Mesh(stage.GetPrimAtPath(path)).GetPointsAttr()
        changed = change(np.array(attribute.Get(), dtype=np.float32))
        attribute.Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(changed, dtype=np.float32)))

    return edit


def move_link(path: str, by: tuple[float, float, float], joint: str) -> Edit:
    """Move a link and the joint frame on its parent with it, so that only the space it takes is wrong."""

    def edit(stage: Usd.Stage) -> None:
        translate = UsdGeom.Xformable(stage.GetPrimAtPath(path)).GetOrderedXformOps()[0]
        translate.Set(translate.Get() + Gf.Vec3d(*by))
        anchor = stage.GetPrimAtPath(joint).GetAttribute("physics:localPos0")
        anchor.Set(anchor.Get() + Gf.Vec3f(*by))

    return edit


def reverse_faces(path: str, count: int | None = None) -> Edit:
    """Wind the first `count` triangles, or all, the other way; normals stay."""

    def edit(stage: Usd.Stage) -> None:
        attribute = UsdGeom.Mesh(stage.GetPrimAtPath(path)).GetFaceVertexIndicesAttr()
        faces = np.array(attribute.Get()).reshape(-1, 3)
        faces[:count] = faces[:count, ::-1]
        attribute.Set(Vt.IntArray.FromNumpy(np.ascontiguousarray(faces.reshape(-1), dtype=np.int32)))

    return edit


def turn_inside_out(path: str) -> Edit:
    """Reverse winding and normals together."""

    def edit(stage: Usd.Stage) -> None:
        reverse_faces(path)(stage)
        normals = stage.GetPrimAtPath(path).GetAttribute("primvars:normals")
        values = -np.array(normals.Get()).reshape(-1, 3)
        if len(values) % 3 == 0 and "faceVarying" in str(UsdGeom.Primvar(normals).GetInterpolation()):
            values = values.reshape(-1, 3, 3)[:, ::-1].reshape(-1, 3)
        normals.Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(values)))

    return edit


def drop_faces(path: str, keep: slice) -> Edit:
    """Keep some of the triangles, with their normals and texture coordinates."""

    def edit(stage: Usd.Stage) -> None:
        prim = stage.GetPrimAtPath(path)
        mesh = UsdGeom.Mesh(prim)
        faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)[keep]
        mesh.GetFaceVertexIndicesAttr().Set(Vt.IntArray.FromNumpy(np.ascontiguousarray(faces.reshape(-1))))
        mesh.GetFaceVertexCountsAttr().Set(Vt.IntArray([3] * len(faces)))
        for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithAuthoredValues():
            if primvar.GetInterpolation() == UsdGeom.Tokens.faceVarying:
                values = np.array(primvar.Get())
                rows = values.reshape(-1, 3, *values.shape[1:])[keep].reshape(-1, *values.shape[1:])
                make = Vt.Vec3fArray if values.shape[1] == 3 else Vt.Vec2fArray
                primvar.Set(make.FromNumpy(np.ascontiguousarray(rows)))

    return edit


def shader(path: str, name: str, value: Any, kind: Any) -> Edit:
    """Give a shader input a constant, whatever fed it before."""

    def edit(stage: Usd.Stage) -> None:
        port = UsdShade.Shader(stage.GetPrimAtPath(path)).CreateInput(name, kind)
        port.ClearSources()
        port.GetAttr().SetConnections([])
        port.Set(value)

    return edit


def texture_of(name: str, change: Callable[[Usd.Prim], None]) -> Edit:
    """Change the texture that feeds a surface input of the prop."""

    def edit(stage: Usd.Stage) -> None:
        port = UsdShade.Shader(stage.GetPrimAtPath(SURFACE)).GetInput(name)
        change(port.GetConnectedSources()[0][0].source.GetPrim())

    return edit


def skew_inertia(stage: Usd.Stage) -> None:
    """Same trace, no real body."""
    attribute = stage.GetPrimAtPath(PROP).GetAttribute("physics:diagonalInertia")
    total = sum(attribute.Get())
    attribute.Set(Gf.Vec3f(0.2 * total, 0.2 * total, 0.6 * total))


def each_collider(path: str, edit: Callable[[Usd.Prim], Any]) -> Edit:
    """Apply `edit` to every collider below a prim."""

    def all_of(stage: Usd.Stage) -> None:
        for prim in Usd.PrimRange(stage.GetPrimAtPath(path)):
            if prim.HasAPI(UsdPhysics.CollisionAPI):
                edit(prim)

    return all_of


def heavier(path: str, factor: float) -> Edit:
    """Scale mass, inertia and metadata together, so that only their relation to the size is wrong."""

    def edit(stage: Usd.Stage) -> None:
        times(path, "physics:mass", factor)(stage)
        times(path, "physics:diagonalInertia", factor)(stage)
        bodies = [p for p in stage.Traverse() if p.HasAPI(UsdPhysics.MassAPI)]
        metadata("mass", sum(p.GetAttribute("physics:mass").Get() for p in bodies))(stage)

    return edit


def permute_inertia(stage: Usd.Stage) -> None:
    """The door spins as if its long side were its short one."""
    attribute = stage.GetPrimAtPath(DOOR).GetAttribute("physics:diagonalInertia")
    x, y, z = sorted(attribute.Get())
    attribute.Set(Gf.Vec3f(z, y, x) if attribute.Get()[0] == x else Gf.Vec3f(x, y, z))


def second_hinge(stage: Usd.Stage) -> None:
    """Drawer and door joined too: a closed loop."""
    joint = UsdPhysics.FixedJoint.Define(stage, "/cabinet/Joints/extra")
    joint.CreateBody0Rel().SetTargets([DRAWER])
    joint.CreateBody1Rel().SetTargets([DOOR])
    p_drawer, p_door = (UsdGeom.Xformable(stage.GetPrimAtPath(p)).GetLocalTransformation() for p in (DRAWER, DOOR))
    joint.CreateLocalPos0Attr(Gf.Vec3f(p_door.ExtractTranslation() - p_drawer.ExtractTranslation()))


def on_prim(path: str, change: Callable[[Usd.Prim], Any]) -> Edit:
    """Apply `change` to one prim."""
    return lambda stage: change(stage.GetPrimAtPath(path))


def label(taxonomy: str, *values: str) -> Edit:
    """Other semantic labels on the default prim."""
    return lambda stage: UsdSemantics.LabelsAPI(stage.GetDefaultPrim(), taxonomy).GetLabelsAttr().Set(values)
