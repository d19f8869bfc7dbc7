"""Diagnostic codes of the exercise of joints and of links that meet; part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

JOINT_CODES: dict[str, CodeInfo] = {
    "asset/joint-stuck": CodeInfo(
        "error",
        "A joint does not reach an end of its range",
        "Driven or pushed with the strength that links of this mass and size need, it stays behind: limits, damping or "
        "inertia hold it, or a link that moves with it is in its way.",
        "check limits, damping, friction and inertia of the joint named, and the colliders around it",
    ),
    "asset/joint-blocked": CodeInfo(
        "warning",
        "A joint runs into a link that another joint could move away",
        "At the rest state of the other joints it cannot reach an end of its range, as an arm that meets itself.",
        "nothing if that is so by design; else narrow the limits, or move the links apart",
    ),
    "asset/joint-overruns-limit": CodeInfo(
        "error",
        "A limit does not stop a joint",
        "A drawer falls out of its cabinet, a door turns through its frame.",
        "check the limits in the package; effort and mass must be of one unit",
    ),
    "asset/joint-axis-astray": CodeInfo(
        "error",
        "A joint moves along another axis than declared, or the other way",
        "A policy that pulls a drawer would push it.",
        "check axis and frames of the joint in the source; this may be a defect of Mana",
    ),
    "asset/joint-no-return": CodeInfo(
        "error",
        "A joint that was driven over its range does not come back to rest",
        "Something holds it where it was moved to: resetting an episode would fail.",
        "look at the colliders of the links along the motion",
    ),
    "asset/joint-unstable": CodeInfo(
        "error",
        "A joint moves faster than hand, motor and gravity can move it",
        "The simulation explodes: overlapping colliders burst apart, or an inertia is far too small.",
        "look at overlaps at rest, and at mass and inertia of the links",
    ),
    "asset/joint-penetration": CodeInfo(
        "warning",
        "A joint moves a link into its neighbour",
        "The two do not collide, because a joint connects them: the link passes through unhindered.",
        "narrow the limits, or correct place and axis of the joint; look at the asset at the position named",
    ),
    "asset/joint-contact-astray": CodeInfo(
        "warning",
        "The place where a joint is to be pushed has no collider",
        "A hand would reach through the handle.",
        "give the handle a collision shape, or look at the collision picture there",
    ),
    "asset/joint-probe-lost": CodeInfo(
        "warning",
        "What lies in a link is not carried along by it",
        "A thing in the drawer stays behind or falls through when the drawer is pulled.",
        "compare the collision picture of the link: floor and walls need colliders",
    ),
    "asset/joint-not-exercised": CodeInfo(
        "info",
        "A joint was not exercised, or not in full",
        "Ball joints, and joints of a loop or beyond the budget, are judged by their frames alone.",
        "nothing, or try the joint in your simulator",
    ),
    "asset/links-interpenetrate": CodeInfo(
        "error",
        "Links that collide reach into each other at rest",
        "They burst apart in the first step.",
        "move the links apart, or shrink their collision shapes",
    ),
    "asset/twin-disagrees": CodeInfo(
        "error",
        "URDF or MJCF twin and USD move a link differently",
        "The object would open in one engine and jam in another.",
        "this is a defect of Mana or an edited package: ingest the source again",
    ),
    "asset/colliders-trimmed": CodeInfo(
        "info",
        "Collision shapes of links that overlapped slightly at rest were cut back",
        "Contacts of links that reach into each other burst them apart in the first step.",
        "nothing; the record has the depth before and after",
    ),
    "asset/links-filtered": CodeInfo(
        "info",
        "Links overlap at rest and do not collide with each other",
        "They would burst apart; other things still collide with both.",
        "nothing if they are meant to overlap, as a hinge in its housing; else move the links apart",
    ),
    "asset/joint-damping-implausible": CodeInfo(
        "warning",
        "The damping of a joint is such that no hand could move it",
        "Numbers per degree read as per radian, or of another unit, turn a door into a wall.",
        "check the damping in the source; the package holds none",
    ),
}
