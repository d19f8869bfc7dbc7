"""Invariants between the phases of the compiler: a defect of ours stops at the phase that made it.

Errors of a program are diagnostics and never get here; each verifier raises RuntimeError.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial

import numpy as np
from shapely import Polygon

from scenec.check.judge_scene import violations
from scenec.ir.derivation_cache import DerivationCache
from scenec.ir.problem import Body, Placement, Problem, Thing
from schemas.scene.compiled import CompiledScene
from schemas.scene.geometry import BACKGROUND, ScenePlace, Stance

UNIT = 1e-6  # how far the norm of a quaternion may be from 1


def after_binding(problem: Problem, derivations: DerivationCache | None = None) -> None:
    """The problem is complete: unique names, existing owners, valid geometry, relations and reach of existing
    things."""
    _raise(problem, "binding", _unbound(problem, derivations or DerivationCache()))


def after_analysis(problem: Problem, components: Sequence[Sequence[str]]) -> None:
    """Every thing is in exactly one component."""
    counted = Counter(name for members in components for name in members)
    names = {thing.name for thing in problem.things}
    wrong = sorted({name for name, count in counted.items() if count != 1} | (set(counted) ^ names))
    _raise(problem, "analysis", (f"{name} is in {counted[name]} components" for name in wrong))


def after_solving(
    problem: Problem, placements: Mapping[str, Placement], derivations: DerivationCache | None = None
) -> None:
    """The independent judge finds nothing wrong; a refused scene never leaves the compiler."""
    scene_violations = violations(problem, dict(placements), derivations)
    _raise(problem, "solving", (f"the checker refuses {wrong}" for wrong in scene_violations))


def after_emission(problem: Problem, scene: CompiledScene) -> None:
    """The scene is complete: every thing once and no other, on its owner, at a finite pose."""
    _raise(problem, "emission", _unwritten(problem, scene))


def _raise(problem: Problem, phase: str, wrong: Iterable[str]) -> None:
    first = next(iter(wrong), None)
    if first is not None:
        raise RuntimeError(f"{problem.scene}: after {phase}: {first}")


def _unbound(problem: Problem, derivations: DerivationCache) -> Iterator[str]:
    names = Counter(thing.name for thing in problem.things)
    yield from (f"{count} things are called {name}" for name, count in names.items() if count > 1)
    for thing in problem.things:
        if thing.parent != BACKGROUND and thing.parent not in names:
            yield f"the owner {thing.parent} of {thing.name} is not in the scene"
        yield from derivations.get(("sound", id(thing)), partial(_unsound, thing), thing)
    for body in {id(thing.body): thing.body for thing in problem.things}.values():  # Many things share one body.
        faults = derivations.get(("sound", id(body)), partial(_misshapen, body), body)
        yield from (f"{body.asset_id}: {wrong}" for wrong in faults)
    for place in {id(thing.place): thing.place for thing in problem.things}.values():
        if not derivations.get(("sound", id(place)), partial(_is_area, place), place):
            yield f"the place {place.name} is no area"
    for relation in problem.relations:
        strangers = {*relation.things, relation.frame} - set(names) - {BACKGROUND}
        yield from (f"{relation.word or relation.kind} speaks of {name}" for name in sorted(strangers))
        if abs(math.hypot(*relation.direction) - 1.0) > UNIT:
            yield f"the direction of {relation.word or relation.kind} has no unit length"
    yield from (f"a keep-out of {rule.parent} is no area" for rule in problem.keep_outs if not _sound(rule.polygon))
    for space in problem.keep_clear:
        if space.owner not in {*names, BACKGROUND}:
            yield f"{space.title} speaks of {space.owner}"
        if not space.layers or not all(_sound(layer.polygon) for layer in space.layers):
            yield f"{space.title} is no space"
    if problem.reach is not None:
        yield from (f"the reach names {name}" for name in sorted(set(problem.reach.members) - set(names)))


def _unsound(thing: Thing) -> tuple[str, ...]:
    resting_orientations = len(thing.body.resting_orientations)
    indices = {*thing.domain.orientation_indices, *(fixed_pose.stance for fixed_pose in thing.domain.fixed_poses)}
    spans = {"x": thing.domain.x_m, "y": thing.domain.y_m, "yaw": thing.domain.yaw_rad}
    return (
        *([] if indices else [f"{thing.name} has no way to stand"]),
        *(
            f"{thing.name} has no stance {k} of {resting_orientations}"
            for k in sorted(indices)
            if not 0 <= k < resting_orientations
        ),
        *(f"{name} of {thing.name} is reversed" for name, (low, high) in spans.items() if not low <= high),
    )


def _misshapen(body: Body) -> tuple[str, ...]:
    return tuple(wrong for stance in body.resting_orientations for wrong in _shapeless(stance))


def _shapeless(stance: Stance) -> Iterator[str]:
    if abs(np.linalg.norm(stance.quat_wxyz) - 1.0) > UNIT:
        yield f"the quaternion of stance {stance.name} has no unit length"
    if not stance.prisms:
        yield f"stance {stance.name} has no collision geometry"
    for prism in stance.prisms:
        if not np.isfinite(prism.outline_m).all() or not prism.low_m <= prism.high_m:
            yield f"stance {stance.name} has a piece without finite extent"


def _is_area(place: ScenePlace) -> bool:
    areas = [layer.polygon for layer in place.layers] if place.is_volume else [place.polygon]
    return bool(areas) and all(_sound(area) for area in areas)


def _sound(area: Polygon) -> bool:
    return area.is_valid and not area.is_empty and area.area > 0.0


def _unwritten(problem: Problem, scene: CompiledScene) -> Iterator[str]:
    written = Counter(placed.id for placed in scene.objects)
    objects = [thing for thing in problem.things if not thing.is_frame]
    parents = {thing.name: problem.standing_on(thing)[0] for thing in objects}
    wrong = sorted({name for name, count in written.items() if count != 1} | (set(written) ^ set(parents)))
    yield from (f"{name} is written {written[name]} times" for name in wrong)
    for placed in scene.objects:
        if placed.parent != parents.get(placed.id):
            yield f"{placed.id} stands on {placed.parent}"
    poses = np.array([(*placed.position_m, *placed.quat_wxyz) for placed in scene.objects]).reshape(-1, 7)
    whole = np.isfinite(poses).all(axis=1) & (np.abs(np.linalg.norm(poses[:, 3:], axis=1) - 1.0) <= UNIT)
    yield from (f"{placed.id} has no pose" for placed, there in zip(scene.objects, whole, strict=True) if not there)
