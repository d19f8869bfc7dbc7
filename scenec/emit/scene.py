"""A solved problem as a scene in the world: poses from the background outwards, prisms that anyone can check."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

import numpy as np

from geom.pose import pose
from scenec.ir.derivation_cache import Memo
from scenec.ir.problem import WORLD_PARENT, Body, FloatArray, Placement, Problem, Stance, Thing
from schemas.scene.compiled import CompiledScene, PlacedObject, Prism
from schemas.scene.program import BoxAsset, CylinderAsset, Inline, SphereAsset

_DIGITS = 9  # Nanometres: what is left of two ways to add the same lengths.
_NO_PART = 1e-12  # of a unit quaternion: rounding


def compiled_scene(
    problem: Problem, placements: Mapping[str, Placement], seed: int, memo: Memo | None = None
) -> CompiledScene:
    """The whole scene of `problem` in the world frame. Raises KeyError when a thing has no placement: never partial.

    What stands as it did when `memo` saw it is taken from there.
    """
    memo = memo or Memo()
    frames = world_frames(problem, placements, memo)
    bodies: dict[str, tuple[Thing | None, Body, Stance]] = {
        thing.name: (thing, thing.body, thing.body.stances[placements[thing.name].stance]) for thing in problem.things
    }
    if problem.background is not None:
        bodies[WORLD_PARENT] = None, problem.background, problem.background.stances[0]
    placed = {
        name: memo.get(
            ("placed", problem.key, name),
            partial(_placed, name, body, stance, frames[name], thing),
            *(thing or body, stance, frames[name]),
        )
        for name, (thing, body, stance) in bodies.items()
    }
    behind = placed.pop(WORLD_PARENT, None)
    return CompiledScene(
        scene=problem.scene,
        seed=seed,
        combination=problem.combination,
        background=behind,
        objects=tuple(placed.values()),
        clearance_m=problem.clearance_m,
    )


def world_frames(
    problem: Problem, placements: Mapping[str, Placement], memo: Memo | None = None
) -> dict[str, FloatArray]:
    """X_WU (4, 4) of the background and every thing: origin of its asset frame, turned by its yaw alone.

    U are the axes that things on it are placed in; those of the asset frame itself lie `stance.quat_wxyz` further.
    """
    things = {thing.name: thing for thing in problem.things}
    memo = memo or Memo()
    X_WB = np.asarray(problem.X_WB, dtype=np.float64)
    frames = {WORLD_PARENT: memo.get(("frame", X_WB.tobytes()), lambda: X_WB)}

    def frame(name: str) -> FloatArray:
        if name not in frames:
            thing, at, X_WP = things[name], placements[name], frame(things[name].parent)
            frames[name] = memo.get(("frame", problem.key, name), lambda: X_WP @ _in_parent(thing, at), thing, at, X_WP)
        return frames[name]

    for name in things:
        frame(name)
    return frames


def _in_parent(thing: Thing, placement: Placement) -> FloatArray:
    """X_PU (4, 4) of a placed thing."""
    over_m = placement.base_m + thing.body.stances[placement.stance].origin_height_m
    p_A = np.array([placement.x_m, placement.y_m, over_m])
    cosine, sine = np.cos(placement.yaw_rad), np.sin(placement.yaw_rad)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return pose(turn, np.asarray(thing.place.origin_P_m, dtype=np.float64) + p_A)


def _placed(name: str, body: Body, stance: Stance, X_WU: FloatArray, thing: Thing | None) -> PlacedObject:
    inline: Inline | None = body.inline if isinstance(body.inline, BoxAsset | CylinderAsset | SphereAsset) else None
    w, x, y, z = (_rounded(q) for q in _quat_wxyz(stance, X_WU))
    return PlacedObject(
        id=name,
        asset_id=body.asset_id,
        package=body.package,
        position_m=(_rounded(X_WU[0, 3]), _rounded(X_WU[1, 3]), _rounded(X_WU[2, 3])),
        quat_wxyz=(w, x, y, z),
        scale=body.scale,
        parent="" if thing is None else thing.parent,
        anchor="" if thing is None else thing.place.name,
        prisms=prisms(stance, X_WU),
        semantic_tags=() if thing is None else thing.tags,
        primitive=inline,
        mass_kg=body.mass_kg,
    )


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
    made = []
    for slab in stance.slabs:
        outline = slab.outline_m @ X_WU[:2, :2].T + X_WU[:2, 3]
        made.append(
            Prism(
                outline_m=tuple((_rounded(x), _rounded(y)) for x, y in outline.tolist()),
                low_m=_rounded(floor_m + slab.low_m),
                high_m=_rounded(floor_m + slab.high_m),
            )
        )
    return tuple(made)


def _rounded(value: float) -> float:
    return round(float(value), _DIGITS) + 0.0  # + 0.0: no negative zero.
