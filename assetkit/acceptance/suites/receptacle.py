"""Suite of receptacles: things dropped in stay in and go through no wall; with content it stands, also on a slope.

Each verified volume is exercised with balls and boxes: let go above the rim, fast onto the floor, and shoved against
the walls, over the object held still, each probe for itself; then with content, standing loose on the ground. Of an
object with joints, which is held by its base, the link that the volume belongs to is exercised, without the others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from assetkit.acceptance.settling import TOPPLED_RAD
from assetkit.acceptance.stable_poses import resting_pose
from assetkit.acceptance.suites.grasping import tiny
from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import CheckList, Conditions, Subject, SuiteRun, at_least, at_most
from assetkit.acceptance.suites.support import SurfaceTrial
from assetkit.affordances.anchor_trials import BALL_OF_HEIGHT, OFF_SHARE, opens_up, spread_positions
from assetkit.affordances.inside import Inside
from geom.convex.placement import moved_shape
from geom.convex.support_function import bounds, diagonal
from geom.convex.tipping import tipping_angle
from geom.pose import DOWN, inverse, pose
from schemas.anchors import ContainmentVolume
from schemas.arrays import FloatArray
from schemas.asset import Role
from schemas.diagnostics import Location
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import CollisionShape, RigidBody
from sim.loading import LoadOutcome, LoadTask, LooseProbe
from sim.port import Simulator, model_scale, natural_time_s

_DROP_PLACES = 5  # over an opening, and of content
_PROBE_KGPM3 = 1000.0
_STEP_SHARE = 0.5  # of its radius, by which the smallest thing may fall in a step: less than half of a box in that ball


class ReceptacleSuite:
    """See the module."""

    name = "receptacle"
    varies = True
    roles: frozenset[Role] = frozenset({"receptacle"})
    codes = (
        "asset/receptacle-no-volume",
        "asset/receptacle-leaves",
        "asset/receptacle-tunnel",
        "asset/receptacle-spill",
        "asset/receptacle-tips",
    )

    def obstacle(self, subject: Subject) -> str:
        """Contacts of engines are too coarse for the smallest objects."""
        return tiny(subject)

    def run(self, subject: Subject, simulator: Simulator, conditions: Conditions) -> SuiteRun:
        """Each volume, the largest first; what has none, as a plate, holds things on its main surface."""
        checks = CheckList(Location(file=subject.main_file.name))
        volumes = [anchor for anchor in subject.anchors if anchor.kind == "volume"]
        volumes = sorted(volumes, key=lambda v: -v.volume_m3)[: POLICY.volumes]
        surfaces = [anchor for anchor in subject.anchors if anchor.kind == "surface"]
        if not volumes and surfaces and not subject.is_articulated:
            trial = SurfaceTrial(subject.under(conditions).body, surfaces[0], conditions.step_s)
            trial.stack(checks, simulator, "asset/receptacle-leaves")
            return checks.run()
        count = at_least("volumes", len(volumes), 1, "")
        checks.add("asset/receptacle-no-volume", "it is to hold things, but has no volume or surface that does", count)
        varied = subject.under(conditions)
        for volume in volumes:
            if conditions.mass_kg is None and conditions.friction is None:  # Walls are where they are at any.
                _fixed_trials(checks, _carrier(varied, volume), volume, simulator, conditions.step_s)
            if not subject.is_articulated:
                _loose_trials(checks, varied.body, volume, simulator, conditions.step_s)
        return checks.run()


def _carrier(subject: Subject, volume: ContainmentVolume) -> RigidBody:
    """The link that a volume belongs to, at rest in the frame of the asset; else the whole object."""
    content = subject.content
    if content.mechanism is not None:
        for link, body in zip(content.mechanism.links, content.links, strict=True):
            if link.name == volume.link and body.shapes:
                return replace(body, shapes=tuple(moved_shape(s, pose(None, link.origin)) for s in body.shapes))
    return content.body


def _fixed_trials(
    checks: CheckList, body: RigidBody, volume: ContainmentVolume, simulator: Simulator, step_s: float
) -> None:
    """Drops, then fast drops and shoves, over the body held still, in the frame of the asset."""
    inside, size = Inside(volume), diagonal(body.shapes)
    radii, name, off = _radii(volume, size), volume.anchor_id, _off(body)
    fall_s = math.sqrt(2.0 * volume.height_m / GRAVITY_MPS2)
    duration_s = 5.0 * natural_time_s(size) + fall_s

    def paths(probes: Sequence[LooseProbe], step_s: float) -> FloatArray:
        """Centres (k, n, 3) at each step."""
        task = LoadTask(np.eye(4), tuple(probes), duration_s, is_fixed=True, step_s=step_s)
        return simulator.load(body, task).X_WP[..., :3, 3]

    # What falls from the rim must not come through the floor because it is small: that is what fast ones are for.
    root = math.sqrt(model_scale(size))
    fine_s = min(step_s, root * _STEP_SHARE * radii[-1] / (GRAVITY_MPS2 * fall_s))
    dropped = paths([probe for radius in radii for probe in _drops(inside, radius)], fine_s)
    stay = inside.contains(dropped[-1], off)
    headline = f"{name}: {int(stay.sum())} of {len(stay)} things let go above it stay in it"
    staying = at_least(f"{name}_staying", float(stay.mean()), POLICY.stay_share, "of the probes")
    checks.add("asset/receptacle-leaves", headline, staying)
    if not opens_up(volume):  # Things may roll out of it.
        return
    forced = paths(_forced(inside, radii, step_s / root), step_s)
    count = sum(int(inside.left_through_wall(path, off).sum()) for path in (dropped, forced))
    headline = f"{name}: {count} of {dropped.shape[1] + forced.shape[1]} things go through a wall or the floor"
    checks.add("asset/receptacle-tunnel", headline, at_most(f"{name}_tunnelling", count, 0, "probes"))


def _drops(inside: Inside, radius: float) -> list[LooseProbe]:
    """A ball and a box at each of several places, just above the rim; on the floor behind an opening that is level."""
    volume = inside.volume
    places = spread_positions(inside.opening, 1.5 * radius, 1.5 * radius)[:_DROP_PLACES]
    z = volume.position_m[2] + 1.2 * radius + (volume.height_m if opens_up(volume) else 0.0)
    edge = 2.0 * radius / math.sqrt(3.0)
    return [
        _loose(shape)
        for x, y in places
        for shape in (
            CollisionShape("sphere", (radius,), pose(None, (x, y, z))),
            CollisionShape("box", (edge, edge, edge), pose(None, (x, y, z))),
        )
    ]


def _forced(inside: Inside, radii: Sequence[float], step_s: float) -> list[LooseProbe]:
    """Balls that come down fast at the innermost place, and balls that are shoved to four sides from there.

    A shove is too slow to climb more than half of the way to the rim.
    """
    volume = inside.volume
    rim_m = volume.position_m[2] + volume.height_m
    forced: list[LooseProbe] = []
    for radius in radii:
        x, y = spread_positions(inside.opening, radius, math.inf)[0]
        rest_m = inside.resting_height((x, y), radius)
        fastest = (radius + 0.5 * POLICY.wall_m) / step_s
        arrival = min(math.sqrt(2.0 * GRAVITY_MPS2 * POLICY.fall_heights * volume.height_m), fastest)
        above = min(rim_m + 1.2 * radius - rest_m, 0.5 * arrival**2 / GRAVITY_MPS2)
        fall = math.sqrt(max(arrival**2 - 2.0 * GRAVITY_MPS2 * above, 0.0))
        for phase in range(POLICY.phases):
            z = rest_m + above + phase / POLICY.phases * arrival * step_s
            ball = CollisionShape("sphere", (radius,), pose(None, (x, y, z)))
            forced.append(_loose(ball, (0.0, 0.0, -fall)))
        shove = min(math.sqrt(GRAVITY_MPS2 * max(rim_m - rest_m, 0.0)), fastest)
        ball = CollisionShape("sphere", (radius,), pose(None, (x, y, rest_m)))
        forced += [_loose(ball, (shove * sx, shove * sy, 0.0)) for sx, sy in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    return forced


def _loose_trials(
    checks: CheckList, body: RigidBody, volume: ContainmentVolume, simulator: Simulator, step_s: float
) -> None:
    """Content in the object as it stands on level ground, then on ground that is as steep as it must bear."""
    inside, name, size = Inside(volume), volume.anchor_id, diagonal(body.shapes)
    X_WA = resting_pose(body, DOWN, gap_m=0.0)
    content = _content(inside, _radii(volume, size)[0], X_WA)
    duration_s = max(1.0, 8.0 * natural_time_s(size))
    level = simulator.load(body, LoadTask(X_WA, content, duration_s, step_s=step_s))
    turned = math.degrees(level.turn_rad()) if level.finite else 180.0
    code = "asset/receptacle-spill"
    tilt = at_most(f"{name}_content_tilt", turned, math.degrees(TOPPLED_RAD), "deg")
    checks.add(code, f"{name}: with content in it, it leans by {turned:.3g} deg", tilt)
    held = inside.contains(level.probes_in_body()[-1, :, :3, 3], _off(body))
    stays_in = at_least(f"{name}_content_kept", float(held.mean()), 1.0, "of the content")
    checks.add(code, f"{name}: {int(held.sum())} of {len(held)} things in it stay while it stands", stays_in)
    empty, empty_side = tipping_angle(body.shapes, np.asarray(body.mass.centre_of_mass_m), DOWN, TOPPLED_RAD)
    full, full_side = tipping_angle(body.shapes, _centre_with(body, content, level), DOWN, TOPPLED_RAD)
    code, most = "asset/receptacle-tips", math.degrees(POLICY.tip_rad)
    for state, angle in (("empty", empty), ("full", full)):
        bears = at_least(f"{name}_tipping_{state}", math.degrees(angle), most, "deg")
        checks.add(code, f"{name}: {state}, it tips over on a slope of {math.degrees(angle):.3g} deg", bears)
    if min(empty, full) < POLICY.tip_rad or not level.finite:
        return
    ended = tuple(
        LooseProbe(CollisionShape(p.shape.kind, p.shape.size_m, X_WP), p.mass_kg)
        for p, X_WP in zip(content, level.X_WP[-1], strict=True)
    )
    for state, probes, side in (("empty", (), empty_side), ("full", ended, full_side)):
        start = X_WA if state == "empty" else level.X_WA[-1]
        pull = GRAVITY_MPS2 * (math.sin(POLICY.tip_rad) * (start[:3, :3] @ side) + math.cos(POLICY.tip_rad) * DOWN)
        gravity = (float(pull[0]), float(pull[1]), float(pull[2]))
        slope = simulator.load(body, LoadTask(start, probes, duration_s, gravity_mps2=gravity, step_s=step_s))
        turned = math.degrees(slope.turn_rad()) if slope.finite else 180.0
        stands = at_most(f"{name}_slope_tilt_{state}", turned, math.degrees(TOPPLED_RAD), "deg")
        checks.add(code, f"{name}: {state}, it falls over on a slope of {most:.3g} deg", stands)


def _content(inside: Inside, radius: float, X_WA: FloatArray) -> tuple[LooseProbe, ...]:
    """Balls side by side on the floor, in the world, which weigh together what content weighs."""
    volume = inside.volume
    places = spread_positions(inside.opening, 1.2 * radius, 2.4 * radius)[:_DROP_PLACES]
    mass_kg = POLICY.content_kgpm3 * volume.volume_m3 / len(places)
    centres = [(x, y, inside.resting_height((x, y), radius)) for x, y in places]
    return tuple(LooseProbe(CollisionShape("sphere", (radius,), X_WA @ pose(None, c)), mass_kg) for c in centres)


def _centre_with(body: RigidBody, content: Sequence[LooseProbe], level: LoadOutcome) -> FloatArray:
    """(3,) mass centre of the body and what is in it, in the frame of the body, at the end."""
    masses = np.array([probe.mass_kg for probe in content])
    centres = (inverse(level.X_WA[-1]) @ level.X_WP[-1])[:, :3, 3]
    moment_kgm = body.mass.mass_kg * np.asarray(body.mass.centre_of_mass_m)
    return (moment_kgm + masses @ centres) / (body.mass.mass_kg + masses.sum())


def _radii(volume: ContainmentVolume, size: float) -> list[float]:
    """Of large and of small balls for an object of that size; small ones fit into no gap that colliders may have."""
    large, small = (share * 0.5 * volume.passes_m for share in POLICY.ball_shares)
    large = min(large, BALL_OF_HEIGHT * volume.height_m)
    return [large, min(max(small, 0.5 * OFF_SHARE * size), large)]


def _off(body: RigidBody) -> float:
    return OFF_SHARE * diagonal(body.shapes)


def _loose(shape: CollisionShape, velocity_mps: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> LooseProbe:
    low, high = bounds([shape])
    return LooseProbe(shape, _PROBE_KGPM3 * float(np.prod(high - low)), velocity_mps)
