"""Tries proposed grasps in simulation: the best ones close on the released colliders, lift, hold, shake and release."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from assetkit.acceptance.stable_poses import resting_pose
from assetkit.affordances.grasps import pad_friction
from geom.convex.support_function import diagonal
from geom.pose import pose_from_quat
from schemas.acceptance import StablePose
from schemas.affordances import AffordanceEvidence, Grasp
from schemas.anchors import Point3
from schemas.arrays import FloatArray
from schemas.evidence import Evidence, inferred, measured
from schemas.physics import RigidBody
from sim.grasp_trial import GraspTask
from sim.port import SMALLEST_M, Simulator

TRIED, ENOUGH = 3, 2
HELD, UNTRIED = 0.95, 0.7  # Confidence. Untried: below the share of tried grasps that held, the best of their objects.
GEOMETRY = "antipodal pads on the colliders"


def try_grasps(
    grasps: Sequence[Grasp],
    body: RigidBody,
    poses: Sequence[StablePose],
    simulator: Simulator,
    *,
    most: int = TRIED,
) -> tuple[Evidence[Grasp], ...]:
    """Each grasp with the outcome of its trial, in the most probable pose that leaves it free.

    They are tried in order until `ENOUGH` of them held, at most `most`. A body smaller than 2 cm is not tried: contacts
    of engines are too coarse for it.
    """
    results: list[Evidence[Grasp]] = []
    tiny = diagonal(body.shapes) < SMALLEST_M
    enough = ENOUGH if most <= TRIED else most
    for grasp in grasps:
        done = len(results) >= most or sum(e.value.trial == "held" for e in results) >= enough
        results.append(untried(grasp) if tiny or done else _with_trial(grasp, body, poses, simulator))
    return tuple(results)


def untried(grasp: Grasp) -> Evidence[Grasp]:
    """A grasp with geometric evidence only."""
    untried_grasp = grasp.model_copy(update={"trial": "untried", "slip_m": None})
    return inferred(untried_grasp, f"{GEOMETRY}; not tried", round(UNTRIED * min(1.0, grasp.quality + 0.3), 3))


def _with_trial(grasp: Grasp, body: RigidBody, poses: Sequence[StablePose], simulator: Simulator) -> Evidence[Grasp]:
    task = GraspTask(
        X_AG=pose_from_quat(np.array(grasp.quat_wxyz), grasp.position_m),
        opening_m=grasp.opening_m,
        force_n=grasp.force_n,
        friction=pad_friction(body.contact),
    )
    outcome = simulator.grasp(body, trial_pose(grasp, body, poses), task)
    if not outcome.held or not outcome.released:
        why = "not held" if not outcome.held else "not let go"
        refuted = grasp.model_copy(update={"trial": "not_held"})
        return measured(refuted, f"{GEOMETRY}; {why} in {simulator.name}", confidence=0.0)
    held = grasp.model_copy(update={"trial": "held", "slip_m": round(outcome.slip_m, 6)})
    return measured(held, f"{GEOMETRY}; lifted, held, shaken and let go in {simulator.name}", confidence=HELD)


def trial_pose(grasp: Grasp, body: RigidBody, poses: Sequence[StablePose]) -> FloatArray:
    """X_WA (4, 4) of the most probable stable pose in which the grasp is free; the reference pose without any."""
    if not poses:
        return resting_pose(body, np.array([0.0, 0.0, -1.0]), gap_m=0.0)
    chosen = max((poses[i] for i in grasp.poses), key=lambda p: p.probability)
    return pose_from_quat(np.array(chosen.quat_wxyz), (0.0, 0.0, chosen.support_offset_m))


def grasp_lines(affordances: Sequence[AffordanceEvidence]) -> tuple[tuple[Point3, Point3], ...]:
    """The two contact points of each grasp that was not refuted: those that held first, then by quality."""
    unrefuted = [e.value for e in affordances if isinstance(e.value, Grasp) and e.value.trial != "not_held"]
    return tuple(grasp.contacts_m for grasp in sorted(unrefuted, key=lambda g: (g.trial != "held", -g.quality)))


def without_trial(evidence: AffordanceEvidence) -> AffordanceEvidence:
    """An affordance after a change of mass or friction: the trial of a grasp with the old values is dropped."""
    return untried(evidence.value) if isinstance(evidence.value, Grasp) else evidence
