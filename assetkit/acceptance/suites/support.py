"""Suite of supports: boxes set on it stay, and it bears a load at the middle and near the edge without tipping over.

For each verified surface, on the object as it stands loose on level ground: stacks of boxes at the middle and near the
edge; the load that tips it over, by geometry, and most of that load in simulation.
"""

from __future__ import annotations

import math

import numpy as np
import shapely

from assetkit.acceptance.settling import TOPPLED_RAD
from assetkit.acceptance.stable_poses import resting_pose
from assetkit.acceptance.suites.grasping import tiny
from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import CheckList, Conditions, Subject, SuiteRun, at_least, at_most
from assetkit.affordances.anchor_trials import BOX_OF_DISC
from assetkit.affordances.anchors import shape_of
from geom.convex.support_function import diagonal
from geom.convex.tipping import tipping_loads
from geom.pose import DOWN, pose
from schemas.anchors import SupportSurface
from schemas.arrays import FloatArray
from schemas.asset import Role
from schemas.diagnostics import Location
from schemas.physics import CollisionShape, RigidBody
from sim.loading import LoadTask, LooseProbe
from sim.port import Simulator, natural_time_s

_EDGE_PLACES = 24  # along the edge, of which the worst one is taken
_GAP = 0.02  # of its edge, from where a box is let go


class SupportSuite:
    """See the module."""

    name = "support"
    varies = True
    roles: frozenset[Role] = frozenset({"support"})
    codes = ("asset/support-no-surface", "asset/support-stack", "asset/support-tips")

    def obstacle(self, subject: Subject) -> str:
        """Contacts of engines are too coarse for the smallest objects."""
        return tiny(subject)

    def run(self, subject: Subject, simulator: Simulator, conditions: Conditions) -> SuiteRun:
        """The main surface and the next ones; an articulated object has its joints held at rest."""
        checks = CheckList(Location(file=subject.main_file.name))
        surfaces = [anchor for anchor in subject.anchors if anchor.kind == "surface"][: POLICY.surfaces]
        count = at_least("surfaces", len(surfaces), 1, "")
        checks.add("asset/support-no-surface", "it is to carry things, but has no surface that does", count)
        body = subject.under(conditions).body
        for surface in surfaces:
            trial = SurfaceTrial(body, surface, conditions.step_s)
            trial.stack(checks, simulator)
            for place in ("middle", "edge"):
                trial.load(checks, simulator, place)
        return checks.run()


class SurfaceTrial:
    """One surface of a body in its reference pose, and the places of boxes on it, in the frame of the body."""

    def __init__(self, body: RigidBody, surface: SupportSurface, step_s: float) -> None:
        self._body, self._name, self._step_s = body, surface.anchor_id, step_s
        self._X_WA = resting_pose(body, DOWN, gap_m=0.0)
        x, y, z = surface.position_m
        polygon = shape_of(surface.polygon, x, y)
        circle = shapely.maximum_inscribed_circle(polygon)
        size = diagonal(body.shapes)
        edge = min(POLICY.stack_edge * size, BOX_OF_DISC * 2.0 * float(circle.length))
        if surface.clearance_m is not None:
            edge = min(edge, surface.clearance_m / (0.5 * POLICY.stack + 4.0 * _GAP))
        self._edge, self._duration_s = edge, max(1.0, 8.0 * natural_time_s(size))
        middle = np.array([[*circle.coords[0], z]])
        rim = np.array([[*at, z] for at in _along_edge(polygon, math.sqrt(0.5) * edge)]).reshape(-1, 3)
        self._places = {"middle": middle, "edge": rim if len(rim) else middle}
        self._limits = {name: self._limit(places) for name, places in self._places.items()}

    def _limit(self, places: FloatArray) -> tuple[float, FloatArray]:
        """The least load (masses of the body) that tips it over at one of the places (k, 3), and the place (3,)."""
        mass_kg, centre = self._body.mass.mass_kg, np.asarray(self._body.mass.centre_of_mass_m)
        loads = tipping_loads(self._body.shapes, mass_kg, centre, DOWN, places) / mass_kg
        weakest = int(loads.argmin())
        return float(loads[weakest]), places[weakest]

    def stack(self, checks: CheckList, simulator: Simulator, code: str = "asset/support-stack") -> None:
        """A stack at the middle and one at the worst place near the edge, which weighs what that place must bear."""
        places = {name: at for name, (_, at) in self._limits.items()}
        if np.linalg.norm(places["edge"] - places["middle"]) < 1.5 * self._edge:
            del places["edge"]
        mass_kg = POLICY.load_edge * self._body.mass.mass_kg / POLICY.stack
        probes = [self._box(at, level, mass_kg) for at in places.values() for level in range(POLICY.stack)]
        outcome = simulator.load(self._body, LoadTask(self._X_WA, tuple(probes), self._duration_s, step_s=self._step_s))
        X_AP = outcome.probes_in_body()
        moved = np.linalg.norm(X_AP[-1, :, :3, 3] - X_AP[0, :, :3, 3], axis=1) / self._edge
        turned = np.degrees(np.arccos(np.clip(X_AP[-1, :, 2, 2], -1.0, 1.0)))
        checks.add(
            code, f"{self._name}: on it boxes diverge", at_least(f"{self._name}_finite", outcome.finite, 1.0, "")
        )
        for row, name in enumerate(places):
            part = slice(row * POLICY.stack, (row + 1) * POLICY.stack)
            far, lean = float(moved[part].max()), float(turned[part].max())
            where = f"{self._name}_{name}"
            headline = f"{self._name}: a stack at the {name} moves by {far * self._edge:.3g} m"
            checks.add(code, headline, at_most(f"{where}_stack_moved", far, POLICY.stack_share, "of a box"))
            headline = f"{self._name}: a stack at the {name} leans by {lean:.3g} deg"
            checks.add(code, headline, at_most(f"{where}_stack_lean", lean, math.degrees(POLICY.stack_rad), "deg"))

    def load(self, checks: CheckList, simulator: Simulator, place: str) -> None:
        """The load limit at a place, up to `POLICY.load_most`; most of that load must stand in simulation."""
        limit, at = self._limits[place]
        limit = min(limit, POLICY.load_most)
        least = POLICY.load_middle if place == "middle" else POLICY.load_edge
        code, where = "asset/support-tips", f"{self._name}_{place}"
        headline = f"{self._name}: at the {place} {limit:.3g} of its own mass tips it over"
        bears = at_least(f"{where}_load_limit", limit, least, "of own mass")
        checks.add(code, headline, bears)
        if not bears.passed:
            return
        load = POLICY.load_sure * limit
        box = self._box(at, 0, load * self._body.mass.mass_kg)
        outcome = simulator.load(self._body, LoadTask(self._X_WA, (box,), self._duration_s, step_s=self._step_s))
        turned = math.degrees(outcome.turn_rad()) if outcome.finite else 180.0
        headline = f"{self._name}: under {load:.3g} of its own mass at the {place} it falls over"
        checks.add(code, headline, at_most(f"{where}_load_tilt", turned, math.degrees(TOPPLED_RAD), "deg"))

    def _box(self, at: FloatArray, level: int, mass_kg: float) -> LooseProbe:
        """The box on so many others at a place (3,), in the world."""
        tall = 0.5 * self._edge
        up = (level + 0.5) * tall + (level + 1) * _GAP * self._edge
        shape = CollisionShape(
            "box", (self._edge, self._edge, tall), self._X_WA @ pose(None, at + np.array([0.0, 0.0, up]))
        )
        return LooseProbe(shape, mass_kg)


def _along_edge(polygon: shapely.Polygon, margin_m: float) -> list[tuple[float, float]]:
    """Places spread along the outline of what is `margin_m` within the polygon; none where nothing is."""
    inner = polygon.buffer(-margin_m)
    if inner.is_empty:
        return []
    outline = max(shapely.get_parts(inner), key=shapely.area).exterior
    shares = np.arange(_EDGE_PLACES) / _EDGE_PLACES
    return [(p.x, p.y) for p in outline.interpolate(shares, normalized=True)]
