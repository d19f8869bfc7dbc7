"""Defects of colliders and contact materials."""

from __future__ import annotations

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from tests.suites.gate.edits import (
    BASE,
    CABINET,
    DOOR,
    DRAWER,
    HULL,
    NAN,
    PROP,
    PROP_MATERIAL,
    TYPES,
    Defect,
    Sound,
    both,
    cabinet,
    each_collider,
    on_prim,
    place,
    points,
    prop,
    put,
    target,
    unapply,
)

BACK = f"{BASE}/Colliders/collider_05"
WOOD = f"{CABINET}/PhysicsMaterials/wood"
STATIC, DYNAMIC, RESTITUTION = "physics:staticFriction", "physics:dynamicFriction", "physics:restitution"


def _disable(prim: object) -> None:
    UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Set(False)


def _plate_over_the_drawer(stage: Usd.Stage) -> None:
    """One more box collider, across the drawer's opening."""
    plate = UsdGeom.Cube.Define(stage, f"{DRAWER}/Colliders/plate")
    plate.CreateSizeAttr(1.0)
    plate.CreatePurposeAttr("guide")
    plate.AddTranslateOp().Set(Gf.Vec3d(0.0, 0.0, 0.67))
    plate.AddScaleOp().Set(Gf.Vec3f(0.3, 0.3, 0.01))
    UsdPhysics.CollisionAPI.Apply(plate.GetPrim())


DEFECTS: tuple[Defect, ...] = (
    prop("colliders disabled", each_collider(PROP, _disable), "no-collider"),
    cabinet(
        "collision API removed", each_collider(DOOR, lambda p: p.RemoveAPI(UsdPhysics.CollisionAPI)), "no-collider"
    ),
    cabinet("colliders deleted", lambda s: s.RemovePrim(f"{DRAWER}/Colliders"), "no-collider"),
    cabinet("one collider disabled", put(BACK, "physics:collisionEnabled", False), "no-collider"),
    prop("triangle-mesh collider", put(HULL, "physics:approximation", "none"), "collider-not-convex"),
    prop("simplified-mesh collider", put(HULL, "physics:approximation", "meshSimplification"), "collider-not-convex"),
    prop("signed-distance collider", put(HULL, "physics:approximation", "sdf"), "collider-not-convex"),
    prop("mesh collision API removed", unapply(HULL, UsdPhysics.MeshCollisionAPI), "collider-not-convex"),
    prop("flat hull", points(HULL, lambda p: p * [1, 1, 0]), "collider-shape"),
    prop("dented hull", points(HULL, lambda p: np.concatenate([p, [[0.0, 0.0, 0.03]]])), "collider-shape"),
    cabinet("collider of size zero", put(f"{DOOR}/Colliders/collider_00", "size", 0.0), "collider-shape"),
    prop("collider 2 cm aside", place(f"{PROP}/Colliders", (0.02, 0, 0)), "collider-displaced"),
    prop("colliders 2.5 mm aside", place(f"{PROP}/Colliders", (0, 0.0025, 0)), "collider-displaced", "warning"),
    cabinet("colliders 3 cm too low", place(f"{BASE}/Colliders", (0, 0, -0.03)), "collider-displaced"),
    prop("colliders 20 % larger", place(f"{PROP}/Colliders", scale=(1.2, 1.2, 1.2)), "collider-displaced"),
    cabinet("colliders at half size", place(f"{DRAWER}/Colliders", scale=(0.5, 0.5, 0.5)), "collider-displaced"),
    cabinet("colliders turned", place(f"{DOOR}/Colliders", rotate=(0, 0, 20)), "collider-displaced"),
    cabinet("back wall without collider", lambda s: s.RemovePrim(BACK), "collider-incomplete"),
    cabinet("one collider moved", place(f"{BASE}/Colliders/collider_03", (0, 0, -0.2)), "collider-incomplete"),
    cabinet("plate across the drawer", _plate_over_the_drawer, "collider-cavity", "warning"),
    cabinet(
        "drawer without floor", lambda s: s.RemovePrim(f"{DRAWER}/Colliders/collider_00"), "collider-cavity", "warning"
    ),
    cabinet("side wall's collider lifted", place(f"{BASE}/Colliders/collider_00", (0, 0, 0.1)), "collider-astray"),
    prop("hull 2 cm up", place(HULL, (0, 0, 0.02)), "collider-astray"),
    prop("one of two colliders gone", on_prim(HULL, lambda p: p.SetActive(False)), "record"),
    prop("collider drawn", put(HULL, "purpose", "default"), "collider-rendered"),
    prop(
        "rest offset above contact offset",
        both(
            put(HULL, "physxCollision:contactOffset", 0.01, TYPES.Float),
            put(HULL, "physxCollision:restOffset", 0.02, TYPES.Float),
        ),
        "collision-offset",
    ),
    cabinet("contact offset of 5 m", put(BACK, "physxCollision:contactOffset", 5.0, TYPES.Float), "collision-offset"),
    prop(
        "no contact material",
        both(target(HULL, "material:binding:physics"), target(HULL, "material:binding")),
        "contact-material",
    ),
    prop("contact material without values", unapply(PROP_MATERIAL, UsdPhysics.MaterialAPI), "contact-material"),
    prop("static below dynamic friction", put(PROP_MATERIAL, STATIC, 0.1), "friction"),
    cabinet("dynamic above static friction", put(WOOD, DYNAMIC, 0.9), "friction"),
    prop("negative friction", put(PROP_MATERIAL, DYNAMIC, -0.1), "friction"),
    prop("NaN friction", put(PROP_MATERIAL, STATIC, NAN), "friction"),
    prop("friction 50", both(put(PROP_MATERIAL, STATIC, 50.0), put(PROP_MATERIAL, DYNAMIC, 50.0)), "friction"),
    cabinet("hardly any dynamic friction", put(WOOD, DYNAMIC, 0.004), "friction", "warning"),
    cabinet("smoother than ice", both(put(WOOD, STATIC, 0.0), put(WOOD, DYNAMIC, 0.0)), "friction", "warning"),
    cabinet("filter of a pair that is gone", target(DOOR, "physics:filteredPairs", "/cabinet/lid"), "dangling-target"),
    prop("restitution 1.5", put(PROP_MATERIAL, RESTITUTION, 1.5), "restitution"),
    prop("negative restitution", put(PROP_MATERIAL, RESTITUTION, -0.5), "restitution"),
    cabinet("NaN restitution", put(WOOD, RESTITUTION, NAN), "restitution"),
)

SOUND: tuple[Sound, ...] = (
    Sound("contact offset above rest offset", "prop", put(HULL, "physxCollision:contactOffset", 0.002, TYPES.Float)),
)
