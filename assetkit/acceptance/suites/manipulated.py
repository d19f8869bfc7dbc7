"""Suite of manipulated objects: a gripper approaches, closes, lifts, holds, carries, shakes, sets down, goes back.

The grasps on record are tried in the poses in which they are free; without any on record, grasps are proposed on the
colliders for grippers from medium to large. The object passes if it passes with one of them.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from assetkit.acceptance.suites.grasping import best_grasp, not_picked_up
from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import CheckList, Conditions, Subject, SuiteRun, at_least, at_most
from assetkit.affordances.grasp_trials import trial_pose
from assetkit.affordances.grasps import pad_friction, propose_grasps
from geom.convex.support_function import diagonal, stability_margin
from geom.grasp.gripper import GRIPPERS, LARGE, MEDIUM, SMALL
from geom.pose import pose_from_quat
from schemas.affordances import Grasp
from schemas.arrays import FloatArray
from schemas.asset import Role
from schemas.diagnostics import Location
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import RigidBody
from sim.grasp_trial import PICK_AND_PLACE, GraspOutcome, GraspTask, Phase
from sim.port import Simulator

TRACE_S = 1.0 / 20.0
_PHASES = [phase for phase, _ in PICK_AND_PLACE.phases]


class ManipulatedSuite:
    """See the module."""

    name = "manipulated"
    varies = True
    roles: frozenset[Role] = frozenset({"manipulated"})
    codes = (
        "asset/handling-no-grasp",
        "asset/handling-pushed",
        "asset/handling-lost",
        "asset/handling-slip",
        "asset/handling-not-released",
        "asset/handling-landing",
    )

    def obstacle(self, subject: Subject) -> str:
        """Objects with joints are not picked up; contacts of engines are too coarse for the smallest ones."""
        return not_picked_up(subject)

    def run(self, subject: Subject, simulator: Simulator, conditions: Conditions) -> SuiteRun:
        """Of several grasps the first that passes, else the one with the most checks passed."""
        grasps, reason = grasps_to_try(subject)

        def attempt(grasp: Grasp) -> SuiteRun:
            return handle(subject, grasp, simulator, conditions)

        return best_grasp(subject, grasps[: subject.most_grasps], reason, "asset/handling-no-grasp", attempt)


def grasps_to_try(subject: Subject) -> tuple[list[Grasp], str]:
    """The best first, or none and the reason: grasps on record that held, then others that did not fail; without any,
    those that are proposed for the medium, the small or the large gripper, the first that has some.
    """
    recorded = sorted(
        (g for g in subject.grasps if g.trial != "not_held"), key=lambda g: (g.trial != "held", -g.quality)
    )
    if recorded:
        return recorded, ""
    reasons: dict[str, list[str]] = {}
    for gripper in (MEDIUM, SMALL, LARGE):
        proposed = propose_grasps(subject.body, subject.poses, gripper)
        if proposed.grasps:
            return list(proposed.grasps), ""
        reasons.setdefault(proposed.reason, []).append(f"{gripper.name} ({1000 * gripper.widest_m():.0f} mm)")
    return [], "; ".join(f"{reason} [{', '.join(grippers)}]" for reason, grippers in reasons.items())


def handle(subject: Subject, grasp: Grasp, simulator: Simulator, conditions: Conditions) -> SuiteRun:
    """The checks of one grasp, in the order of the motion; those after a loss are left out.

    The pads press with the force of the grasp, whatever mass and friction the conditions name.
    """
    varied = subject.under(conditions).body
    gripper = GRIPPERS[grasp.gripper]
    X_WA = trial_pose(grasp, subject.body, subject.poses)
    task = GraspTask(
        X_AG=pose_from_quat(np.array(grasp.quat_wxyz), grasp.position_m),
        opening_m=grasp.opening_m,
        force_n=min(grasp.force_n, gripper.force_n),
        friction=pad_friction(varied.contact),
        gripper=gripper,
        motion=PICK_AND_PLACE,
        step_s=conditions.step_s,
        trace_s=TRACE_S,
    )
    outcome = simulator.grasp(varied, X_WA, task)
    name = f"{grasp.affordance_id} of the {gripper.name} gripper"
    checks = CheckList(Location(file=subject.main_file.name))
    pushed = f"{name}: the open hand pushes it by {1000 * outcome.moved_m:.3g} mm"
    checks.add("asset/handling-pushed", pushed, at_most("pushed", outcome.moved_m, POLICY.moved_m, "m"))
    _retention(checks, name, outcome)
    if outcome.lost is None:
        _placement(checks, name, outcome, varied, X_WA)
    return checks.run(replace(subject, grasps=(grasp,)), outcome.trace)


def _retention(checks: CheckList, name: str, outcome: GraspOutcome) -> None:
    lost_in = "nowhere" if outcome.lost is None else outcome.lost.value
    kept = len(_PHASES) if outcome.lost is None else _PHASES.index(outcome.lost)
    release = _PHASES.index(Phase.RELEASE)
    checks.add(
        "asset/handling-lost",
        f"{name}: it is lost in the phase '{lost_in}'",
        at_least("phases_held", min(kept, release), release, "phases"),
    )
    if outcome.lost is None:
        slid = f"{name}: it slides by {1000 * outcome.slip_m:.3g} mm between the pads"
        checks.add("asset/handling-slip", slid, at_most("slip", outcome.slip_m, POLICY.slip_m, "m"))
        stuck = f"{name}: it does not come off when the pads open"
        checks.add("asset/handling-not-released", stuck, at_least("released", float(outcome.released), 1.0, ""))


def _placement(checks: CheckList, name: str, outcome: GraspOutcome, body: RigidBody, X_WA: FloatArray) -> None:
    landing = outcome.landing
    assert landing is not None, "the motion sets it down"
    size = diagonal(body.shapes)
    centre = np.asarray(body.mass.centre_of_mass_m)
    rolls = stability_margin(body.shapes, centre, -X_WA[2, :3])[0] < 0.01 * size
    drift_m = max(POLICY.landing_m, POLICY.landing_share * size)
    code = "asset/handling-landing"
    carried = at_least("landing_supported", float(landing.is_supported), 1.0, "")
    checks.add(code, f"{name}: set down, it does not lie on the ground", carried)
    sunk = at_most("landing_penetration", landing.penetration_m, POLICY.landing_sink * size, "m")
    checks.add(code, f"{name}: set down, it sinks into the ground", sunk)
    if rolls:
        return
    drift = at_most("landing_drift", landing.drift_m, drift_m, "m")
    checks.add(code, f"{name}: set down, it moves on by {landing.drift_m:.3g} m", drift)
    turn = at_most("landing_turn", math.degrees(landing.turn_rad), math.degrees(POLICY.landing_rad), "deg")
    checks.add(code, f"{name}: set down, it turns by {math.degrees(landing.turn_rad):.3g} deg", turn)
    speed = at_most("landing_speed", landing.speed_mps, POLICY.landing_speed * math.sqrt(GRAVITY_MPS2 * size), "m/s")
    checks.add(code, f"{name}: set down, it still moves", speed)
