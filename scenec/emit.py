"""A solved problem as a scene in the world: poses from the background outwards, prisms that anyone can check."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from geom.pose import apply, matrix_of, pose, quat_of
from scenec.ir import WORLD_PARENT, Body, FloatArray, Placement, Problem, Stance, Thing
from schemas.compiled_scene import CompiledScene, PlacedObject, Prism
from schemas.scene_program import BoxAsset, CylinderAsset, Inline, SphereAsset

_DIGITS = 9  # Nanometres: what is left of two ways to add the same lengths.


def compiled_scene(problem: Problem, placements: Mapping[str, Placement], seed: int) -> CompiledScene:
    """The whole scene of `problem` in the world frame. Raises KeyError when a thing has no placement: never partial."""
    frames = world_frames(problem, placements)
    background = problem.background
    return CompiledScene(
        scene=problem.scene,
        seed=seed,
        combination=problem.combination,
        background=None
        if background is None
        else _placed(WORLD_PARENT, background, background.stances[0], frames[WORLD_PARENT], "", ""),
        objects=tuple(
            _placed(
                thing.name,
                thing.body,
                thing.body.stances[placements[thing.name].stance],
                frames[thing.name],
                thing.parent,
                thing.place.name,
                thing.tags,
            )
            for thing in problem.things
        ),
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


def _placed(
    name: str, body: Body, stance: Stance, X_WU: FloatArray, parent: str, anchor: str, tags: tuple[str, ...] = ()
) -> PlacedObject:
    quat = quat_of(X_WU[:3, :3] @ matrix_of(np.array(stance.quat_wxyz)))
    inline: Inline | None = body.inline if isinstance(body.inline, BoxAsset | CylinderAsset | SphereAsset) else None
    return PlacedObject(
        id=name,
        asset_id=body.asset_id,
        package=body.package,
        position_m=(_rounded(X_WU[0, 3]), _rounded(X_WU[1, 3]), _rounded(X_WU[2, 3])),
        quat_wxyz=(_rounded(quat[0]), _rounded(quat[1]), _rounded(quat[2]), _rounded(quat[3])),
        scale=body.scale,
        parent=parent,
        anchor=anchor,
        prisms=prisms(stance, X_WU),
        semantic_tags=tags,
        primitive=inline,
        mass_kg=body.mass_kg,
    )


def prisms(stance: Stance, X_WU: FloatArray) -> tuple[Prism, ...]:
    """The collision geometry of a stance in the world; `X_WU` turns about z alone, so that prisms stay prisms."""
    floor_m = float(X_WU[2, 3]) - stance.origin_height_m
    made = []
    for slab in stance.slabs:
        outline = apply(X_WU, np.column_stack([slab.outline_m, np.zeros(len(slab.outline_m))]))[:, :2]
        made.append(
            Prism(
                outline_m=tuple((_rounded(x), _rounded(y)) for x, y in outline),
                low_m=_rounded(floor_m + slab.low_m),
                high_m=_rounded(floor_m + slab.high_m),
            )
        )
    return tuple(made)


def _rounded(value: float) -> float:
    return round(float(value), _DIGITS) + 0.0  # + 0.0: no negative zero.
