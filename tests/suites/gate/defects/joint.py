"""Defects of joints, drives and articulations."""

from __future__ import annotations

from pxr import Gf, UsdPhysics

from tests.suites.gate.edits import (
    ANCHOR,
    BASE,
    CABINET,
    DOOR,
    DRAWER,
    HINGE,
    INF,
    NAN,
    SLIDE,
    TYPES,
    Defect,
    Sound,
    both,
    cabinet,
    move_link,
    on_prim,
    place,
    put,
    remove,
    second_hinge,
    shift,
    target,
    unapply,
)

LOWER, UPPER = "physics:lowerLimit", "physics:upperLimit"
BODY_0, BODY_1 = "physics:body0", "physics:body1"
P_0, P_1, R_0, R_1 = "physics:localPos0", "physics:localPos1", "physics:localRot0", "physics:localRot1"
HINGE_DRIVE, SLIDE_DRIVE = "drive:angular:physics", "drive:linear:physics"
AWAY, MIDDLE = Gf.Vec3f(0, 2, 0), Gf.Vec3f(0, -0.25, 0)

DEFECTS: tuple[Defect, ...] = (
    cabinet("joint without bodies", both(target(HINGE, BODY_0), target(HINGE, BODY_1)), "joint-bodies"),
    cabinet("joint to a missing prim", target(HINGE, BODY_1, "/cabinet/window"), "joint-bodies"),
    cabinet("joint of one body with itself", target(HINGE, BODY_1, BASE), "joint-bodies"),
    cabinet("joint with two bodies on one side", target(HINGE, BODY_1, DOOR, DRAWER), "joint-bodies"),
    cabinet("hinge to the world", target(HINGE, BODY_0), "joint-bodies"),
    cabinet("joint to a mesh", target(HINGE, BODY_1, f"{DOOR}/Visuals/panel"), "joint-bodies"),
    cabinet("joint of two materials", both(target(SLIDE, BODY_0, CABINET), target(SLIDE, BODY_1)), "joint-bodies"),
    cabinet("axis W", put(HINGE, "physics:axis", "W"), "joint-axis"),
    cabinet("zero quaternion", put(HINGE, R_1, Gf.Quatf(0.0)), "joint-axis"),
    cabinet("quaternion of length 2", put(SLIDE, R_0, Gf.Quatf(2.0)), "joint-axis"),
    cabinet("NaN anchor", put(SLIDE, P_0, Gf.Vec3f(NAN, 0, 0)), "joint-axis"),
    cabinet("hinge limits inverted", both(put(HINGE, LOWER, 110.0), put(HINGE, UPPER, 0.0)), "joint-limits"),
    cabinet("slide limits inverted", put(SLIDE, LOWER, 0.5), "joint-limits"),
    cabinet("hinge limits missing", both(remove(HINGE, LOWER), remove(HINGE, UPPER)), "joint-limits"),
    cabinet("slide limits missing", both(remove(SLIDE, LOWER), remove(SLIDE, UPPER)), "joint-limits"),
    cabinet("one slide limit missing", remove(SLIDE, UPPER), "joint-limits"),
    cabinet("one hinge limit missing", remove(HINGE, LOWER), "joint-limits"),
    cabinet("infinite slide", put(SLIDE, UPPER, INF), "joint-limits"),
    cabinet("NaN limit", put(HINGE, UPPER, NAN), "joint-limits"),
    cabinet("hinge in radians", put(HINGE, UPPER, 1.92), "joint-range", "warning"),
    cabinet("hinge locked", put(HINGE, UPPER, 0.0), "joint-range"),
    cabinet("slide in millimetres", put(SLIDE, UPPER, 300.0), "joint-range"),
    cabinet("slide ten times too long", put(SLIDE, UPPER, 3.0), "joint-range"),
    cabinet("hinge of ten turns", put(HINGE, UPPER, 3600.0), "joint-range", "warning"),
    cabinet("anchor 5 cm off", put(HINGE, P_1, Gf.Vec3f(0, 0, 0.05)), "joint-frames"),
    cabinet("anchor 3 mm off", put(HINGE, P_1, Gf.Vec3f(0, 0.003, 0)), "joint-frames"),
    cabinet("slide off its line", put(SLIDE, P_1, Gf.Vec3f(0, 0.02, 0)), "joint-frames"),
    cabinet("hinge frame tilted", put(HINGE, R_1, Gf.Quatf(0.9962, 0.0872, 0, 0)), "joint-frames"),
    cabinet("slide frame turned", put(SLIDE, R_0, Gf.Quatf(0.7071068, 0, 0, 0.7071068)), "joint-frames"),
    cabinet("axis of one side flipped", put(SLIDE, R_1, Gf.Quatf(0, 0, 0, 1)), "joint-frames"),
    cabinet("link moved, joint left behind", place(DOOR, (0, 0.03, 0)), "joint-frames"),
    cabinet("link turned, joint left behind", place(DRAWER, rotate=(0, 5, 0)), "joint-frames"),
    cabinet("base lifted off its anchor", put(ANCHOR, P_0, Gf.Vec3f(0, 0, 0.1)), "joint-frames"),
    cabinet("door starts beyond its limits", put(HINGE, LOWER, 80.0), "joint-rest"),
    cabinet("drawer starts beyond its limits", put(SLIDE, LOWER, 0.25), "joint-rest"),
    cabinet("hinge 2 m away", both(shift(HINGE, P_0, AWAY), shift(HINGE, P_1, AWAY)), "joint-anchor", "warning"),
    cabinet("drawer sliding sideways", put(SLIDE, "physics:axis", "Y"), "joint-motion", "warning"),
    cabinet(
        "hinge in the middle of the door",
        both(shift(HINGE, P_0, MIDDLE), shift(HINGE, P_1, MIDDLE)),
        "joint-motion",
        "warning",
    ),
    cabinet("joint disabled", put(HINGE, "physics:jointEnabled", False), "joint-flags"),
    cabinet("joint of glass", put(HINGE, "physics:breakForce", 0.0), "joint-flags"),
    cabinet("negative joint friction", put(HINGE, "physxJoint:jointFriction", -0.2, TYPES.Float), "joint-flags"),
    cabinet("negative stiffness", put(HINGE, f"{HINGE_DRIVE}:stiffness", -10.0), "drive"),
    cabinet("infinite damping", put(SLIDE, f"{SLIDE_DRIVE}:damping", INF), "drive"),
    cabinet("infinite stiffness", put(HINGE, f"{HINGE_DRIVE}:stiffness", INF), "drive"),
    cabinet("NaN stiffness", put(SLIDE, f"{SLIDE_DRIVE}:stiffness", NAN), "drive"),
    cabinet("negative drive force", put(SLIDE, f"{SLIDE_DRIVE}:maxForce", -1.0), "drive"),
    cabinet("unknown drive type", put(SLIDE, f"{SLIDE_DRIVE}:type", "magic"), "drive"),
    cabinet(
        "linear drive on a hinge",
        on_prim(HINGE, lambda p: UsdPhysics.DriveAPI.Apply(p, "linear").CreateStiffnessAttr(10.0)),
        "drive",
    ),
    cabinet("drive API removed", unapply(HINGE, UsdPhysics.DriveAPI, "angular"), "drive"),
    cabinet(
        "drive target beyond the limit",
        both(
            put(HINGE, f"{HINGE_DRIVE}:stiffness", 10.0),
            put(HINGE, f"{HINGE_DRIVE}:targetPosition", 200.0, TYPES.Float),
        ),
        "drive",
        "warning",
    ),
    cabinet(
        "drive that turns by itself", put(HINGE, f"{HINGE_DRIVE}:targetVelocity", 90.0, TYPES.Float), "drive", "warning"
    ),
    cabinet("articulation root removed", unapply(CABINET, UsdPhysics.ArticulationRootAPI), "articulation"),
    cabinet("nested articulation root", on_prim(BASE, UsdPhysics.ArticulationRootAPI.Apply), "articulation"),
    cabinet("closed loop", second_hinge, "articulation"),
    cabinet("link joined to nothing", lambda s: s.RemovePrim(HINGE), "articulation"),
    cabinet("drawer pushed through the back", move_link(DRAWER, (-0.06, 0, 0), SLIDE), "links-overlap"),
    cabinet("door inside the carcass", move_link(DOOR, (-0.1, 0, 0), HINGE), "links-overlap"),
    cabinet("drawer inside the door", move_link(DRAWER, (0.015, 0, -0.3), SLIDE), "links-overlap"),
)

SOUND: tuple[Sound, ...] = (Sound("stiffer drive", "cabinet", put(HINGE, "drive:angular:physics:stiffness", 5.0)),)
