"""Defects of bodies: transforms, flags, mass, mass centre, inertia."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from pxr import Gf, UsdPhysics

from tests.suites.gate.edits import (
    BASE,
    DOOR,
    DRAWER,
    HULL,
    INF,
    NAN,
    PROP,
    PROP_MATERIAL,
    TYPES,
    Defect,
    Sound,
    both,
    cabinet,
    heavier,
    on_prim,
    permute_inertia,
    place,
    prop,
    put,
    skew_inertia,
    times,
    unapply,
)

INERTIA, AXES, CENTRE = "physics:diagonalInertia", "physics:principalAxes", "physics:centerOfMass"

DEFECTS: tuple[Defect, ...] = (
    cabinet("transform with NaN", place(DOOR, (NAN, 0, 0)), "transform"),
    cabinet("orientation of zeros", put(f"{BASE}/Colliders/collider_00", "xformOp:orient", Gf.Quatd(0.0)), "transform"),
    prop("colliders flattened", place(f"{PROP}/Colliders", scale=(1, 1, 0)), "transform"),
    prop("scaled body", place(PROP, scale=(2, 2, 2)), "body-scale"),
    cabinet("body scaled unevenly", place(DRAWER, scale=(1, 1.3, 1)), "body-scale"),
    prop("mirrored body", place(PROP, scale=(-1, 1, 1)), "body-scale"),
    prop("body in a body", on_prim(f"{PROP}/Visuals", UsdPhysics.RigidBodyAPI.Apply), "nested-body"),
    prop("kinematic prop", put(PROP, "physics:kinematicEnabled", True), "body-flags"),
    cabinet("kinematic drawer", put(DRAWER, "physics:kinematicEnabled", True), "body-flags"),
    prop("disabled body", put(PROP, "physics:rigidBodyEnabled", False), "body-flags"),
    prop("asleep at the start", put(PROP, "physics:startsAsleep", True), "body-flags"),
    prop("no gravity", put(PROP, "physxRigidBody:disableGravity", True, TYPES.Bool), "body-flags"),
    cabinet("locked rotation", put(DOOR, "physxRigidBody:lockedRotAxis", 7, TYPES.Int), "body-flags"),
    cabinet("negative damping", put(DOOR, "physxRigidBody:linearDamping", -1.0, TYPES.Float), "body-flags"),
    prop("thrown prop", put(PROP, "physics:velocity", Gf.Vec3f(0, 0, 3)), "velocity"),
    prop("spinning with NaN", put(PROP, "physics:angularVelocity", Gf.Vec3f(NAN, 0, 0)), "velocity"),
    prop("negative mass", put(PROP, "physics:mass", -1.0), "mass"),
    cabinet("zero mass", put(DRAWER, "physics:mass", 0.0), "mass"),
    prop("NaN mass", put(PROP, "physics:mass", NAN), "mass"),
    cabinet("infinite mass", put(BASE, "physics:mass", INF), "mass"),
    prop("mass API removed", unapply(PROP, UsdPhysics.MassAPI), "mass"),
    prop(
        "mass on a collider too",
        on_prim(HULL, lambda p: UsdPhysics.MassAPI.Apply(p).CreateMassAttr(3.0)),
        "mass-twice",
    ),
    cabinet(
        "density beside mass", on_prim(DOOR, lambda p: UsdPhysics.MassAPI(p).CreateDensityAttr(9000.0)), "mass-twice"
    ),
    prop("500 times too heavy", heavier(PROP, 500.0), "density"),
    prop("1000 times too light", heavier(PROP, 1e-3), "density"),
    cabinet("drawer 100 times too heavy", heavier(DRAWER, 100.0), "density"),
    prop("5 times too heavy for wood", heavier(PROP, 5.0), "density-stated"),
    prop("material density in g/cm3", put(PROP_MATERIAL, "physics:density", 0.5), "density-stated"),
    prop("negative material density", put(PROP_MATERIAL, "physics:density", -500.0), "density-stated"),
    prop("mass 20 % off the record", heavier(PROP, 1.2), "record"),
    prop("density off the record", put(PROP_MATERIAL, "physics:density", 5000.0), "record"),
    prop("friction off the record", put(PROP_MATERIAL, "physics:staticFriction", 0.9), "record"),
    prop("negative inertia", times(PROP, INERTIA, -1.0), "inertia"),
    cabinet("zero inertia about one axis", put(DOOR, INERTIA, Gf.Vec3f(0, 0.1, 0.1)), "inertia"),
    prop("inertia of no real body", skew_inertia, "inertia"),
    prop("NaN inertia", put(PROP, INERTIA, Gf.Vec3f(NAN, 1, 1)), "inertia"),
    prop("no inertia", both(put(PROP, INERTIA, Gf.Vec3f(0)), put(PROP, AXES, Gf.Quatf(0.0))), "inertia"),
    prop("principal axes of length 0.5", put(PROP, AXES, Gf.Quatf(0.5, 0, 0, 0)), "inertia"),
    prop("principal axes of zeros", put(PROP, AXES, Gf.Quatf(0.0)), "inertia"),
    cabinet("inertia times 100", times(DRAWER, INERTIA, 100.0), "inertia-scale"),
    cabinet("inertia over 100", times(DOOR, INERTIA, 0.01), "inertia-scale"),
    prop("inertia times 10", times(PROP, INERTIA, 10.0), "inertia-scale"),
    prop("inertia over 10", times(PROP, INERTIA, 0.1), "inertia-scale"),
    prop("inertia in g cm2", times(PROP, INERTIA, 1e7), "inertia-scale"),
    prop("inertia times 10 for its size", times(PROP, INERTIA, 10.0), "inertia-reach"),
    cabinet("inertia of the door times 5", times(DOOR, INERTIA, 5.0), "inertia-reach"),
    prop("inertia times 2.5", times(PROP, INERTIA, 2.5), "inertia-scale", "warning"),
    prop("inertia over 3", times(PROP, INERTIA, 1.0 / 3.0), "inertia-scale", "warning"),
    cabinet("inertia along other axes", permute_inertia, "inertia-scale"),
    prop("mass centre outside", put(PROP, CENTRE, Gf.Vec3f(0, 0, 0.2)), "mass-centre-outside"),
    cabinet("mass centre in the asset frame", put(DOOR, CENTRE, Gf.Vec3f(0.2, 0, 0.25)), "mass-centre-outside"),
    prop("mass centre in a corner", put(PROP, CENTRE, Gf.Vec3f(0.045, 0.035, 0.01)), "mass-centre-far", "warning"),
    prop("mass centre 2 mm aside", put(PROP, CENTRE, Gf.Vec3f(0.002, 0, 0.03)), "twin"),
    prop("mass 2 % off the twin", heavier(PROP, 1.02), "twin"),
    prop("mass centre aside within the hull", put(PROP, CENTRE, Gf.Vec3f(0.03, 0, 0.03)), "mass-centre-far", "warning"),
    cabinet("mass centre at the origin", put(DOOR, CENTRE, Gf.Vec3f(0)), "mass-centre-far", "warning"),
    prop("NaN mass centre", put(PROP, CENTRE, Gf.Vec3f(0, NAN, 0)), "mass-centre-outside"),
)

SOUND: tuple[Sound, ...] = (
    Sound("a little damping", "prop", put(PROP, "physxRigidBody:angularDamping", 0.05, TYPES.Float)),
)
