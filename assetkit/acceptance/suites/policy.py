"""Bounds that decide on suites of acceptance, each with unit and origin."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class SuitePolicy:
    """Bounds of the checks of suites. Lengths in m, times in s, angles in rad unless named otherwise.

    Handling (`manipulated`, `tool`):
    tries            grasps that are tried; SimReady's runtime benchmark passes an object that any grasp lifts.
    moved_m          that the open hand may push the object before it closes: as much as its pads are clear of it.
    slip_m           in the gripper, from closed pads to set down: half a pad of the medium gripper, beyond which the
                     pads touch another place than planned.
    landing_m, landing_share  drift of the mass centre after it was let go: SimReady's 2 cm of rest, or that share of
                     the object's size where that is more.
    landing_rad      turn after it was let go: between the 5 degrees in which a pose counts as the same and the 30 in
                     which the next face may lie.
    landing_sink     share of the size that it may sink in at rest, as when it is set down (`settling`).
    landing_speed    share of its natural speed sqrt(g L) at the end, as for what rolls on (`settling`).

    Slope (`common`): `slope_drop` of SimReady's runtime benchmark, 45 degrees at a friction of 0.5.
    slope_deg, slope_friction, slope_s
    slope_moved_m    that it must move at least: 1 cm, or `slope_moved_share` of its size for small things.
    slope_apart_m    that it may leave the slope once it has touched: 5 cm, or `slope_apart_share` of its size.

    Repeats (`common`):
    seeds            times that it is set down with another heading and a lean of `lean_rad`: half of what an
                     upright pose must recover from (`stable_poses`).
    steps_hz         engine steps per second beside 240.
    repeat_rad, repeat_share  by which final tilt, and place as a share of the size, may differ between repeats of what
                     stays upright.

    Receptacles:
    ball_shares      radii of the balls as shares of the largest ball that passes the opening: large ones as those that
                     verify anchors, small ones that find gaps between colliders; none is as small as the colliders may
                     be off the visible surface (`anchor_trials.OFF_SHARE`).
    fall_heights     heights of the volume from which things fall in: SimReady's ground drop is from twice the height.
    wall_m           wall that must stop a probe within one step of the engine: sheet and moulded walls are 1 mm and
                     more. What is faster than its own radius and half of that wall a step goes through any wall in
                     engines without continuous collision, so nothing is dropped faster.
    phases           fast probes, with starts spread over one step.
    stay_share       of probes that must stay, as for the anchors that scenes use (`anchor_trials.STAY_SHARE`).
    content_kgpm3    of the volume that content weighs: half of it in water.
    tip_rad          ground on which it must stand, empty and with content: IEC 60335-1, clause 20.1, appliances on a
                     plane of 10 degrees with the most unfavourable quantity of liquid.
    volumes          the largest ones, which are tried.

    Supports:
    surfaces         the first ones, which are tried.
    stack, stack_edge  boxes upon one another, and the edge of a box as a share of the object's size; half as high.
    stack_share      of its edge that a box may move, and `stack_rad` that it may turn, in a stack at rest.
    load_middle, load_edge  least load in masses of the object that tips it over when it stands at the middle, and at
                     the worst place at which a box stands wholly on the surface: what cannot carry its own mass, or a
                     tenth of it at the edge, tips under what scenes put onto it.
    load_most        load beyond which no limit is sought.
    load_sure        share of the limit by geometry that must stand in simulation.

    Tools:
    far_share        of the largest distance of a grasp from the mass centre, from which on a grasp holds a tool that
                     has no handle: of spread grasps the outermost ones.
    use_slip_m       in the gripper over the motion of use, as for handling, or `use_slip_share` of the lever from the
                     pads to the mass centre where that is more: a turn of as many radians between the pads.

    Joints (`fixture`):
    joints           that are handled, the first ones on record; more would take longer than everything else.
    joint_tries      ways that are tried with pads, and as many with closed fingers.
    joint_pull_rad   between the first motion at the contact and the direction on record: a wide region
                     moves in several directions; another sign of the axis is 180 degrees off.
    joint_free       share of the range over which hand and fingers must be clear of the object: half open lets a hand
                     or an object through.
    joint_turn_rad   that a hand turns at most in one go: the last joint of a Franka arm turns 2.9 rad either way.
    joint_followed   share of the way of the hand that the joint must make: SimReady's benchmark is content with 2 %.
    joint_kept       share of the time of moving in which both pads must touch the link.
    joint_back       share of the range that may be left when it is moved back.
    joint_speed      of the joint over that of the hand: what it may jump ahead when it is freed.

    Record (`on_record`):
    poses            stable poses on record that are tried, the most probable first.
    pose_share       of the size by which its origin may rest higher or lower than on record: colliders are as they
                     were, and half of what a foot may be off the visible surface (`anchor_trials.OFF_SHARE`).
    surface_margin   share of the size by which a surface is smaller where nothing may stand above it: the foot of a rim
                     may reach in as far as colliders are off the visible surface.

    margin_share     to which the value is found from which on a suite holds.
    """

    tries: int = 3
    moved_m: float = 0.005
    slip_m: float = 0.01
    landing_m: float = 0.02
    landing_share: float = 0.1
    landing_rad: float = math.radians(15.0)
    landing_sink: float = 0.02
    landing_speed: float = 0.02
    slope_deg: float = 45.0
    slope_friction: float = 0.5
    slope_s: float = 0.5
    slope_moved_m: float = 0.01
    slope_moved_share: float = 0.5
    slope_apart_m: float = 0.05
    slope_apart_share: float = 0.25
    seeds: int = 3
    lean_rad: float = math.radians(1.0)
    steps_hz: tuple[float, ...] = (120.0, 480.0)
    repeat_rad: float = math.radians(5.0)
    repeat_share: float = 0.05
    ball_shares: tuple[float, float] = (0.4, 0.1)
    fall_heights: float = 2.0
    wall_m: float = 0.001
    phases: int = 24
    stay_share: float = 0.8
    content_kgpm3: float = 500.0
    tip_rad: float = math.radians(10.0)
    volumes: int = 4
    surfaces: int = 4
    stack: int = 3
    stack_edge: float = 0.05
    stack_share: float = 0.25
    stack_rad: float = math.radians(5.0)
    load_middle: float = 1.0
    load_edge: float = 0.1
    load_most: float = 3.0
    load_sure: float = 0.9
    far_share: float = 0.8
    use_slip_m: float = 0.01
    use_slip_share: float = 0.1
    joints: int = 8
    joint_tries: int = 3
    joint_pull_rad: float = math.radians(60.0)
    joint_free: float = 0.5
    joint_turn_rad: float = 2.9
    joint_followed: float = 0.9
    joint_kept: float = 0.9
    joint_back: float = 0.1
    joint_speed: float = 5.0
    poses: int = 4
    pose_share: float = 0.01
    surface_margin: float = 0.01
    margin_share: float = 0.1


POLICY = SuitePolicy()
