"""Damping of joints that no hand could move, as of another unit, is left out: the value itself is then unknown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geom.mechanism_pose import link_motions
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, finding
from schemas.mechanism import Mechanism, MechanismJoint
from schemas.model import Mesh
from schemas.outcome import Repair

CODE = "asset/joint-damping-implausible"
SLOWLY_S = 10.0  # for the whole range: as slow as anybody opens anything
# Two hands pull with 250 to 500 N at most (Mital and Kumar 1998, Human muscle strength definitions, measurement, and
# usage); a robot's gear is stiffer to turn by hand, but few need that force at the end of the arm.
MOST_N = 500.0
ONE_TURN_RAD = 2.0 * np.pi


@dataclass(frozen=True)
class DampingResult:
    """The mechanism with what is left of the damping, a finding and a repair per joint that lost it."""

    mechanism: Mechanism
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()


def plausible_damping(mechanism: Mechanism, meshes: Sequence[Mesh]) -> DampingResult:
    """`mechanism` (metres, asset frame) without damping that takes more than 500 N, at the point of the moved links
    farthest from the axis, to go over the whole range in 10 s. `meshes` are those of all links at rest.
    """
    joints, notes, repairs = list[MechanismJoint](), list[Diagnostic](), list[Repair]()
    points = {m.link: np.concatenate([mesh.points for mesh in meshes if mesh.link == m.link]) for m in meshes}
    for joint in mechanism.joints:
        force = damping_force_n(mechanism, joint, points)
        if joint.damping > 0.0 and not force <= MOST_N:
            name = joint.source_name or joint.name
            headline = (
                f"joint '{name}': damping of {joint.damping:.4g} takes {force:.3g} N to move over its range in "
                f"{SLOWLY_S:g} s; it was left out"
            )
            notes.append(finding(CODE, headline, where=joint.where, value=force, bound=MOST_N, unit="N"))
            before: dict[str, float | int | str] = {"joint": name, "damping": joint.damping}
            after: dict[str, float | int | str] = {"joint": name, "damping": 0.0}
            repairs.append(Repair(name="drop_damping", code=CODE, stage="canonicalize", before=before, after=after))
            joint = replace(joint, damping=0.0)
        joints.append(joint)
    return DampingResult(replace(mechanism, joints=tuple(joints)), tuple(notes), tuple(repairs))


def damping_force_n(mechanism: Mechanism, joint: MechanismJoint, points: Mapping[str, FloatArray]) -> float:
    """The force at the farthest point of the moved links, from which damping keeps to the range in `SLOWLY_S`.

    `points` (n, 3) of each link by name, in the frame of the mechanism at rest.
    """
    low, high = joint.limits or (0.0, ONE_TURN_RAD)
    effort = joint.damping * (high - low) / SLOWLY_S
    if not joint.is_angular:
        return effort
    moved = link_motions(mechanism, {joint.name: joint.rest + 0.1})
    far = [at for link, at in points.items() if not np.allclose(moved.get(link, np.eye(4)), np.eye(4))]
    if not far:
        return 0.0
    arm = float(np.linalg.norm(np.cross(np.concatenate(far) - joint.anchor, joint.axis), axis=1).max())
    return effort / arm if arm > 0.0 else 0.0
