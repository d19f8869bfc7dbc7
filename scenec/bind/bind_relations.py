"""Lowers authored relations to relations between things: directions become vectors, groups all their members."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np

from scenec.ir.names import WORLD, Names
from scenec.ir.problem import WORLD_PARENT, Path, RelationIR, Thing
from scenec.source.check_relations import DIRECTIONS, words_of
from scenec.source.tree import Spans, written
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from schemas.scene.program import Relation

MAX_RELATIONS = 50_000
ALIGNED_M, BETWEEN_M, FACING_RAD = 0.01, 0.02, float(np.radians(10.0))  # where no tolerance is written
# By viewpoint: the unit vectors to the right and away from the viewer, in x and y of the frame.
_RIGHT: dict[str, tuple[float, float]] = {
    "front": (1.0, 0.0),
    "back": (-1.0, 0.0),
    "left": (0.0, -1.0),
    "right": (0.0, 1.0),
}
_AWAY: dict[str, tuple[float, float]] = {
    "front": (0.0, 1.0),
    "back": (0.0, -1.0),
    "left": (1.0, 0.0),
    "right": (-1.0, 0.0),
}


def lower_relations(
    names: Names, things: Mapping[str, Thing], background_yaw_rad: float, spans: Spans
) -> tuple[tuple[RelationIR, ...], tuple[Diagnostic, ...]]:
    """All relations of a program between these things, and findings (`scene/frame-needed`, `scene/too-many`)."""
    relations: list[RelationIR] = []
    diagnostics: list[Diagnostic] = []
    for i, relation in enumerate(names.program.relations):
        path: Path = ("relations", i)
        try:
            for lowered in _lowered(names, relation, things, background_yaw_rad, path):
                relations.append(lowered)
                if len(relations) > MAX_RELATIONS:
                    headline = "the relations of groups stand for too many pairs of things"
                    diagnostics.append(
                        finding("scene/too-many", headline, where=spans.place(path), bound=MAX_RELATIONS)
                    )
                    return tuple(relations), tuple(diagnostics)
        except InvalidInput as error:
            diagnostics.append(error.diagnostic.model_copy(update={"where": spans.place(path)}))
    return tuple(relations), tuple(diagnostics)


def _lowered(
    names: Names, relation: Relation, things: Mapping[str, Thing], background_yaw_rad: float, path: Path
) -> Iterator[RelationIR]:
    (word,) = words_of(relation)
    sides = [names.things_named(name) for name in getattr(relation, word)]
    if not all(thing in things for side in sides for thing in side):  # of another component
        return
    if word == "aligned":
        members = tuple(thing for side in sides for thing in side)
        frame, yaw = _frame(names, relation, members, things, background_yaw_rad, path)
        along = _turned((1.0, 0.0) if relation.axis == "x" else (0.0, 1.0), -yaw)
        tolerance = ALIGNED_M if relation.tolerance is None else relation.tolerance
        yield RelationIR("aligned", members, along, tolerance=tolerance, frame=frame, path=path, word=word)
        return
    for chosen in product(*sides):
        if word in DIRECTIONS:
            frame, yaw = _frame(names, relation, chosen, things, background_yaw_rad, path)
            axis = (_RIGHT if word in ("left_of", "right_of") else _AWAY)[relation.viewpoint]
            first = chosen if word in ("left_of", "front_of") else chosen[::-1]
            yield RelationIR("before", first, _turned(axis, -yaw), relation.gap, frame=frame, path=path, word=word)
        elif word == "near" or word == "far_from":
            yield RelationIR(word, chosen, gap_m=relation.distance or 0.0, path=path, word=word)
        elif word == "facing":
            yield RelationIR("facing", chosen, tolerance=_facing_rad(relation), path=path, word=word)
        else:
            tolerance = BETWEEN_M if relation.tolerance is None else relation.tolerance
            yield RelationIR("between", chosen, tolerance=tolerance, path=path, word=word)


def _facing_rad(relation: Relation) -> float:
    if relation.tolerance_deg is not None:
        return float(np.radians(relation.tolerance_deg))
    return FACING_RAD if relation.tolerance is None else relation.tolerance


def _frame(
    names: Names,
    relation: Relation,
    chosen: tuple[str, ...],
    things: Mapping[str, Thing],
    background_yaw_rad: float,
    path: Path,
) -> tuple[str, float]:
    """Owner of the frame of a relation, and the yaw of that frame relative to the intended axes. Raises
    InvalidInput."""
    if relation.frame == WORLD:
        return WORLD_PARENT, background_yaw_rad
    if relation.frame is not None:
        anchors = names.program.anchors
        owner = names.owner(relation.frame) if relation.frame in anchors else names.placed(relation.frame)[0]
        return owner or WORLD_PARENT, 0.0
    parents = {things[name].parent for name in chosen}
    if len(parents) == 1:
        return parents.pop(), 0.0
    turning = [parent for parent in sorted(parents) if _turns(parent, things)]
    if turning:
        headline = (
            f"`{written(path)}`: {' and '.join(sorted(chosen))} stand on different things, and `{turning[0]}` turns"
        )
        raise InvalidInput(finding("scene/frame-needed", headline))
    return WORLD_PARENT, 0.0


def _turns(parent: str, things: Mapping[str, Thing]) -> bool:
    """Whether a support may have a yaw other than that of the background."""
    while parent != WORLD_PARENT:
        thing = things[parent]
        headings = [fixed_pose.yaw_rad for fixed_pose in thing.domain.fixed_poses] or list(thing.domain.yaw_rad)
        if any(abs(np.sin(0.5 * heading)) > 1e-9 for heading in headings) or max(headings) - min(headings) > 1e-9:
            return True
        parent = thing.parent
    return False


def _turned(axis: tuple[float, float], angle_rad: float) -> tuple[float, float]:
    c, s = float(np.cos(angle_rad)), float(np.sin(angle_rad))
    return c * axis[0] - s * axis[1] + 0.0, s * axis[0] + c * axis[1] + 0.0
