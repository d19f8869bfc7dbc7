"""An articulated asset at a joint state: its rigid body, and the anchors that moved along.

Frame P is the asset frame, in which the root link stays where it is at rest. Metres, radians.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from geom.convex.circumscribed_hull import circumscribed_hull
from geom.mechanism_pose import link_motions
from geom.pose import apply
from scenec.bind.joint_states import JointState, all_positions, differs_from_rest
from schemas.anchors import Anchor, AnchorPolygon, SupportSurface
from schemas.arrays import FloatArray
from schemas.articulation import JointUse, SweptVolume
from schemas.diagnostics import InvalidInput, finding
from schemas.physics import RigidBody
from usdio.reread.body import Linkage

TILT_DEG = 0.5  # of an anchor that still counts as level: 4 mm over half a metre, the step of a floor (bind.anchors)
FOOT_M = 1e-3  # height over the lowest point up to which an object stands on what it has there


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
        return self.linkage.held(dict(self.positions) if self.moved else None)

    @cached_property
    def positions(self) -> tuple[tuple[str, float], ...]:
        """(joint, position) of all joints."""
        return all_positions(self.linkage.mechanism, self.state)

    @cached_property
    def motions(self) -> dict[str, FloatArray]:
        """M (4, 4) by link: where the state takes points of the asset frame from where they are at rest."""
        mechanism = self.linkage.mechanism
        if not self.moved:
            return {link.name: np.eye(4) for link in mechanism.links}
        return link_motions(mechanism, dict(self.positions))

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
        if (leaning_deg := lean_deg(M)) > TILT_DEG:
            return leaning_deg
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


def lean_deg(M: FloatArray) -> float:
    """How far (degrees) a motion (4, 4) turns the vertical."""
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


def _triple(point: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in point)
    return x, y, z
