"""Bounds that decide on the joints of a package, each with its origin, and how much is exercised."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class JointPolicy:
    """Bounds of the checks of joints. Lengths in m, angles in rad unless named otherwise.

    axis_deg, penetration_m   roadmap, issue 30 item 5: within 1 degree, no penetration above 1 mm.
    twin_m, twin_deg          roadmap, issue 30 item 3: link poses agree within 0.1 mm and 0.05 degrees.
    reach_share               of the range that may be missing at an end: the share of a door's gap, 1 degree of 90.
    overrun_share             of the range beyond an end. The exercise drives 3 % past it
                              (`sim.bullet.joint_exercise.BEYOND`): half of that means that nothing stops the joint. One
                              step of the simulation comes on top, for an engine notices a limit a step late.
    return_share              of the range by which a joint may miss its rest: as for its ends.
    least_angle, least_length the finest tolerance of a position: 0.05 degrees and 0.05 mm, half of what twins may be
                              apart by; it counts for joints of a tiny range.
    contact_m, contact_share  how far the place to push may lie from a collider: 5 mm, the thickness of a finger's tip,
                              or 5 % of the link's diagonal, as colliders may be off visible surfaces
                              (`body_checks.alignment_checks`).
    probe_share               of the way of its link that a probe may lag behind.
    blocked_share             of its range that a joint must reach before it runs into a link that others can move away;
                              below, a person looks.
    damping_n                 that moving a joint over its range in 10 s may take against its damping: what intake
                              leaves in (`joint_damping.MOST_N`), with a tenth to spare for colliders that are smaller.
    thorough_joints           up to so many joints of one object are driven and pushed, slow and fast; up to
                              `quick_joints` each is driven slowly and pushed fast; up to `most_joints` driven fast; the
                              others are not exercised. A joint takes 0.1 s of a core, 0.4 s with every run (measured).
    """

    axis_deg: float = 1.0
    penetration_m: float = 1e-3
    twin_m: float = 1e-4
    twin_deg: float = 0.05
    reach_share: float = 0.011
    overrun_share: float = 0.015
    return_share: float = 0.011
    least_angle: float = 8.7e-4
    least_length: float = 5e-5
    contact_m: float = 5e-3
    contact_share: float = 0.05
    probe_share: float = 0.2
    blocked_share: float = 0.5
    damping_n: float = 550.0
    thorough_joints: int = 6
    quick_joints: int = 24
    most_joints: int = 64


POLICY = JointPolicy()
