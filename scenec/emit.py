"""A solved problem as a scene in the world: poses from the background outwards, prisms that anyone can check."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from geom.pose import matrix_of, pose, quat_of
from scenec.ir import WORLD_PARENT, Body, FloatArray, Placement, Problem, Stance, Thing
from schemas.compiled_scene import CompiledScene, PlacedObject, Prism
from schemas.scene_program import BoxAsset, CylinderAsset, Inline, SphereAsset

_DIGITS = 9  # Nanometres: what is left of two ways to add the same lengths.


def compiled_scene(problem: Problem, placements: Mapping[str, Placement], seed: int) -> CompiledScene:
    """The whole scene of `problem` in the world frame. Raises KeyError when a thing has no placement: never partial."""
    frames = world_frames(problem, placements)
    things = {thing.name: thing for thing in problem.things}
    stances = {name: thing.body.stances[placements[name].stance] for name, thing in things.items()}
    if problem.background is not None:
        stances = {WORLD_PARENT: problem.background.stances[0], **stances}
    quats = _quats_wxyz(stances, frames)
    placed = {
        name: _placed(name, thing.body, stances[name], frames[name], quats[name], thing)
        for name, thing in things.items()
    }
    behind = None
    if problem.background is not None:
        at = WORLD_PARENT
        behind = _placed(at, problem.background, stances[at], frames[at], quats[at])
    return CompiledScene(
        scene=problem.scene,
        seed=seed,
        combination=problem.combination,
        background=behind,
        objects=tuple(placed.values()),
        clearance_m=problem.clearance_m,
    )


def world_frames(problem: Problem, placements: Mapping[str, Placement]) -> dict[str, FloatArray]:
    """X_WU (4, 4) of the background and every thing: origin of its asset frame, turned by its yaw alone.

    U are the axes that things on it are placed in; those of the asset frame itself lie `stance.quat_wxyz` further.
    """
    things = {thing.name: thing for thing in problem.things}
    frames = {WORLD_PARENT: np.asarray(problem.X_WB, dtype=np.float64)}

    def frame(name: str) -> FloatArray:
        if name not in frames:
            thing = things[name]
            frames[name] = frame(thing.parent) @ _in_parent(thing, placements[name])
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


def _quats_wxyz(stances: Mapping[str, Stance], frames: Mapping[str, FloatArray]) -> dict[str, list[float]]:
    """Orientation of each asset frame in the world, all in one call: it is the call that costs."""
    if not stances:
        return {}
    R_WU = np.stack([frames[name][:3, :3] for name in stances])
    R_UP = matrix_of(np.array([stance.quat_wxyz for stance in stances.values()]))
    return dict(zip(stances, quat_of(R_WU @ R_UP).tolist(), strict=True))


def _placed(
    name: str, body: Body, stance: Stance, X_WU: FloatArray, quat_wxyz: list[float], thing: Thing | None = None
) -> PlacedObject:
    inline: Inline | None = body.inline if isinstance(body.inline, BoxAsset | CylinderAsset | SphereAsset) else None
    w, x, y, z = (_rounded(q) for q in quat_wxyz)
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
