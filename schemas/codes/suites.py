"""Diagnostic codes of the suites of acceptance, which exercise what a role promises; part of the table in
`schemas.codes`.
"""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

SUITE_CODES: dict[str, CodeInfo] = {
    # Packages without a record of Mana.
    "asset/foreign-converted": CodeInfo(
        "info",
        "A package of another maker was brought into Mana's frame or shapes",
        "Acceptance works in metres with z up, the origin below the object, and on convex shapes. What the file says "
        "in other words is converted; nothing is added to it.",
        "nothing; the figures in the report are in Mana's frame",
    ),
    "asset/foreign-assumed": CodeInfo(
        "warning",
        "A package of another maker leaves out what acceptance needs",
        "Friction, mass or inertia is not stated, so that each engine takes a value of its own. The finding names the "
        "value that was taken and where it comes from; the result of every suite depends on it.",
        "state the value in the file: a contact material on each collider; mass, mass centre and inertia on the body",
    ),
    "asset/foreign-unsupported": CodeInfo(
        "error",
        "A package of another maker holds what acceptance cannot exercise",
        "It has no body that moves, several without joints, joints of another kind, or a collider that no engine "
        "takes for a moving body.",
        "mend what the finding names, or make a package of the file with `mana assets ingest`",
    ),
    # What is on record.
    "asset/mass-beyond-bounds": CodeInfo(
        "error",
        "A package weighs less or more than its record believes possible",
        "The record states between which values the mass lies. Outside, USD or record was changed after release, and "
        "whoever randomises the mass within these bounds never meets that of the file.",
        "ingest the source again; where the mass is known, state it with --mass",
    ),
    "asset/stable-pose-lost": CodeInfo(
        "error",
        "A stable pose on record does not hold",
        "Scenes set objects down in the poses on record. In this one the object falls over, moves, or rests higher or "
        "lower than it says: its foot, its mass centre or the pose is not what it was.",
        "look at colliders and mass centre, and ingest the source again",
    ),
    "asset/anchor-lost": CodeInfo(
        "error",
        "A surface or volume on record does not hold things",
        "Scenes put things onto the surfaces and into the volumes on record. Here the probes that once stayed do not: "
        "colliders close the opening or are missing, or the place is not where the object is.",
        "look at the colliders and at the anchors in the report, and ingest the source again",
    ),
    # Every object.
    "asset/slope-astray": CodeInfo(
        "warning",
        "On a steep slope the object does not slide, or jumps off",
        "At 45 degrees and a friction of 0.5 everything slides or rolls. What stays has colliders that hook into the "
        "ground, or motion that diverges; what jumps off was pushed out of an overlap.",
        "look at the colliders and the mass in the report",
    ),
    "asset/settling-unrepeatable": CodeInfo(
        "warning",
        "Set down again the object ends elsewhere",
        "With another heading, a lean of one degree, or another step of the engine it falls over or moves on: "
        "scenes with it would not be reproducible.",
        "look at the foot of its colliders and at its mass centre; give it a wider foot, or another reference pose",
    ),
    "asset/role-withdrawn": CodeInfo(
        "info",
        "A role that was inferred is not borne out in simulation",
        "What the object is usually used as is a guess; a package promises only what it was seen to do.",
        "nothing if it is not used so; else state the role with --role, and look at the reasons",
    ),
    # Handling.
    "asset/handling-no-grasp": CodeInfo(
        "warning",
        "No gripper can take an object that is meant to be picked up",
        "It is too wide or too heavy, or no place on it is free for fingers of any size.",
        "check size and mass; if it is not for grasping, state its role with --role",
    ),
    "asset/handling-pushed": CodeInfo(
        "warning",
        "The open hand pushes the object before it closes",
        "Fingers or hand meet the colliders on the way in, so the object is not where the grasp expects it.",
        "look at the colliders around the grasp: they may fill a gap that the visible surface has",
    ),
    "asset/handling-lost": CodeInfo(
        "warning",
        "The gripper loses the object while it lifts, holds, carries or shakes it",
        "A policy would drop it in simulation whatever it does.",
        "check friction and mass against what the object is, and the colliders where the pads touch",
    ),
    "asset/handling-slip": CodeInfo(
        "warning",
        "The object slides between the pads",
        "It is held, but not where it was taken: placing it precisely would fail.",
        "check friction, mass and mass centre",
    ),
    "asset/handling-not-released": CodeInfo(
        "warning",
        "The object does not come off when the pads open",
        "Its colliders hook onto the fingers.",
        "look at the colliders where the pads touch",
    ),
    "asset/handling-landing": CodeInfo(
        "warning",
        "Set down, the object sinks in, tips over or moves on",
        "It does not stay where a gripper puts it.",
        "look at its foot, its mass centre and the colliders there",
    ),
    # Receptacles.
    "asset/receptacle-no-volume": CodeInfo(
        "warning",
        "A receptacle has no volume or surface that holds things",
        "Its role promises that things can be put into it, but no inside was found, or no probe stayed in one: the "
        "opening is closed, or colliders fill the inside; nor is there a surface as that of a plate.",
        "open it in the source, or state its role with --role; look at the colliders over the cavity",
    ),
    "asset/receptacle-leaves": CodeInfo(
        "warning",
        "Things let go above a receptacle do not stay in it",
        "Balls and boxes that pass the opening end beside it or lie on top of it: colliders fill the inside, or a wall "
        "or the floor is missing.",
        "look at the colliders around the volume",
    ),
    "asset/receptacle-tunnel": CodeInfo(
        "warning",
        "Things go through a wall or the floor of a receptacle",
        "A probe that falls in, or is shoved against a wall, comes out other than over the rim: colliders leave a gap, "
        "or are so thin that one step of the engine leads through them.",
        "look at the colliders for gaps; give walls more thickness",
    ),
    "asset/receptacle-spill": CodeInfo(
        "warning",
        "With content in it a receptacle leans or loses some of it",
        "It stands on level ground with as much in it as it is made for, and does not hold still.",
        "look at its foot, its mass and its mass centre",
    ),
    "asset/receptacle-tips": CodeInfo(
        "warning",
        "A receptacle tips over on a slight slope",
        "Empty, or with content in it, it falls over on ground that things of use must stand on.",
        "check mass centre and foot; give it a wider foot or another reference pose",
    ),
    # Supports.
    "asset/support-no-surface": CodeInfo(
        "warning",
        "A support has no surface that holds things",
        "Its role promises that things can be set on it, but no level face was found, or no probe stayed on one.",
        "check which way is up; or state its role with --role",
    ),
    "asset/support-stack": CodeInfo(
        "warning",
        "Boxes set on a support do not stay",
        "A stack at the middle or near the edge of a surface slides, leans or falls: the surface is rough, slanted or "
        "slippery in its colliders.",
        "look at the colliders under the surface and at friction",
    ),
    "asset/support-tips": CodeInfo(
        "warning",
        "A small load tips a support over",
        "Less than it weighs itself at the middle of a surface, or less than a tenth of that near the edge, makes it "
        "fall: its foot is narrow, its mass centre off, or its mass too small.",
        "check foot, mass and mass centre",
    ),
    # Tools.
    "asset/tool-no-grasp": CodeInfo(
        "warning",
        "No gripper can take a tool where it is to be held",
        "Its handle, or without one the whole of it, has no place for fingers of any size that are strong enough.",
        "check size and mass, and the colliders around the handle; or state its role with --role",
    ),
    "asset/tool-lost": CodeInfo(
        "warning",
        "The gripper loses a tool while it is lifted or used",
        "Poured from, swung or stirred with, it leaves the pads.",
        "check friction, mass and mass centre, and the colliders where the pads touch",
    ),
    "asset/tool-slip": CodeInfo(
        "warning",
        "A tool slides or turns between the pads while it is used",
        "It is held, but points elsewhere than before: what is done with it misses.",
        "check friction, mass and mass centre",
    ),
    # Joints.
    "asset/handle-not-taken": CodeInfo(
        "warning",
        "No gripper gets hold of the link that a joint is to move",
        "Where the record has the handle, knob or button, no pads of any size close on it and no closed fingers get "
        "behind or before it without touching the object, on the way in or over half of the path of the joint.",
        "look at the colliders around the handle and at the limits of the joint: it may be filled in, lie behind "
        "another part, or be opened into the body",
    ),
    "asset/handle-astray": CodeInfo(
        "warning",
        "The handle moves another way than the record has it",
        "The joint moves the contact in another direction than that in which the record says that it opens.",
        "check the sign of the axis and the limits of the joint",
    ),
    "asset/handle-not-opened": CodeInfo(
        "warning",
        "A gripper that moves along the path of a joint does not take the link with it",
        "The joint stays behind although the hand pulls or pushes: it is stuck, too heavy or too stiff for a gripper.",
        "check limits, friction, damping and spring of the joint, the mass of its link, and colliders in its way",
    ),
    "asset/handle-lost": CodeInfo(
        "warning",
        "The pads slip off the handle while it is moved",
        "The joint follows, but a policy could not rely on the grip.",
        "check friction, and the colliders of the handle",
    ),
    "asset/handle-forced": CodeInfo(
        "warning",
        "The joint takes more force than a gripper has",
        "It moves, but only under a force along its path that is beyond that of the gripper.",
        "check friction, damping and spring of the joint, and the mass of its link",
    ),
    "asset/handle-not-returned": CodeInfo(
        "warning",
        "The joint does not come back when the hand moves it back",
        "It was opened, turned on or pressed, and the hand or its own spring does not bring it to where it was.",
        "check its limits and its spring, and colliders that hook",
    ),
    "asset/handle-unstable": CodeInfo(
        "warning",
        "The joint jumps or diverges in the hand",
        "It moves far faster than the hand that moves it, or to no finite position.",
        "check the mass and inertia of the link and overlaps of its colliders",
    ),
}
