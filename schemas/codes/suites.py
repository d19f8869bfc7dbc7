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
}
