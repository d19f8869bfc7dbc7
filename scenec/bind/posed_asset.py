"""An articulated asset at a joint state: its rigid body, the anchors that moved along, the space that a joint sweeps.

Frame P is the asset frame, in which the root link stays where it is at rest. Metres, radians.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from shapely import Polygon
from shapely.affinity import affine_transform
from shapely.geometry.base import BaseGeometry

from geom.convex.circumscribed_hull import circumscribed_hull
from geom.mechanism_pose import joint_positions, link_motions
from geom.pose import apply
from scenec.bind.joint_states import JointState, all_positions, differs_from_rest
from schemas.anchors import Anchor, AnchorPolygon, SupportSurface
from schemas.arrays import FloatArray
from schemas.articulation import JointUse, SweptVolume
from schemas.diagnostics import InvalidInput, finding
from schemas.mechanism import Mechanism
from schemas.physics import RigidBody
from schemas.scene.geometry import PlaceLayer
from usdio.reread.body import Linkage

TILT_DEG = 0.5  # of an anchor that still counts as level: 4 mm over half a metre, the step of a floor (bind.anchors)
SWEPT_TILT_DEG = 0.01  # of a swept volume, which must cover the motion: 0.1 mm over half a metre
FOOT_M = 1e-3  # height over the lowest point up to which an object stands on what it has there
HEIGHT_DIGITS = 9  # of the heights by which prisms of one swept volume are put together


@dataclass(frozen=True)
class PosedAsset:
    """A linkage at a state. `swept` are the swept volumes of its joints at rest, by joint."""

    asset_id: str
    linkage: Linkage
    state: JointState
    swept: Mapping[str, SweptVolume | None]

    @cached_property
    def moved(self) -> bool:
        """Whether any joint is elsewhere than at rest."""
        return differs_from_rest(self.linkage.mechanism, self.state)

    @cached_property
    def body(self) -> RigidBody:
        """The object as one body, its joints held."""
        return self.linkage.held(dict(self.state) if self.moved else None)

    @cached_property
    def positions(self) -> tuple[tuple[str, float], ...]:
        """(joint, position) of all joints."""
        return all_positions(self.linkage.mechanism, self.state)

    @cached_property
    def motions(self) -> dict[str, FloatArray]:
        """M (4, 4) by link: where the state takes points of the asset frame from where they are at rest."""
        return link_motions(self.linkage.mechanism, dict(self.state) if self.moved else {})

    def anchor(self, anchor: Anchor) -> Anchor | float:
        """The anchor where its link takes it, or by how many degrees it leans there, if that is too much to be level.

        What is free above a surface is then left to the collision shapes, since links may have come or gone. Raises
        InvalidInput (`scene/unusable-asset`) for an anchor on a link that the package does not have.
        """
        if anchor.link is not None and anchor.link not in self.motions:
            headline = f"the package `{self.asset_id}` cannot be used: its record names a link `{anchor.link}`"
            raise InvalidInput(finding("scene/unusable-asset", headline, value=anchor.anchor_id))
        if not self.moved:
            return anchor
        M = np.eye(4) if anchor.link is None else self.motions[anchor.link]
        lean_deg = _lean_deg(M)
        if lean_deg > TILT_DEG:
            return lean_deg
        position = _triple(apply(M, np.array([anchor.position_m]))[0])
        if isinstance(anchor, SupportSurface):
            shift, polygon = _turned(M, (anchor.polygon,), anchor.polygon)
            update = {"polygon": polygon[0], "clearance_m": None}
        else:
            layers = [polygon for part in anchor.slices for polygon in part.polygons]
            shift, polygons = _turned(M, (anchor.opening, *layers), anchor.opening)
            rest = iter(polygons[1:])
            slices = tuple(
                part.model_copy(update={"polygons": tuple(next(rest) for _ in part.polygons)}) for part in anchor.slices
            )
            update = {"opening": polygons[0], "slices": slices}
        x, y, z = position
        return anchor.model_copy(update={**update, "position_m": (x + shift[0], y + shift[1], z)})

    def keep_clear(self, joint: str) -> tuple[tuple[str, ...], tuple[PlaceLayer, ...]]:
        """The links that a joint moves, and the space in P that they sweep.

        Raises InvalidInput (`scene/no-swept-volume`) where it is not known for this state.
        """
        mechanism = self.linkage.mechanism
        volume = self.swept.get(joint)
        if volume is None:
            reason = (
                "the record of the asset has none" if joint not in self.swept else "its links have no collision shape"
            )
            raise _no_volume(self.asset_id, joint, reason)
        carrier = {one.child: one for one in mechanism.tree}
        moved = _carried_by(mechanism, joint)
        positions = joint_positions(mechanism, dict(self.state))
        rest = joint_positions(mechanism, {})
        tied = {joint, *_followers(mechanism, joint)}
        off = {name for name, position in positions.items() if abs(position - rest[name]) > 1e-9} - tied
        if inner := sorted(name for link in moved if (name := carrier[link].name) in off):
            raise _no_volume(
                self.asset_id, joint, f"it is known with all other joints at rest, and `{inner[0]}` is not"
            )
        parent = next(one.parent for one in mechanism.tree if one.name == joint)
        M = self.motions[parent]
        if _lean_deg(M) > SWEPT_TILT_DEG:
            raise _no_volume(self.asset_id, joint, f"it leans with `{parent}`")
        layers = tuple(_moved_layer(M, layer) for layer in _layers(volume))
        if not layers:
            raise _no_volume(self.asset_id, joint, "the record of the asset has an empty one")
        return moved, layers

    def beyond_feet_m(self) -> float:
        """How far the mass centre is beyond what the object stands on, negative inside."""
        return beyond_feet_m(self.body)


def swept_volumes(uses: Sequence[JointUse]) -> dict[str, SweptVolume | None]:
    """The swept volume of each joint of a record."""
    return {use.joint: use.swept for use in uses}


def beyond_feet_m(body: RigidBody) -> float:
    """How far (m) the mass centre of a body is outside the hull of its lowest points, negative inside."""
    points = np.concatenate([circumscribed_hull(shape) for shape in body.shapes])
    feet = points[points[:, 2] <= points[:, 2].min() + FOOT_M]
    hull = shapely.MultiPoint(feet[:, :2]).convex_hull
    middle = shapely.Point(np.asarray(body.mass.centre_of_mass_m)[:2])
    outside = float(hull.distance(middle))
    return outside if outside > 0.0 else -float(hull.boundary.distance(middle))


def _lean_deg(M: FloatArray) -> float:
    """How far a motion turns the vertical."""
    return math.degrees(math.acos(min(max(float(M[2, 2]), -1.0), 1.0)))


def _turned(
    M: FloatArray, polygons: Sequence[AnchorPolygon], main: AnchorPolygon
) -> tuple[tuple[float, float], list[AnchorPolygon]]:
    """Polygons of an anchor along the axes of P after a motion, about the middle of the box of `main`, and where that
    middle lies from the origin of the anchor."""
    c, s = float(M[0, 0]), float(M[1, 0])
    length = math.hypot(c, s)
    c, s = c / length, s / length
    if abs(s) < 1e-12 and c > 0.0:
        return (0.0, 0.0), list(polygons)
    outline = np.array(_rotated(main, c, s, (0.0, 0.0)).outline_m)
    low, high = outline.min(axis=0), outline.max(axis=0)
    x, y = (0.5 * (low + high)).tolist()
    return (x, y), [_rotated(polygon, c, s, (x, y)) for polygon in polygons]


def _rotated(polygon: AnchorPolygon, c: float, s: float, origin: tuple[float, float]) -> AnchorPolygon:
    def ring(points: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
        return tuple((c * x - s * y - origin[0], s * x + c * y - origin[1]) for x, y in points)

    return AnchorPolygon(outline_m=ring(polygon.outline_m), holes_m=tuple(map(ring, polygon.holes_m)))


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


def _triple(point: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in point)
    return x, y, z


def _no_volume(asset_id: str, joint: str, reason: str) -> InvalidInput:
    headline = f"the space that `{joint}` of `{asset_id}` sweeps is not known: {reason}"
    return InvalidInput(finding("scene/no-swept-volume", headline, value=joint))
