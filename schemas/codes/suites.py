"""Diagnostic codes of the suites of acceptance, which exercise what a role promises; part of the table in
`schemas.codes`.
"""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

SUITE_CODES: dict[str, CodeInfo] = {
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
        "With another heading, a lean of less than a degree, or another step of the engine it falls over or moves on: "
        "scenes with it would not be reproducible.",
        "look at the foot of its colliders and at its mass centre; give it a wider foot, or another reference pose",
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
