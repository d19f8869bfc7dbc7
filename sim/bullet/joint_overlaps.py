"""Overlaps of links of an articulated object in PyBullet: at rest, and along the range of one joint."""

from __future__ import annotations

import numpy as np

from geom.mechanism_pose import joint_positions
from schemas.mechanism import MechanismJoint
from sim.bullet.articulation import BuiltArticulation
from sim.joint_exercise import LinkOverlap, followers

POSITIONS = 17  # along the reach, ends included
LEAST_M = 1e-4  # an overlap below is none


def overlaps_at_rest(built: BuiltArticulation) -> tuple[LinkOverlap, ...]:
    """All pairs of links that reach into each other at rest."""
    built.set_positions(joint_positions(built.articulation.mechanism, {}))
    depths = [(first, second, built.overlap(first, second), collides) for first, second, collides in built.pairs()]
    return tuple(LinkOverlap(*pair) for pair in depths if pair[2] > LEAST_M)


def overlaps_along(
    built: BuiltArticulation, joint: MechanismJoint, moved: frozenset[str], reach: tuple[float, float]
) -> tuple[LinkOverlap, ...]:
    """The deepest overlap beyond rest of each pair of links that `joint` moves against each other; others at rest."""
    mechanism = built.articulation.mechanism
    built.set_positions(joint_positions(mechanism, {}))
    pairs = [pair for pair in built.pairs() if (pair[0] in moved) != (pair[1] in moved)]
    at_rest = [built.overlap(first, second) for first, second, _ in pairs]
    between = _parted_by(built, joint)
    deepest: dict[int, LinkOverlap] = {}
    for position in np.linspace(*reach, POSITIONS):
        built.set_positions(joint_positions(mechanism, {joint.name: float(position)}))
        for number, (first, second, collides) in enumerate(pairs):
            depth = built.overlap(first, second) - at_rest[number]
            if depth > max(LEAST_M, deepest[number].depth_m if number in deepest else 0.0):
                fixed = frozenset((first, second)) in between
                deepest[number] = LinkOverlap(first, second, depth, collides, fixed, float(position))
    return tuple(sorted(deepest.values(), key=lambda overlap: -overlap.depth_m))


def _parted_by(built: BuiltArticulation, joint: MechanismJoint) -> frozenset[frozenset[str]]:
    """Pairs of links between which no joint lies but `joint` and those that follow it."""
    mechanism = built.articulation.mechanism
    moving = {joint.name, *(other.name for other in followers(mechanism, joint))}
    carrier = {j.child: j for j in mechanism.tree}

    def path(link: str) -> list[str]:
        names: list[str] = []
        while link in carrier:
            names.append(carrier[link].name)
            link = carrier[link].parent
        return names

    paths = {link.name: set(path(link.name)) for link in mechanism.links}
    return frozenset(
        frozenset((a, b))
        for a in paths
        for b in paths
        if a < b and (paths[a] ^ paths[b]) <= moving and paths[a] ^ paths[b]
    )
