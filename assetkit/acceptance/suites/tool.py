"""Suite of tools: taken where it is to be held, a tool is lifted, used and set down, and keeps its place in the hand.

It is held at its handle; without one, by those grasps that are farthest from the mass centre. What is done with it
follows from its regions: over a rim or a spout it is poured, other tools strike and stir.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from assetkit.acceptance.suites.grasping import best_grasp, not_picked_up
from assetkit.acceptance.suites.manipulated import TRACE_S
from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import CheckList, Conditions, Subject, SuiteRun, at_least, at_most
from assetkit.affordances.grasp_trials import trial_pose
from assetkit.affordances.grasps import pad_friction, propose_grasps
from assetkit.affordances.region_grasps import takes
from geom.convex.support_function import surface
from geom.grasp.gripper import GRIPPERS, LARGE, MEDIUM, SMALL
from geom.pose import pose_from_quat
from schemas.affordances import Grasp, RegionKind
from schemas.asset import Role
from schemas.diagnostics import Location
from schemas.physics import RigidBody
from sim.grasp_trial import LIFT_M, GraspTask, HandMotion, Phase
from sim.port import Simulator

# What is done with a tool that has such a region, as phases with their seconds; and with one that has none.
_POUR = ((Phase.CARRY, 1.2), (Phase.TILT, 4.0))
USES: Mapping[RegionKind, tuple[tuple[Phase, float], ...]] = {"rim": _POUR, "spout": _POUR}
OTHER_USE = ((Phase.CARRY, 1.2), (Phase.SWING, 2.2), (Phase.STIR, 3.0))
_BEFORE = ((Phase.APPROACH, 0.6), (Phase.CLOSE, 0.35))
_LIFT_S, _HOLD_S, _RELEASE_S = 0.8, 0.5, 0.35
_ABOVE_GROUND_M = 0.05  # that the tool stays above the ground, however it turns


class ToolSuite:
    """See the module."""

    name = "tool"
    varies = True
    roles: frozenset[Role] = frozenset({"tool"})
    codes = ("asset/tool-no-grasp", "asset/tool-lost", "asset/tool-slip")

    def obstacle(self, subject: Subject) -> str:
        """Objects with joints are not picked up; contacts of engines are too coarse for the smallest ones."""
        return not_picked_up(subject)

    def run(self, subject: Subject, simulator: Simulator, conditions: Conditions) -> SuiteRun:
        """Of several grasps the first that passes, else the one with the most checks passed."""
        grasps, reason = tool_grasps(subject)

        def attempt(grasp: Grasp) -> SuiteRun:
            return _use(subject, grasp, simulator, conditions)

        return best_grasp(subject, grasps[: POLICY.tries], reason, "asset/tool-no-grasp", attempt)


def tool_grasps(subject: Subject) -> tuple[list[Grasp], str]:
    """Where it is held for use, the best first, or none and the reason.

    Of the grasps on record that did not fail, and if none of those serves, of those proposed for the medium, the small
    or the large gripper: with handles those that take one, else those about as far from the mass centre as any.
    """
    handles = [region for region in subject.regions if region.kind == "handle"]
    named = {name for handle in handles for name in handle.held_by}
    recorded = [grasp for grasp in subject.grasps if grasp.trial != "not_held"]

    def serving(grasps: Sequence[Grasp]) -> list[Grasp]:
        if handles:
            return [grasp for grasp in grasps if any(takes(grasp, handle) for handle in handles)]
        return _farthest(grasps, subject.body)

    if chosen := [grasp for grasp in recorded if grasp.affordance_id in named] or serving(recorded):
        return sorted(chosen, key=lambda g: (g.trial != "held", -g.quality)), ""
    reasons: list[str] = []
    for gripper in (MEDIUM, SMALL, LARGE):
        proposed = propose_grasps(subject.body, subject.poses, gripper)
        if chosen := serving(proposed.grasps):
            return sorted(chosen, key=lambda g: -g.quality), ""
        reason = proposed.reason or "none of its grasps takes the handle"
        reasons.append(f"{gripper.name} gripper ({1000 * gripper.widest_m():.0f} mm): {reason}")
    return [], "; ".join(reasons)


def _farthest(grasps: Sequence[Grasp], body: RigidBody) -> list[Grasp]:
    """Those that lie at least `POLICY.far_share` as far from the mass centre as the one that is farthest."""
    levers = [_lever_m(grasp, body) for grasp in grasps]
    return [grasp for grasp, lever in zip(grasps, levers, strict=True) if lever >= POLICY.far_share * max(levers)]


def _lever_m(grasp: Grasp, body: RigidBody) -> float:
    return math.dist(grasp.position_m, body.mass.centre_of_mass_m)


def _use(subject: Subject, grasp: Grasp, simulator: Simulator, conditions: Conditions) -> SuiteRun:
    """The checks of one grasp; the pads press with its force, whatever mass and friction the conditions name."""
    varied = subject.under(conditions).body
    gripper, motion = GRIPPERS[grasp.gripper], use_motion(subject, grasp)
    task = GraspTask(
        X_AG=pose_from_quat(np.array(grasp.quat_wxyz), grasp.position_m),
        opening_m=grasp.opening_m,
        force_n=min(grasp.force_n, gripper.force_n),
        friction=pad_friction(varied.contact),
        gripper=gripper,
        motion=motion,
        step_s=conditions.step_s,
        trace_s=TRACE_S,
    )
    outcome = simulator.grasp(varied, trial_pose(grasp, subject.body, subject.poses), task)
    name = f"{grasp.affordance_id} of the {gripper.name} gripper"
    checks = CheckList(Location(file=subject.main_file.name))
    phases = [phase for phase, _ in motion.phases]
    release = phases.index(Phase.RELEASE)
    phases_held = release if outcome.lost is None else phases.index(outcome.lost)
    headline = f"{name}: it is lost in the phase '{outcome.lost.value if outcome.lost else 'release'}'"
    checks.add("asset/tool-lost", headline, at_least("use_phases_held", phases_held, release, "phases"))
    if outcome.lost is None:
        most = max(POLICY.use_slip_m, POLICY.use_slip_share * _lever_m(grasp, varied))
        headline = f"{name}: used, it moves by {1000 * outcome.slip_m:.3g} mm between the pads"
        checks.add("asset/tool-slip", headline, at_most("use_slip", outcome.slip_m, most, "m"))
    return checks.run(replace(subject, grasps=(grasp,)), outcome.trace)


def use_motion(subject: Subject, grasp: Grasp) -> HandMotion:
    """Lift, hold, the uses of its regions, lower and release: lifted so far that it turns freely above the ground.

    The wrist turns so that the mass centre goes down at first, as what pours or strikes does.
    """
    kinds = {region.kind for region in subject.regions}
    uses = next((use for kind, use in USES.items() if kind in kinds), OTHER_USE)
    X_WA = trial_pose(grasp, subject.body, subject.poses)
    X_AG = pose_from_quat(np.array(grasp.quat_wxyz), grasp.position_m)
    points = np.concatenate([surface(shape)[0] for shape in subject.body.shapes])
    reach = float(np.linalg.norm(points - X_AG[:3, 3], axis=1).max())
    X_WG = X_WA @ X_AG
    lift = max(LIFT_M, reach + _ABOVE_GROUND_M - float(X_WG[2, 3]))
    lever_W = X_WA[:3, :3] @ (np.asarray(subject.body.mass.centre_of_mass_m) - X_AG[:3, 3])
    rises = float(np.cross(X_WG[:3, 0], lever_W)[2])
    seconds = _LIFT_S * math.sqrt(lift / LIFT_M)
    phases = (
        *_BEFORE,
        (Phase.LIFT, seconds),
        (Phase.HOLD, _HOLD_S),
        *uses,
        (Phase.LOWER, seconds),
        (Phase.RELEASE, _RELEASE_S),
    )
    return HandMotion(phases, lift_m=lift, wrist_sense=-1.0 if rises > 0.0 else 1.0)
