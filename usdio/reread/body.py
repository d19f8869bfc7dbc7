"""Reads a released package back from disk, as a simulator would: rigid body, contact materials, visible surface.

Input is the main USD file; output is in the asset frame, metres and kilograms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics

from geom.mass.principal_axes import inertia_from_principal
from geom.mechanism_pose import link_frames
from geom.pose import apply, pose, shortest_rotation
from schemas.arrays import FloatArray, IntArray
from schemas.diagnostics import InvalidInput, Location, finding
from schemas.mechanism import Mechanism
from schemas.physics import CollisionShape, Contact, MassProperties, RigidBody
from usdio.contact_material import bound_contact_material
from usdio.reread.mechanism import filtered_pairs, reread_mechanism
from usdio.reread.one_body import one_body
from usdio.stage import open_stage

_AXES = {"X": np.array([1.0, 0.0, 0.0]), "Y": np.array([0.0, 1.0, 0.0]), "Z": np.array([0.0, 0.0, 1.0])}


@dataclass(frozen=True)
class Linkage:
    """An articulated package: `mechanism` in the asset frame, `links` its bodies in their own frames, in its order."""

    name: str
    mechanism: Mechanism
    links: tuple[RigidBody, ...]

    def held(self, positions: Mapping[str, float] | None = None) -> RigidBody:
        """The object as one rigid body in the asset frame, its joints held at `positions` (m, rad; those without one
        follow another joint or are at rest); without any it is as at rest."""
        if positions:
            frames = link_frames(self.mechanism, positions)
        else:
            frames = {link.name: pose(None, link.origin) for link in self.mechanism.links}
        return one_body(self.name, [(body, frames[body.name]) for body in self.links])


@dataclass(frozen=True)
class RereadPackage:
    """One package as its USD files hold it, in the asset frame, metres and kilograms.

    `shape_contacts` has the contact of each shape of `body`; `visual_points` (n, 3) float64 and `visual_triangles`
    (m, 3) int32 are all rendered meshes merged. Of an articulated object `linkage` has the joints and the bodies of its
    links, `filtered_pairs` links that do not collide beside those that a joint connects; `body` is then the object with
    its joints held at rest.
    """

    body: RigidBody
    shape_contacts: tuple[Contact, ...]
    visual_points: FloatArray
    visual_triangles: IntArray
    linkage: Linkage | None = None
    filtered_pairs: tuple[tuple[str, str], ...] = ()

    @property
    def mechanism(self) -> Mechanism | None:
        """The joints of an articulated object."""
        return None if self.linkage is None else self.linkage.mechanism

    @property
    def links(self) -> tuple[RigidBody, ...]:
        """The bodies of the links of an articulated object, each in its own frame, in the order of the mechanism."""
        return () if self.linkage is None else self.linkage.links

    @property
    def bodies(self) -> tuple[RigidBody, ...]:
        """The bodies that move: the links, or the rigid object itself."""
        return self.links or (self.body,)


def reread_package(main_file: Path) -> RereadPackage:
    """All that `reread_body`, `reread_shape_contacts` and `reread_visual` give, from one opening. Raises as they do."""
    stage = open_stage(main_file)
    if len(_bodies(stage)) < 2:
        prim = _single_body(stage, main_file)
        return RereadPackage(body_of(prim, main_file), _shape_contacts(prim, main_file), *_visual(stage))
    linkage, ordered = _linkage(stage, main_file)
    contacts = tuple(c for prim in ordered for c in _shape_contacts(prim, main_file))
    return RereadPackage(linkage.held(), contacts, *_visual(stage), linkage, filtered_pairs(ordered))


def reread_linkage(main_file: Path) -> Linkage:
    """Links and joints of an articulated package. Raises InvalidInput (`asset/package-invalid`) as `reread_body`."""
    stage = open_stage(main_file)  # Held: prims end with their stage.
    return _linkage(stage, main_file)[0]


def _linkage(stage: Usd.Stage, main_file: Path) -> tuple[Linkage, list[Usd.Prim]]:
    # The linkage of a stage, and the prims of its links in the same order.
    prims = _bodies(stage)
    mechanism = reread_mechanism(stage, prims, main_file)
    by_name = {prim.GetName(): prim for prim in prims}
    ordered = [by_name[link.name] for link in mechanism.links]
    links = tuple(body_of(prim, main_file) for prim in ordered)
    return Linkage(stage.GetDefaultPrim().GetName(), mechanism, links), ordered


def _bodies(stage: Usd.Stage) -> list[Usd.Prim]:
    return [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]


def reread_body(main_file: Path) -> RigidBody:
    """The one rigid body of a package in the frame of its prim (the asset frame), metres and kilograms.

    Inertia is rebuilt as `R diag(diagonalInertia) R^T` with R from `principalAxes` (UsdPhysics schema). Raises
    InvalidInput (`asset/package-invalid`) when the file has no body, no complete mass or an unknown collider type.
    """
    stage = open_stage(main_file)  # Held: prims end with their stage.
    return body_of(_single_body(stage, main_file), main_file)


def body_of(body: Usd.Prim, main_file: Path) -> RigidBody:
    """The rigid body at the prim `body`, in its frame and without its scale. Raises as `reread_body` does."""
    return RigidBody(body.GetName(), shapes_of(body, main_file), _mass(body, main_file), contact_of(body, main_file))


def shapes_of(body: Usd.Prim, main_file: Path) -> tuple[CollisionShape, ...]:
    """The collision shapes that belong to `body`, in its frame. Raises InvalidInput for an unknown collider type."""
    return tuple(_shape(prim, body, main_file) for prim in collider_prims(body))


def reread_shape_contacts(main_file: Path) -> tuple[Contact, ...]:
    """The contact of each shape of `reread_body`, in the same order. Raises as that does."""
    stage = open_stage(main_file)
    return _shape_contacts(_single_body(stage, main_file), main_file)


def reread_visual(main_file: Path) -> tuple[FloatArray, IntArray]:
    """All rendered meshes merged, in the asset frame: points (n, 3) float64 and triangles (m, 3) int32."""
    return _visual(open_stage(main_file))


def _single_body(stage: Usd.Stage, main_file: Path) -> Usd.Prim:
    bodies = _bodies(stage)
    if len(bodies) != 1:
        raise _invalid(f"{len(bodies)} rigid bodies instead of one", main_file)
    return bodies[0]


def _shape_contacts(body: Usd.Prim, main_file: Path) -> tuple[Contact, ...]:
    bound = [bound_contact_material(prim) for prim in collider_prims(body)]
    if any(api is None for api in bound):
        raise _invalid("a collider without a contact material", main_file)
    return tuple(_contact_of(api) for api in bound if api is not None)


def _visual(stage: Usd.Stage) -> tuple[FloatArray, IntArray]:
    root = stage.GetDefaultPrim()
    points, triangles, offset = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int32)], 0
    for prim in visible_meshes(stage):
        mesh = UsdGeom.Mesh(prim)
        local = np.asarray(mesh.GetPointsAttr().Get(), dtype=np.float64).reshape(-1, 3)
        points.append(apply(pose_in(prim, root), local))
        triangles.append(_triangles(mesh) + np.int32(offset))
        offset += len(local)
    return np.concatenate(points), np.concatenate(triangles)


def visible_meshes(stage: Usd.Stage) -> list[Usd.Prim]:
    """Mesh prims a final render draws: purpose default or render."""
    drawn = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)
    meshes = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    return [prim for prim in meshes if UsdGeom.Imageable(prim).ComputePurpose() in drawn]


def collider_prims(body: Usd.Prim) -> list[Usd.Prim]:
    """Enabled collider prims that belong to `body`: below it, or itself, and not below another body."""
    colliders: list[Usd.Prim] = []
    prims = iter(Usd.PrimRange(body))
    for prim in prims:
        if prim != body and prim.HasAPI(UsdPhysics.RigidBodyAPI):
            prims.PruneChildren()
        elif prim.HasAPI(UsdPhysics.CollisionAPI) and UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Get():
            colliders.append(prim)
    return colliders


def pose_in(prim: Usd.Prim, ancestor: Usd.Prim) -> FloatArray:
    """(4, 4) transform from `prim` to `ancestor`, for column vectors (USD uses row vectors); scale included."""
    cache = UsdGeom.XformCache()
    to_world = cache.GetLocalToWorldTransform(prim)
    return np.array(to_world * cache.GetLocalToWorldTransform(ancestor).GetInverse()).T


def _shape(prim: Usd.Prim, body: Usd.Prim, main_file: Path) -> CollisionShape:
    X_AS = pose_in(prim, body)
    scale = np.linalg.norm(X_AS[:3, :3], axis=0)
    rigid = X_AS.copy()
    rigid[:3, :3] /= scale
    radial = float(scale[0])
    if prim.IsA(UsdGeom.Mesh):
        mesh = UsdGeom.Mesh(prim)
        points = apply(X_AS, np.asarray(mesh.GetPointsAttr().Get(), dtype=np.float64).reshape(-1, 3))
        return CollisionShape("hull", (), np.eye(4), points, _triangles(mesh))
    if prim.IsA(UsdGeom.Cube):
        edge = UsdGeom.Cube(prim).GetSizeAttr().Get()
        return CollisionShape("box", tuple(float(v) for v in edge * scale), rigid)
    if prim.IsA(UsdGeom.Sphere):
        return CollisionShape("sphere", (UsdGeom.Sphere(prim).GetRadiusAttr().Get() * radial,), rigid)
    if prim.IsA(UsdGeom.Capsule) or prim.IsA(UsdGeom.Cylinder):
        kind, schema = ("capsule", UsdGeom.Capsule) if prim.IsA(UsdGeom.Capsule) else ("cylinder", UsdGeom.Cylinder)
        gprim = schema(prim)
        size = (gprim.GetRadiusAttr().Get() * radial, gprim.GetHeightAttr().Get() * radial)
        rigid[:3, :3] = rigid[:3, :3] @ shortest_rotation(_AXES["Z"], _AXES[str(gprim.GetAxisAttr().Get())])
        return CollisionShape(kind, size, rigid)
    raise _invalid(f"a collider of type {prim.GetTypeName()}", main_file, prim)


def _mass(body: Usd.Prim, main_file: Path) -> MassProperties:
    if not body.HasAPI(UsdPhysics.MassAPI):
        raise _invalid("a body without mass", main_file, body)
    api = UsdPhysics.MassAPI(body)
    axes = api.GetPrincipalAxesAttr().Get()
    quat_wxyz = np.array([axes.GetReal(), *axes.GetImaginary()], dtype=np.float64)
    if not np.any(quat_wxyz):
        raise _invalid("a body without principal axes of inertia", main_file, body)
    moments = np.asarray(api.GetDiagonalInertiaAttr().Get(), dtype=np.float64)
    centre = np.asarray(api.GetCenterOfMassAttr().Get(), dtype=np.float64)
    return MassProperties(float(api.GetMassAttr().Get()), centre, inertia_from_principal(moments, quat_wxyz))


def contact_of(body: Usd.Prim, main_file: Path) -> Contact:
    """The contact material of the colliders of `body`; of several the first authored, which is the largest part's."""
    bound = [api for prim in collider_prims(body) if (api := bound_contact_material(prim)) is not None]
    if not bound:
        raise _invalid("no collider with a contact material", main_file)
    return _contact_of(first_authored(bound))


def first_authored(materials: Sequence[UsdPhysics.MaterialAPI]) -> UsdPhysics.MaterialAPI:
    """Of contact materials the first one among the siblings of the first."""
    siblings = [prim.GetPath() for prim in materials[0].GetPrim().GetParent().GetChildren()]
    return min(
        materials,
        key=lambda material: siblings.index(path) if (path := material.GetPath()) in siblings else len(siblings),
    )


def _contact_of(api: UsdPhysics.MaterialAPI) -> Contact:
    return Contact(
        static_friction=api.GetStaticFrictionAttr().Get(),
        dynamic_friction=api.GetDynamicFrictionAttr().Get(),
        restitution=api.GetRestitutionAttr().Get(),
        combine=api.GetPrim().GetCustomDataByKey("mana:combine") or "average",
    )


def _triangles(mesh: UsdGeom.Mesh) -> IntArray:
    """(m, 3) int32; Mana's writer only authors triangles."""
    return np.asarray(mesh.GetFaceVertexIndicesAttr().Get(), dtype=np.int32).reshape(-1, 3)


def _invalid(content: str, main_file: Path, prim: Usd.Prim | None = None) -> InvalidInput:
    where = Location(file=main_file.name, prim=None if prim is None else str(prim.GetPath()))
    return InvalidInput(finding("asset/package-invalid", f"the package holds {content}", where=where))
