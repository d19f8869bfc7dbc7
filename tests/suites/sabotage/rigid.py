"""Kinds of damage to rigid packages. Each function edits a victim and is False where there is nothing to damage.

Amounts are drawn by the victim's generator. Nothing of acceptance is imported here.
"""

from __future__ import annotations

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics, Vt
from scipy.spatial import ConvexHull

from tests.suites.sabotage.package import Victim, evidence_values


def heavy(victim: Victim) -> bool:
    """Mass and inertia 60 to 150 times as large."""
    return _times_mass(victim, victim.random.uniform(60.0, 150.0))


def light(victim: Victim) -> bool:
    """Mass and inertia a few thousandths."""
    return _times_mass(victim, 1.0 / victim.random.uniform(200.0, 500.0))


def _times_mass(victim: Victim, factor: float) -> bool:
    for body in victim.bodies:
        api = UsdPhysics.MassAPI(body)
        api.GetMassAttr().Set(api.GetMassAttr().Get() * factor)
        api.GetDiagonalInertiaAttr().Set(api.GetDiagonalInertiaAttr().Get() * factor)
    return True


def slippery(victim: Victim) -> bool:
    """Friction of a hundredth; the combination rule takes the least."""
    friction = victim.random.uniform(0.005, 0.02)
    for material in victim.materials:
        api = UsdPhysics.MaterialAPI(material)
        api.GetStaticFrictionAttr().Set(friction)
        api.GetDynamicFrictionAttr().Set(friction)
        material.SetCustomDataByKey("mana:combine", "minimum")
    return bool(victim.materials) and "manipulated" in victim.roles and bool(victim.grasps)


def mass_centre_aside(victim: Victim) -> bool:
    """The mass centre near one end of the longest edge, still inside the box."""
    return _move_centre(victim, victim.random.uniform(0.85, 0.95)) and bool(victim.grasps)


def mass_centre_outside(victim: Victim) -> bool:
    """The mass centre well outside the box."""
    return _move_centre(victim, victim.random.uniform(1.5, 3.0))


def _move_centre(victim: Victim, share: float) -> bool:
    api = UsdPhysics.MassAPI(victim.bodies[0])
    centre = np.array(api.GetCenterOfMassAttr().Get())
    axis = int(np.argmax(victim.extent_m[:2]))
    centre[axis] = victim.random.choice([-1.0, 1.0]) * share * 0.5 * victim.extent_m[axis]
    api.GetCenterOfMassAttr().Set(Gf.Vec3f(*centre.tolist()))
    return True


def wild_inertia(victim: Victim) -> bool:
    """Moments of inertia hundreds of times as large, as of millimetres taken for metres."""
    factor = victim.random.uniform(300.0, 3000.0)
    for body in victim.bodies:
        attribute = UsdPhysics.MassAPI(body).GetDiagonalInertiaAttr()
        attribute.Set(attribute.Get() * factor)
    return True


def impossible_inertia(victim: Victim) -> bool:
    """One moment larger than the sum of the others."""
    attribute = UsdPhysics.MassAPI(victim.bodies[0]).GetDiagonalInertiaAttr()
    moments = np.array(attribute.Get())
    moments[2] = victim.random.uniform(2.5, 5.0) * (moments[0] + moments[1])
    attribute.Set(Gf.Vec3f(*moments.tolist()))
    return True


def colliders_moved(victim: Victim) -> bool:
    """All colliders a quarter to a half of the size aside."""
    offset = np.zeros(3)
    offset[int(victim.random.integers(2))] = victim.random.uniform(0.25, 0.5) * victim.size_m
    for collider in victim.colliders:
        victim.transform(collider, offset)
    return True


def colliders_grown(victim: Victim) -> bool:
    """All colliders a third to twice larger about their common middle."""
    factor = victim.random.uniform(1.35, 2.0)
    points = np.concatenate([victim.points_of(c) for c in victim.colliders])
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    for collider in victim.colliders:
        own = victim.points_of(collider)
        own_middle = 0.5 * (own.min(axis=0) + own.max(axis=0))
        victim.transform(collider, (factor - 1.0) * (own_middle - middle), factor)
    return True


def inside_out(victim: Victim) -> bool:
    """One hull with its faces turned round."""
    hulls = [c for c in victim.colliders if c.IsA(UsdGeom.Mesh)]
    if not hulls:
        return False
    mesh = UsdGeom.Mesh(hulls[int(victim.random.integers(len(hulls)))])
    faces = np.asarray(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)[:, ::-1]
    mesh.GetFaceVertexIndicesAttr().Set(Vt.IntArray.FromNumpy(np.ascontiguousarray(faces.ravel())))
    return True


def dented(victim: Victim) -> bool:
    """One point of a hull pulled into its middle."""
    hulls = [c for c in victim.colliders if c.IsA(UsdGeom.Mesh)]
    if not hulls:
        return False
    mesh = UsdGeom.Mesh(max(hulls, key=lambda c: np.ptp(victim.points_of(c), axis=0).prod()))
    points = np.asarray(mesh.GetPointsAttr().Get(), dtype=np.float32).copy()
    chosen = int(victim.random.integers(len(points)))
    points[chosen] = 0.3 * points[chosen] + 0.7 * points.mean(axis=0)
    mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points))
    return True


def half_missing(victim: Victim) -> bool:
    """The colliders on one side of the object are gone."""
    if len(victim.colliders) < 3:
        return False
    axis = int(np.argmax(victim.extent_m))
    middles = {c.GetPath(): victim.points_of(c).mean(axis=0)[axis] for c in victim.colliders}
    order = sorted(victim.colliders, key=lambda c: middles[c.GetPath()])
    for collider in order[: len(order) // 2]:
        victim.remove(collider)
    return True


def cavity_filled(victim: Victim) -> bool:
    """All colliders but one gone, that one the hull of all: what holds things is full."""
    hulls = [c for c in victim.colliders if c.IsA(UsdGeom.Mesh)]
    if not hulls or len(victim.colliders) < 2 or not victim.anchors("volume"):
        return False
    points = np.concatenate([victim.points_of(c) for c in victim.colliders])
    corners = points[ConvexHull(points).vertices]
    corners = corners[victim.random.permutation(len(corners))[:60]] if len(corners) > 60 else corners
    hull = ConvexHull(corners)
    corners = corners[hull.vertices]
    hull = ConvexHull(corners)
    outward = np.einsum(
        "ij,ij->i", np.cross(corners[hull.simplices[:, 1]] - corners[hull.simplices[:, 0]],
                             corners[hull.simplices[:, 2]] - corners[hull.simplices[:, 0]]), hull.equations[:, :3]
    )  # fmt: skip
    faces = np.where((outward < 0.0)[:, None], hull.simplices[:, ::-1], hull.simplices)
    only = UsdGeom.Mesh(hulls[0])
    only.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(corners.astype(np.float32)))
    only.GetFaceVertexIndicesAttr().Set(Vt.IntArray.FromNumpy(faces.astype(np.int32).ravel()))
    only.GetFaceVertexCountsAttr().Set(Vt.IntArray.FromNumpy(np.full(len(faces), 3, np.int32)))
    only.GetExtentAttr().Set(
        Vt.Vec3fArray.FromNumpy(np.stack([corners.min(axis=0), corners.max(axis=0)]).astype(np.float32))
    )
    only.GetNormalsAttr().Block()
    UsdGeom.PrimvarsAPI(only).BlockPrimvar("normals")
    for collider in victim.colliders:
        if collider != only.GetPrim():
            victim.remove(collider)
    return True


def floor_missing(victim: Victim) -> bool:
    """The colliders under the middle of a containment volume are gone."""
    under = _under_volume(victim)
    for collider in under:
        victim.remove(collider)
    return bool(under)


def _under_volume(victim: Victim) -> list[Usd.Prim]:
    """The colliders under the middle of the first volume; none where these are all, or there is no volume."""
    volumes = victim.anchors("volume")
    if not volumes or len(victim.colliders) < 3:
        return []
    x, y, z = volumes[0]["position_m"]
    above = z + np.array([0.02, 0.1]) * victim.size_m
    under = []
    for collider in victim.colliders:
        points = victim.points_of(collider)
        low, high = points.min(axis=0), points.max(axis=0)
        covers = np.all(low[:2] <= (x, y)) and np.all(high[:2] >= (x, y))
        if covers and low[2] < above[0] and high[2] < above[1]:
            under.append(collider)
    return under if len(under) < len(victim.colliders) else []


def floor_thinned(victim: Victim) -> bool:
    """The colliders under the middle of a receptacle are a sheet of a tenth of a millimetre: a shell."""
    under = _under_volume(victim) if "receptacle" in victim.roles else []
    for collider in under:
        top = float(victim.points_of(collider)[:, 2].max())
        _flatten(victim, collider, top, victim.random.uniform(0.5e-4, 1.5e-4))
    return bool(under)


def _flatten(victim: Victim, collider: Usd.Prim, top_m: float, thickness_m: float) -> None:
    """Squash a collider along z of its body, its top where it was."""
    points = victim.points_of(collider)
    factor = thickness_m / float(np.ptp(points[:, 2]))
    matrix = Gf.Matrix4d(1.0).SetScale(Gf.Vec3d(1.0, 1.0, factor)) * Gf.Matrix4d(1.0).SetTranslate(
        Gf.Vec3d(0.0, 0.0, top_m * (1.0 - factor))
    )
    xform = UsdGeom.Xformable(collider)
    before = xform.GetLocalTransformation()
    xform.ClearXformOpOrder()
    xform.AddTransformOp(opSuffix="sabotage").Set(before * matrix)


def anchor_raised(victim: Victim) -> bool:
    """Volumes and surfaces on record lie in the air above the object."""
    lift = victim.random.uniform(0.6, 1.2) * victim.size_m
    anchors = [*victim.anchors("volume"), *victim.anchors("surface")]
    for anchor in anchors:
        anchor["position_m"][2] += lift
    return bool(anchors)


def bump_on_support(victim: Victim) -> bool:
    """A thin post stands in the middle of every support surface."""
    surfaces = victim.anchors("surface")
    if not surfaces:
        return False
    for number, surface in enumerate(surfaces):
        x, y, z = surface["position_m"]
        height = victim.random.uniform(0.02, 0.04) * victim.size_m
        edges = np.array([0.006 * victim.size_m, 0.006 * victim.size_m, height])
        victim.add_box(victim.bodies[0], f"bump_{number}", np.array([x, y, z + 0.5 * height]), edges)
    return True


def foot_ridge(victim: Victim) -> bool:
    """A narrow ridge below the foot: the object balances on it."""
    height = victim.random.uniform(0.02, 0.04) * victim.size_m
    edges = np.array([0.01 * victim.size_m, 0.5 * victim.extent_m[1], height])
    victim.add_box(victim.bodies[0], "ridge", np.array([0.0, 0.0, -0.5 * height]), edges)
    return True


def grasp_aside(victim: Victim) -> bool:
    """Grasps on record lie beside the object."""
    offset = victim.random.uniform(0.6, 1.5) * victim.size_m
    direction = victim.random.choice([-1.0, 1.0])
    for grasp in victim.grasps:
        grasp["position_m"][int(np.argmin(victim.extent_m[:2]))] += direction * (offset + 0.05)
    return bool(victim.grasps) and "manipulated" in victim.roles


def grasp_narrow(victim: Victim) -> bool:
    """The pads of grasps on record start inside the object."""
    share = victim.random.uniform(0.3, 0.6)
    for grasp in victim.grasps:
        grasp["opening_m"] = share * grasp["width_m"]
    return bool(victim.grasps) and "manipulated" in victim.roles


def grasp_weak(victim: Victim) -> bool:
    """Grasps on record press with a twentieth of what holds."""
    share = victim.random.uniform(0.02, 0.06)
    for grasp in victim.grasps:
        grasp["force_n"] *= share
    return bool(victim.grasps) and "manipulated" in victim.roles


def no_contact_material(victim: Victim) -> bool:
    """Colliders without a contact material: neither of their own, nor one that they inherit."""
    for collider in victim.colliders:
        for prim in (collider, *_above(collider)):
            for relationship in prim.GetRelationships():
                if relationship.GetName() in ("material:binding", "material:binding:physics"):
                    relationship.SetTargets([])
    return bool(victim.colliders)


def _above(prim: Usd.Prim) -> list[Usd.Prim]:
    parent = prim.GetParent()
    return [] if parent.IsPseudoRoot() else [parent, *_above(parent)]


def friction_reversed(victim: Victim) -> bool:
    """Dynamic friction above static friction."""
    for material in victim.materials:
        api = UsdPhysics.MaterialAPI(material)
        api.GetDynamicFrictionAttr().Set(api.GetStaticFrictionAttr().Get() * victim.random.uniform(2.0, 4.0))
    return bool(victim.materials)


def wrong_extent(victim: Victim) -> bool:
    """The record has another size than the surface, as after a change of units."""
    factor = float(victim.random.choice([0.01, 0.1, 2.54, 10.0, 100.0]))
    extent = victim.record["geometry"]["extent_m"]
    extent["value"] = [factor * edge for edge in extent["value"]]
    return True


def wrong_pose(victim: Victim) -> bool:
    """Stable poses on record stand on an edge."""
    for pose in evidence_values({"poses": victim.record["acceptance"]["stable_poses"]}, "poses"):
        half = 0.5 * victim.random.uniform(0.4, 0.7)
        pose["quat_wxyz"] = [float(np.cos(half)), float(np.sin(half)), 0.0, 0.0]
    return bool(victim.record["acceptance"]["stable_poses"]) and "manipulated" in victim.roles and bool(victim.grasps)
