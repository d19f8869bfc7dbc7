"""Authors body, mass, colliders and contact materials of a package (UsdPhysics)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from geom.mass.principal_axes import principal_axes
from geom.mesh.corner_normals import face_normals
from geom.pose import apply, quat_of
from schemas.identifiers import identifier
from schemas.physics import CollisionShape, Contact, MassProperties
from usdio.write.materials.author import label_material
from usdio.write.meshes import author_normals, define_mesh, distinct_corner_order

CONTACT_MATERIALS = "PhysicsMaterials"


def author_body(prim: Usd.Prim, mass: MassProperties) -> None:
    """RigidBodyAPI and MassAPI on `prim`: mass, mass centre, principal inertia about the mass centre with its axes."""
    body = UsdPhysics.RigidBodyAPI.Apply(prim)
    body.CreateRigidBodyEnabledAttr(True)
    body.CreateKinematicEnabledAttr(False)
    moments, quat_wxyz = principal_axes(mass.inertia_kgm2)
    api = UsdPhysics.MassAPI.Apply(prim)
    api.CreateMassAttr(float(mass.mass_kg))
    api.CreateCenterOfMassAttr(Gf.Vec3f(*(float(v) for v in mass.centre_of_mass_m)))
    api.CreateDiagonalInertiaAttr(Gf.Vec3f(*(float(v) for v in moments)))
    api.CreatePrincipalAxesAttr(Gf.Quatf(*(float(v) for v in quat_wxyz)))


def author_contact_material(
    stage: Usd.Stage, root: Sdf.Path, contact: Contact, density_kgm3: float, label: str, name: str = ""
) -> Sdf.Path:
    """Define `<root>/PhysicsMaterials/<name>`, by default named as its label, and return its path."""
    scope = UsdGeom.Scope.Define(stage, root.AppendChild(CONTACT_MATERIALS)).GetPath()
    material = UsdShade.Material.Define(stage, scope.AppendChild(name or identifier(label, "unknown")))
    label_material(material, label)
    UsdPhysics.MaterialAPI.Apply(material.GetPrim()).CreateDensityAttr(density_kgm3)
    author_contact_values(material.GetPrim(), contact)
    return material.GetPath()


def author_contact_values(material: Usd.Prim, contact: Contact | None, density_factor: float = 1.0) -> None:
    """Friction, restitution and combine rule of a contact material, where given; its density times `density_factor`."""
    api = UsdPhysics.MaterialAPI(material)
    if contact is not None:
        api.CreateStaticFrictionAttr(contact.static_friction)
        api.CreateDynamicFrictionAttr(contact.dynamic_friction)
        api.CreateRestitutionAttr(contact.restitution)
        # UsdPhysics has no combine rule; engines take the average by default: the rule is kept as custom data.
        material.SetCustomDataByKey("mana:combine", contact.combine)
    if density_factor != 1.0:
        api.GetDensityAttr().Set(density_factor * api.GetDensityAttr().Get())


def author_colliders(
    stage: Usd.Stage,
    root: Sdf.Path,
    shapes: Sequence[CollisionShape],
    materials: Sequence[Sdf.Path],
    taken: set[bytes],
) -> None:
    """Define `<root>/Colliders/collider_<n>` for every shape: purpose guide, collision API, bound contact material.

    `materials` are the paths of their contact materials, one per shape. `taken` are the corner orders of the
    visible meshes, see `distinct_corner_order`.
    """
    colliders = UsdGeom.Xform.Define(stage, root.AppendChild("Colliders")).GetPath()
    for index, (shape, material) in enumerate(zip(shapes, materials, strict=True)):
        path = colliders.AppendChild(f"collider_{index:02d}")
        prim = author_shape(stage, path, shape, taken)
        UsdGeom.Imageable(prim).CreatePurposeAttr(UsdGeom.Tokens.guide)
        binding = UsdShade.MaterialBindingAPI.Apply(prim)
        binding.Bind(UsdShade.Material.Get(stage, material), materialPurpose="physics")
        # MuJoCo's USD reader reads the all-purpose binding only.
        binding.Bind(UsdShade.Material.Get(stage, material))


def author_shape(stage: Usd.Stage, path: Sdf.Path, shape: CollisionShape, taken: set[bytes]) -> Usd.Prim:
    """The prim of one shape, posed in the frame of its parent, with collision API; no material, default purpose."""
    prim = _hull(stage, path, shape, taken) if shape.kind == "hull" else _primitive(stage, path, shape)
    UsdPhysics.CollisionAPI.Apply(prim).CreateCollisionEnabledAttr(True)
    return prim


def _hull(stage: Usd.Stage, path: Sdf.Path, shape: CollisionShape, taken: set[bytes]) -> Usd.Prim:
    if shape.points is None or shape.triangles is None:
        raise ValueError("a hull shape needs points and triangles")
    points = apply(shape.X_AS, shape.points)
    corners = distinct_corner_order(points, shape.triangles, taken)
    triangles = shape.triangles.reshape(-1)[corners].reshape(-1, 3)
    mesh = define_mesh(stage, path, points, triangles)
    author_normals(mesh, face_normals(points, triangles), UsdGeom.Tokens.uniform)
    UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim()).CreateApproximationAttr(UsdPhysics.Tokens.convexHull)
    return mesh.GetPrim()


def _primitive(stage: Usd.Stage, path: Sdf.Path, shape: CollisionShape) -> Usd.Prim:
    match shape.kind:
        case "box":
            gprim = UsdGeom.Cube.Define(stage, path)
            gprim.CreateSizeAttr(1.0)
        case "sphere":
            gprim = UsdGeom.Sphere.Define(stage, path)
            gprim.CreateRadiusAttr(shape.size_m[0])
        case "capsule" | "cylinder":
            gprim = (UsdGeom.Capsule if shape.kind == "capsule" else UsdGeom.Cylinder).Define(stage, path)
            gprim.CreateAxisAttr(UsdGeom.Tokens.z)
            gprim.CreateRadiusAttr(shape.size_m[0])
            gprim.CreateHeightAttr(shape.size_m[1])
        case _:
            raise ValueError(f"not a primitive shape: {shape.kind}")
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(gprim, Usd.TimeCode.Default())
    gprim.CreateExtentAttr(extent)
    _pose(UsdGeom.Xformable(gprim), shape.X_AS, shape.size_m if shape.kind == "box" else None)
    return gprim.GetPrim()


def _pose(xformable: UsdGeom.Xformable, X_AS: np.ndarray, edges_m: tuple[float, ...] | None) -> None:
    """Author translation and orientation of X_AS; the unit cube is then scaled to its edges."""
    w, x, y, z = (float(v) for v in quat_of(X_AS[:3, :3]))
    xformable.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*(float(v) for v in X_AS[:3, 3])))
    xformable.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(w, x, y, z))
    if edges_m is not None:
        xformable.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*edges_m))
