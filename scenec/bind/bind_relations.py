"""Lowers authored relations to relations between things: directions become vectors, groups all their members."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from scenec.bind.asset_parts import heading_of_part
from scenec.ir.names import WORLD, Names, upright
from scenec.ir.problem import Thing
from scenec.relations.table import WRITTEN_RELATIONS
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from schemas.scene.geometry import BACKGROUND, SceneRelation
from schemas.scene.relations import Relation
from source.tree import Path, Spans, written

MAX_RELATIONS = 50_000


def lower_relations(
    names: Names, things: Mapping[str, Thing], background_yaw_rad: float, spans: Spans
) -> tuple[tuple[SceneRelation, ...], tuple[Diagnostic, ...]]:
    """All relations of a program between these things, and findings (`scene/frame-needed`, `scene/too-many`)."""
    relations: list[SceneRelation] = []
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
) -> Iterator[SceneRelation]:
    (row,) = relation.words
    members, part = relation.members(row), None
    if row.parts and (named := names.part_of(members[0])) is not None:
        members, part = (named[0], *members[1:]), named[1]
    sides = [names.things_named(name) for name in members]
    if not all(thing in things for side in sides for thing in side):  # of another component
        return
    frames = RelationFrames(names, relation.frame, things, background_yaw_rad, path, part)
    yield from WRITTEN_RELATIONS[row.kind].lower(relation, row, sides, frames)


@dataclass(frozen=True)
class RelationFrames:
    """The frames of one written relation at `path`, which names `frame` or none."""

    names: Names
    frame: str | None
    things: Mapping[str, Thing]
    background_yaw_rad: float
    path: Path
    part: str | None = None

    def part_heading_rad(self, name: str) -> float | None:
        """Heading of the part from the origin of a thing at yaw 0, None where no part is named. Raises InvalidInput."""
        if self.part is None:
            return None
        thing = self.things[name]
        return heading_of_part(thing.body, self.part, upright(self.names.placing(self.names.node_of[name])))

    def along(self, axis: tuple[float, float], members: tuple[str, ...]) -> tuple[str, tuple[float, float]]:
        """Owner of the frame for these members, and the axis in it. Raises InvalidInput."""
        owner, yaw = self._owner(members)
        return owner, _turned(axis, -yaw)

    def _owner(self, members: tuple[str, ...]) -> tuple[str, float]:
        # Owner of the frame, and the yaw of that frame relative to the intended axes.
        if self.frame == WORLD:
            return BACKGROUND, self.background_yaw_rad
        if self.frame is not None:
            is_anchor = self.frame in self.names.program.anchors
            owner = self.names.owner(self.frame) if is_anchor else self.names.placed(self.frame)[0]
            return owner or BACKGROUND, 0.0
        parents = {self.things[name].parent for name in members}
        if len(parents) == 1:
            return parents.pop(), 0.0
        turning = [parent for parent in sorted(parents) if _turns(parent, self.things)]
        if turning:
            who = " and ".join(sorted(members))
            headline = f"`{written(self.path)}`: {who} stand on different things, and `{turning[0]}` turns"
            raise InvalidInput(finding("scene/frame-needed", headline))
        return BACKGROUND, 0.0


def _turns(parent: str, things: Mapping[str, Thing]) -> bool:
    """Whether a support may have a yaw other than that of the background."""
    while parent != BACKGROUND:
        thing = things[parent]
        headings = [fixed_pose.yaw_rad for fixed_pose in thing.domain.fixed_poses] or list(thing.domain.yaw_rad)
        if any(abs(np.sin(0.5 * heading)) > 1e-9 for heading in headings) or max(headings) - min(headings) > 1e-9:
            return True
        parent = thing.parent
    return False


def _turned(axis: tuple[float, float], angle_rad: float) -> tuple[float, float]:
    c, s = float(np.cos(angle_rad)), float(np.sin(angle_rad))
    return c * axis[0] - s * axis[1] + 0.0, s * axis[0] + c * axis[1] + 0.0
