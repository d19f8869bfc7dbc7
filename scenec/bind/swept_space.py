"""The space that a joint of an articulated asset sweeps in a joint state, from the swept volume of its record.

The record knows it with all other joints at rest (those that follow any where couplings take them). It is the same one
elsewhere where the joints between the root and its parent have moved that levelly, and those on its links have not
moved. Frame P is the asset frame. Metres, radians.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import shapely
from shapely import Polygon
from shapely.affinity import affine_transform
from shapely.geometry.base import BaseGeometry

from geom.mechanism_pose import joint_positions, link_motions
from geom.pose import inverse
from scenec.bind.joint_states import LIMIT_SLACK
from scenec.bind.posed_asset import PosedAsset, lean_deg
from schemas.arrays import FloatArray
from schemas.articulation import SweptVolume
from schemas.diagnostics import InvalidInput, finding
from schemas.mechanism import Mechanism, MechanismJoint
from schemas.scene.geometry import PlaceLayer

SWEPT_TILT_DEG = 0.01  # of a swept volume, which must cover the motion: 0.1 mm over half a metre
HEIGHT_DIGITS = 9  # of the heights by which prisms of one swept volume are put together


def swept_space(posed: PosedAsset, joint: str) -> tuple[tuple[str, ...], tuple[PlaceLayer, ...]]:
    """The links that a joint moves, and the space in P that they sweep.

    Raises InvalidInput (`scene/no-swept-volume`) where it is not known for this state.
    """
    mechanism = posed.linkage.mechanism
    volume = posed.swept.get(joint)
    if volume is None:
        known = joint in posed.swept
        raise _unknown(
            posed, joint, "its links have no collision shape" if known else "the record of the asset has none"
        )
    moved = _carried_by(mechanism, joint)
    loop = next((one.name for one in mechanism.joints if one.closes_loop and _is_opened_by(moved, one)), None)
    if loop is not None:
        raise _unknown(posed, joint, f"other joints move with it, for `{loop}` closes a loop")
    tied = {joint, *_followers(mechanism, joint)}
    recorded = joint_positions(mechanism, {})
    off = {name for name, position in posed.positions if abs(position - recorded[name]) > LIMIT_SLACK} - tied
    if inner := sorted(one.name for one in mechanism.tree if one.child in moved and one.name in off):
        raise _unknown(posed, joint, f"it is known with all other joints at rest, and `{inner[0]}` is not")
    parent = next(one.parent for one in mechanism.tree if one.name == joint)
    motions = {name: posed.motions[name] @ inverse(M) for name, M in link_motions(mechanism, recorded).items()}
    if lean_deg(motions[parent]) > SWEPT_TILT_DEG:
        raise _unknown(posed, joint, f"it leans with `{parent}`")
    for one in mechanism.tree:
        outer = one.name in tied and one.parent not in moved
        if outer and not np.allclose(motions[one.parent], motions[parent], rtol=0.0, atol=LIMIT_SLACK):
            raise _unknown(posed, joint, f"`{one.name}`, which follows it, is on `{one.parent}`, which has moved")
    layers = tuple(_moved_layer(motions[parent], layer) for layer in _layers(volume))
    if not layers:
        raise _unknown(posed, joint, "the record of the asset has an empty one")
    return moved, layers


def _layers(volume: SweptVolume) -> tuple[PlaceLayer, ...]:
    """A swept volume as few prisms: those of the same heights united."""
    by_heights: dict[tuple[float, float], list[BaseGeometry]] = {}
    for prism in volume.prisms:
        heights = round(prism.low_m, HEIGHT_DIGITS), round(prism.high_m, HEIGHT_DIGITS)
        outline = shapely.make_valid(Polygon(prism.polygon.outline_m, prism.polygon.holes_m))
        by_heights.setdefault(heights, []).append(outline)
    layers: list[PlaceLayer] = []
    for (low, high), outlines in sorted(by_heights.items()):
        parts: list[object] = shapely.get_parts(shapely.union_all(outlines)).tolist()
        layers += [PlaceLayer(low, high, part) for part in parts if isinstance(part, Polygon) and part.area > 0.0]
    return tuple(layers)


def _moved_layer(M: FloatArray, layer: PlaceLayer) -> PlaceLayer:
    a, b, c, d = float(M[0, 0]), float(M[0, 1]), float(M[1, 0]), float(M[1, 1])
    area = affine_transform(layer.polygon, [a, b, c, d, float(M[0, 3]), float(M[1, 3])])
    assert isinstance(area, Polygon), "a rotation keeps polygons"
    rise = float(M[2, 3])
    return PlaceLayer(layer.low_m + rise, layer.high_m + rise, area)


def _carried_by(mechanism: Mechanism, joint: str) -> tuple[str, ...]:
    """The links that move when a joint does: its child, what that carries, and what followers carry."""
    moved = {one.child for one in mechanism.tree if one.name in {joint, *_followers(mechanism, joint)}}
    parent = {one.child: one.parent for one in mechanism.tree}
    moved |= {link.name for link in mechanism.links if not moved.isdisjoint(_chain(link.name, parent))}
    return tuple(link.name for link in mechanism.links if link.name in moved)


def _is_opened_by(moved: Sequence[str], closing: MechanismJoint) -> bool:
    """Whether a motion of some links alone would open the loop that a joint closes."""
    return (closing.parent in moved) != (closing.child in moved)


def _chain(link: str, parent: Mapping[str, str]) -> Iterator[str]:
    """A link and those that carry it."""
    while True:
        yield link
        if link not in parent:
            return
        link = parent[link]


def _followers(mechanism: Mechanism, joint: str) -> frozenset[str]:
    """Joints that follow a joint, directly or through others."""
    names: set[str] = set()
    while more := {
        one.name
        for one in mechanism.joints
        if one.coupling is not None and one.coupling.joint in {joint, *names} and one.name not in names
    }:
        names |= more
    return frozenset(names)


def _unknown(posed: PosedAsset, joint: str, reason: str) -> InvalidInput:
    headline = f"the space that `{joint}` of `{posed.asset_id}` sweeps is not known: {reason}"
    return InvalidInput(finding("scene/no-swept-volume", headline, value=joint))
