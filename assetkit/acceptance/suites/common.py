"""Suite for every object: it slides down a steep slope, and settles alike when set down again.

The drop on a slope is `slope_drop` of SimReady's runtime benchmark. Repeats set the object down with another heading
and a slight lean, drawn by a fixed seed, and with engine steps of other lengths: what stays upright once must do so
each time, and end at the same place.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from assetkit.acceptance.settling import TOPPLED_RAD
from assetkit.acceptance.stable_poses import displacement, resting_pose
from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import CheckList, Conditions, Subject, SuiteRun, at_least, at_most
from geom.convex.support_function import diagonal, stability_margin
from geom.pose import DOWN, matrix_of, pose
from schemas.arrays import FloatArray
from schemas.asset import Role
from schemas.diagnostics import Location
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import RigidBody
from sim.port import DropSettings, Simulator, World, natural_time_s, stillness_for, world_for

_SEED = 20


class CommonSuite:
    """See the module."""

    name = "common"
    varies = False
    roles: frozenset[Role] = frozenset()
    codes = ("asset/slope-astray", "asset/settling-unrepeatable")

    def obstacle(self, subject: Subject) -> str:
        """Nothing hinders it."""
        return ""

    def run(self, subject: Subject, simulator: Simulator, conditions: Conditions) -> SuiteRun:
        """Slope and repeats; an articulated object has its joints held at rest."""
        checks = CheckList(Location(file=subject.main_file.name))
        body = subject.under(conditions).body
        _slope(checks, body, simulator)
        _repeats(checks, body, simulator)
        return checks.run()


def _slope(checks: CheckList, body: RigidBody, simulator: Simulator) -> None:
    """Set down on the slope at friction 0.5, which is too little for 45 degrees: it must move, and stay on the slope.

    The slope is level ground under tilted gravity.
    """
    size = diagonal(body.shapes)
    tilt = math.radians(POLICY.slope_deg)
    gravity = (GRAVITY_MPS2 * math.sin(tilt), 0.0, -GRAVITY_MPS2 * math.cos(tilt))
    contact = body.contact.model_copy(
        update={
            "dynamic_friction": POLICY.slope_friction,
            "static_friction": POLICY.slope_friction,
            "combine": "minimum",
        }
    )
    world = replace(world_for(size), gravity_mps2=gravity, ground_friction=POLICY.slope_friction)
    duration_s = max(POLICY.slope_s, 3.0 * natural_time_s(size))
    start = resting_pose(body, DOWN, gap_m=0.002 * size)
    result = simulator.drop(replace(body, contact=contact), start, DropSettings(duration_s, world))
    moved = float(np.linalg.norm(result.positions_m[-1] - result.positions_m[0]))
    touch_s = result.touch_s(0.005 * size)
    after = result.heights_m[result.times_s >= touch_s] if touch_s is not None else np.array([math.inf])
    code = "asset/slope-astray"
    least = min(POLICY.slope_moved_m, POLICY.slope_moved_share * size)
    most = max(POLICY.slope_apart_m, POLICY.slope_apart_share * size)
    # What rolls or tumbles leaves the slope by no more than it is tall.
    most = max(most, 0.5 * size)
    headline = f"on a slope of {POLICY.slope_deg:.0f} degrees"
    finite = at_least("slope_finite", float(result.finite), 1.0, "")
    checks.add(code, f"{headline} its motion diverges", finite)
    checks.add(code, f"{headline} it does not slide", at_least("slope_moved", moved, least, "m"))
    apart = float(after.max())
    checks.add(code, f"{headline} it jumps off by {apart:.3g} m", at_most("slope_separation", apart, most, "m"))


def _repeats(checks: CheckList, body: RigidBody, simulator: Simulator) -> None:
    """Set down with other headings and slight leans, and with other steps."""
    size = diagonal(body.shapes)
    margin = stability_margin(body.shapes, np.asarray(body.mass.centre_of_mass_m), DOWN)[0]
    world = world_for(size)
    first_tilt, first_moved = _set_down(body, simulator, world, pose())
    stays = first_tilt <= TOPPLED_RAD
    checks.checks.append(at_most("set_down_tilt", math.degrees(first_tilt), 180.0, "deg"))
    # What balances on a point or an edge has no pose to come back to.
    if not stays or margin < 0.01 * size:
        return
    random = np.random.default_rng(_SEED)
    leans = [_turn(random) for _ in range(POLICY.seeds)]
    code = "asset/settling-unrepeatable"
    for number, turn in enumerate(leans, 1):
        tilt, moved = _set_down(body, simulator, world, turn)
        _alike(
            checks, code, f"seed_{number}", "set down with another heading and lean", tilt, moved - first_moved, size
        )
    for rate in POLICY.steps_hz:
        other = replace(world, timestep_s=1.0 / rate)
        tilt, moved = _set_down(body, simulator, other, pose())
        _alike(checks, code, f"steps_{rate:.0f}_hz", f"at {rate:.0f} steps a second", tilt, moved - first_moved, size)


def _alike(checks: CheckList, code: str, name: str, words: str, tilt: float, off_m: float, size: float) -> None:
    tilted = at_most(f"{name}_tilt", math.degrees(tilt), math.degrees(POLICY.repeat_rad), "deg")
    checks.add(code, f"{words} it ends leaning by {math.degrees(tilt):.3g} deg", tilted)
    placed = at_most(f"{name}_place", abs(off_m) / size, POLICY.repeat_share, "of diagonal")
    checks.add(code, f"{words} it ends {abs(off_m):.3g} m elsewhere", placed)


def _turn(random: np.random.Generator) -> FloatArray:
    """A heading about z, after a lean of at most `POLICY.lean_rad` about a level axis: (4, 4)."""
    heading, side = random.uniform(0.0, 2.0 * math.pi, 2)
    lean = random.uniform(0.0, POLICY.lean_rad)
    axis = lean * np.array([math.cos(side), math.sin(side), 0.0])
    return pose((Rotation.from_euler("z", heading) * Rotation.from_rotvec(axis)).as_matrix())


def _set_down(body: RigidBody, simulator: Simulator, world: World, turn: FloatArray) -> tuple[float, float]:
    """Final tilt (rad) of the reference pose, and how far (m) the object went, set down from 0.2 % of its size."""
    size = diagonal(body.shapes)
    down_A = turn[:3, :3].T @ DOWN
    X_WA = pose(turn[:3, :3], resting_pose(body, down_A, gap_m=0.002 * size)[:3, 3])
    duration_s = max(1.0, 8.0 * natural_time_s(size))
    settings = DropSettings(duration_s, world, stillness_for(size))
    result = simulator.drop(body, X_WA, settings)
    moved_m, _ = displacement(result)
    up = float(matrix_of(result.quats_wxyz[-1])[2, 2])
    return (math.acos(min(max(up, -1.0), 1.0)) if result.finite else math.pi), moved_m
