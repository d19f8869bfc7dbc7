"""Verifies the anchors of an articulated object in simulation, with the joints where they can be reached.

Tried in order: at rest; the sliding joint that carries the link open (a drawer pulled out); doors and lids open; the
link alone. The first state in which most probes stay counts, and the evidence names it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.affordances.anchor_trials import (
    AnchorTrial,
    VerifiedAnchors,
    try_anchors,
    unverified,
    verified_anchor,
)
from assetkit.articulation.link_anchors import DOORS
from geom.mechanism_pose import link_motions
from geom.pose import compose
from schemas.anchors import Anchor, Point3
from schemas.arrays import FloatArray
from schemas.articulation import JointUse
from schemas.diagnostics import Diagnostic
from schemas.evidence import Evidence
from schemas.mechanism import Mechanism
from schemas.physics import CollisionShape
from sim.port import Simulator

_SHIFT_ONLY = 1e-6  # largest entry of a rotation less the identity: the motion only shifts


@dataclass(frozen=True)
class _State:
    """Joint positions for a trial of anchors on `links`; `alone` keeps only these links. `words` is for evidence."""

    words: str
    positions: Mapping[str, float]
    links: frozenset[str]
    alone: bool = False


def verify_link_anchors(
    proposed: Sequence[Anchor],
    by_link: Mapping[str, Sequence[CollisionShape]],
    mechanism: Mechanism,
    uses: Sequence[JointUse],
    simulator: Simulator,
) -> VerifiedAnchors:
    """Each proposed anchor tried on the collision shapes of the links by name, at rest in the asset frame."""
    trials: dict[str, tuple[AnchorTrial, str]] = {}
    for state in _states(mechanism, uses):
        pending = [a for a in proposed if a.link in state.links and not _holds(trials.get(a.anchor_id))]
        if not pending:
            continue
        motions = link_motions(mechanism, state.positions)
        moved = [(a, _placed(a, motions[a.link or ""])) for a in pending]
        there = [(a, m) for a, m in moved if m is not None]
        links = state.links if state.alone else frozenset(by_link)
        fixed = [placed(shape, motions[name]) for name in by_link if name in links for shape in by_link[name]]
        if not fixed:
            continue
        for (anchor, _), trial in zip(there, try_anchors([m for _, m in there], fixed, simulator), strict=True):
            known = trials.get(anchor.anchor_id)
            if known is None or trial.share > known[0].share:
                trials[anchor.anchor_id] = trial, state.words
    holding, failed = list[Evidence[Anchor]](), list[Diagnostic]()
    for anchor in proposed:
        if (tried := trials.get(anchor.anchor_id)) is None:
            continue
        if tried[0].holds:
            holding.append(verified_anchor(anchor, tried[0], simulator.name, tried[1]))
        else:
            failed.append(unverified(anchor, tried[0], tried[1]))
    return VerifiedAnchors(tuple(holding), tuple(failed))


def _holds(tried: tuple[AnchorTrial, str] | None) -> bool:
    return tried is not None and tried[0].holds


def _states(mechanism: Mechanism, uses: Sequence[JointUse]) -> Iterator[_State]:
    everything = frozenset(link.name for link in mechanism.links)
    yield _State("", {}, everything)
    joints = {joint.name: joint for joint in mechanism.joints}
    below = {link.name: _subtree(mechanism, link.name) for link in mechanism.links}
    for use in uses:
        joint = joints[use.joint]
        if joint.kind == "prismatic" and use.task == "open":
            words = f", with {use.joint} at {use.open.value:.3g} m"
            yield _State(words, {use.joint: use.open.value}, below[joint.child])
    doors = {use.joint: use.open.value for use in uses if use.group.value in DOORS}
    if doors:
        on_doors = frozenset(name for joint in doors for name in below[joints[joint].child])
        yield _State(f", with {', '.join(doors)} open", doors, everything - on_doors)
    for link in mechanism.links[1:]:
        yield _State(", with the link alone", {}, frozenset({link.name}), alone=True)


def _subtree(mechanism: Mechanism, link: str) -> frozenset[str]:
    children = [joint.child for joint in mechanism.tree if joint.parent == link]
    return frozenset({link}).union(*(_subtree(mechanism, child) for child in children))


def _placed(anchor: Anchor, motion: FloatArray) -> Anchor | None:
    """The anchor where a motion (4, 4) takes it; None where it does more than shift it."""
    if np.abs(motion[:3, :3] - np.eye(3)).max() > _SHIFT_ONLY:
        return None
    x, y, z = (float(v) for v in np.asarray(anchor.position_m) + motion[:3, 3])
    position: Point3 = (x, y, z)
    return anchor.model_copy(update={"position_m": position})


def placed(shape: CollisionShape, motion: FloatArray) -> CollisionShape:
    """The shape where a motion (4, 4) of the asset frame takes it."""
    if shape.points is None:
        return CollisionShape(shape.kind, shape.size_m, compose(motion, shape.X_AS))
    points = shape.points @ motion[:3, :3].T + motion[:3, 3]
    return CollisionShape(shape.kind, shape.size_m, shape.X_AS, points, shape.triangles)
