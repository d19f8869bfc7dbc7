"""Emits a solved problem as a scene document in the world frame: poses, and prisms that anyone can check."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

import numpy as np

from geom.convex_outlines import convex_outlines
from geom.pose import pose
from scenec.ir.derivation_cache import DerivationCache
from scenec.ir.problem import Body, Placement, Problem, Thing
from schemas.arrays import FloatArray
from schemas.scene.compiled import ClearedSpace, CompiledScene, PlacedObject
from schemas.scene.geometry import BACKGROUND, KeepClear, Prism, ScenePlace, Stance, rounded_value
from schemas.scene.program import BoxAsset, CylinderAsset, Inline, SphereAsset

_NO_PART = 1e-12  # of a unit quaternion: rounding


def compiled_scene(
    problem: Problem, placements: Mapping[str, Placement], seed: int, derivations: DerivationCache | None = None
) -> CompiledScene:
    """The whole scene of `problem` in the world frame. Raises KeyError when a thing has no placement: never partial.

    Objects whose pose and body are unchanged are taken from `derivations`.
    """
    derivations = derivations or DerivationCache()
    frames = world_frames(problem, placements, derivations)
    bodies: dict[str, tuple[Thing | None, Body, Stance]] = {
        thing.name: (thing, thing.body, thing.body.resting_orientations[placements[thing.name].stance])
        for thing in problem.things
        if not thing.is_frame
    }
    if problem.background is not None:
        bodies[BACKGROUND] = None, problem.background, problem.background.resting_orientations[0]
    placed = {
        name: derivations.get(
            ("placed", problem.key, name),
            partial(_placed, name, body, stance, frames[name], thing, problem.standing_on(thing) if thing else None),
            *(thing or body, stance, frames[name]),
        )
        for name, (thing, body, stance) in bodies.items()
    }
    behind = placed.pop(BACKGROUND, None)
    return CompiledScene(
        scene=problem.scene,
        seed=seed,
        combination=problem.combination,
        background=behind,
        objects=tuple(placed.values()),
        clearance_m=problem.clearance_m,
        keep_clear=tuple(_cleared(space, frames[space.owner]) for space in problem.keep_clear),
    )


def world_frames(
    problem: Problem, placements: Mapping[str, Placement], derivations: DerivationCache | None = None
) -> dict[str, FloatArray]:
    """X_WU (4, 4) of the background and every thing: origin of its asset frame, turned by its yaw alone.

    Things on it are placed along the axes U; the asset frame itself is turned by `stance.quat_wxyz` from U.
    """
    things = {thing.name: thing for thing in problem.things}
    derivations = derivations or DerivationCache()
    X_WB = np.asarray(problem.X_WB, dtype=np.float64)
    frames = {BACKGROUND: derivations.get(("frame", X_WB.tobytes()), lambda: X_WB)}

    def frame(name: str) -> FloatArray:
        if name not in frames:
            thing, at, X_WP = things[name], placements[name], frame(things[name].parent)
            frames[name] = derivations.get(
                ("frame", problem.key, name), lambda: X_WP @ _in_parent(thing, at), thing, at, X_WP
            )
        return frames[name]

    for name in things:
        frame(name)
    return frames


def _in_parent(thing: Thing, placement: Placement) -> FloatArray:
    """X_PU (4, 4) of a placed thing."""
    over_m = placement.base_m + thing.body.resting_orientations[placement.stance].origin_height_m
    p_A = np.array([placement.x_m, placement.y_m, over_m])
    cosine, sine = np.cos(placement.yaw_rad), np.sin(placement.yaw_rad)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return pose(turn, np.asarray(thing.place.origin_P_m, dtype=np.float64) + p_A)


def _placed(
    name: str,
    body: Body,
    stance: Stance,
    X_WU: FloatArray,
    thing: Thing | None,
    standing_on: tuple[str, ScenePlace] | None,
) -> PlacedObject:
    inline: Inline | None = body.inline if isinstance(body.inline, BoxAsset | CylinderAsset | SphereAsset) else None
    w, x, y, z = (rounded_value(q) for q in _quat_wxyz(stance, X_WU))
    return PlacedObject(
        id=name,
        asset_id=body.asset_id,
        package=body.package,
        position_m=(rounded_value(X_WU[0, 3]), rounded_value(X_WU[1, 3]), rounded_value(X_WU[2, 3])),
        quat_wxyz=(w, x, y, z),
        scale=body.scale,
        parent="" if standing_on is None else standing_on[0],
        anchor="" if standing_on is None else standing_on[1].name,
        prisms=prisms(stance, X_WU),
        semantic_tags=() if thing is None else thing.tags,
        primitive=inline,
        mass_kg=body.mass_kg,
        joints={joint: rounded_value(position) for joint, position in body.joints},
    )


def _cleared(space: KeepClear, X_WU: FloatArray) -> ClearedSpace:
    """A space that a joint sweeps in the world, as convex prisms."""
    prisms = [
        Prism(part, layer.low_m + float(X_WU[2, 3]), layer.high_m + float(X_WU[2, 3])).rounded()
        for layer in space.layers
        for part in (outline @ X_WU[:2, :2].T + X_WU[:2, 3] for outline in convex_outlines(layer.polygon))
    ]
    return ClearedSpace(owner=space.owner, joint=space.joint, prisms=tuple(prisms))


def _quat_wxyz(stance: Stance, X_WU: FloatArray) -> tuple[float, float, float, float]:
    """Orientation of the asset frame in the world: a turn about z after the stance, with its first part positive."""
    half = 0.5 * math.atan2(X_WU[1, 0], X_WU[0, 0])
    c, s = math.cos(half), math.sin(half)
    w, x, y, z = stance.quat_wxyz
    quat = (c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w)
    sign = math.copysign(1.0, next(part for part in quat if abs(part) > _NO_PART))
    a, b, d, e = (sign * part for part in quat)
    return a, b, d, e


def prisms(stance: Stance, X_WU: FloatArray) -> tuple[Prism, ...]:
    """The collision geometry of a stance in the world; `X_WU` turns about z alone, so that prisms stay prisms."""
    floor_m = float(X_WU[2, 3]) - stance.origin_height_m
    return tuple(
        Prism(prism.outline_m @ X_WU[:2, :2].T + X_WU[:2, 3], floor_m + prism.low_m, floor_m + prism.high_m).rounded()
        for prism in stance.prisms
    )
