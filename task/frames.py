"""Rows of a state log with the scene's facts: poses, joints and contacts as predicates read them.

All arithmetic is elementwise, so that a row has the same bits alone and among others: online and offline judge alike.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np

from schemas.anchors import ContainmentVolume, SupportSurface
from schemas.arrays import BoolArray, FloatArray
from schemas.task.scene_facts import ObjectFacts, SceneFacts
from schemas.task.state_log import StateLog


class StateMissing(Exception):
    """A log or scene lacks what a predicate reads; the text is one line that names it, `about` the object, if any."""

    def __init__(self, text: str, about: str = "") -> None:
        super().__init__(text)
        self.about = about


@dataclass(frozen=True)
class Frames:
    """Rows [first, last) of a log. `reset` is the first frame of the episode where the log does not begin with it."""

    log: StateLog
    scene: SceneFacts
    first: int
    last: int
    reset: StateLog | None = None
    _poses: dict[tuple[str, str], FloatArray] = field(default_factory=dict[tuple[str, str], FloatArray], repr=False)

    def __len__(self) -> int:
        return self.last - self.first

    @property
    def t_s(self) -> FloatArray:
        """(n,) stamps."""
        return self.log.t_s[self.first : self.last]

    def at_reset(self) -> Frames:
        """The first frame of the episode alone."""
        return Frames(self.reset or self.log, self.scene, 0, 1)

    def facts(self, name: str) -> ObjectFacts:
        """The facts of an object. Raises StateMissing."""
        facts = self.scene.objects.get(name)
        if facts is None:
            raise StateMissing(f"there is no object `{name}`", name)
        return facts

    def position(self, body: str) -> FloatArray:
        """(n, 3) origin of a body in W (m). Raises StateMissing."""
        return self.log.position_m[self.first : self.last, self._column(body)]

    def rotation(self, body: str) -> FloatArray:
        """(n, 3, 3) R_WB of a body. Raises StateMissing."""
        return self._once("rotation", body, self._rotation)

    def joint(self, name: str) -> FloatArray:
        """(n,) position of a joint (rad, m). Raises StateMissing."""
        column = self.log.joint_index.get(name)
        if column is None or self.log.joint_position is None:
            raise StateMissing(f"there is no joint `{name}`", name.partition("/")[0])
        return self.log.joint_position[self.first : self.last, column]

    def points(self, name: str) -> FloatArray:
        """(n, k, 3) the corners of an object's hull in W (m)."""
        return self._once("points", name, self._points)

    def centre(self, name: str) -> FloatArray:
        """(n, 3) the centre in W of the box around an object's hull in its own axes (m)."""
        return self._once("centre", name, self._centre)

    def direction(self, name: str, axis: tuple[float, float, float]) -> FloatArray:
        """(n, 3) a direction of an object in W."""
        facts = self.facts(name)
        return rotated(self.rotation(facts.body), np.array([axis]))[:, 0]

    def volume(self, name: str, volume: str) -> tuple[ContainmentVolume, str]:
        """A volume of an object by its name, `auto` the main one, and the body that carries it. Raises StateMissing."""
        facts = self.facts(name)
        for each in facts.volumes:
            if volume in ("auto", each.anchor_id):
                return each, facts.bodies.get(each.anchor_id, facts.body)
        have = _listed(each.anchor_id for each in facts.volumes)
        raise StateMissing(f"`{name}` has no volume `{volume}`; it has {have}", name)

    def surface(self, name: str, surface: str) -> tuple[SupportSurface, str]:
        """A surface of an object by its name, `auto` the main one, and the body that carries it. Raises as `volume`."""
        facts = self.facts(name)
        for each in facts.surfaces:
            if surface in ("auto", each.anchor_id):
                return each, facts.bodies.get(each.anchor_id, facts.body)
        have = _listed(s.anchor_id for s in facts.surfaces)
        raise StateMissing(f"`{name}` has no surface `{surface}`; it has {have}", name)

    def in_anchor(self, points_W: FloatArray, anchor: SupportSurface | ContainmentVolume, body: str) -> FloatArray:
        """Points (n, k, 3) of W in the frame of an anchor whose frame has the axes of its body."""
        local = to_body(self.position(body), self.rotation(body), points_W)
        return local - np.asarray(anchor.position_m)

    def touching(self, one: str, other: str) -> BoolArray:
        """(n,) whether two bodies touch. Raises StateMissing where contacts were not observed."""
        if self.log.touching is None:
            raise StateMissing("no contacts are recorded")
        column = self.log.contacts_of.get(one, {}).get(other)
        if column is None:
            return np.zeros(len(self), dtype=bool)
        return self.log.touching[self.first : self.last, column]

    def touches_any(
        self, body: str, others: frozenset[str] | None = None, but: frozenset[str] = frozenset()
    ) -> BoolArray:
        """(n,) whether a body touches one of `others` (all bodies by default) that is not in `but`."""
        if self.log.touching is None:
            raise StateMissing("no contacts are recorded")
        result = np.zeros(len(self), dtype=bool)
        for name, column in self.log.contacts_of.get(body, {}).items():
            if name not in but and (others is None or name in others):
                result |= self.log.touching[self.first : self.last, column]
        return result

    def _once(self, what: str, name: str, of: Callable[[str], FloatArray]) -> FloatArray:
        """A value that several predicates read of the same rows, computed once."""
        key = (what, name)
        if key not in self._poses:
            self._poses[key] = of(name)
        return self._poses[key]

    def _rotation(self, body: str) -> FloatArray:
        return rotation_matrices(self.log.quat_wxyz[self.first : self.last, self._column(body)])

    def _points(self, name: str) -> FloatArray:
        facts = self.facts(name)
        return to_world(self.position(facts.body), self.rotation(facts.body), facts.points_m)

    def _centre(self, name: str) -> FloatArray:
        facts = self.facts(name)
        middle = (facts.points_m.min(axis=0) + facts.points_m.max(axis=0)) / 2.0
        return to_world(self.position(facts.body), self.rotation(facts.body), middle[None])[:, 0]

    def _column(self, body: str) -> int:
        column = self.log.body_index.get(body)
        if column is None:
            raise StateMissing(f"there is no body `{body}`", body)
        return column


def rotation_matrices(quat_wxyz: FloatArray) -> FloatArray:
    """(n, 3, 3) from unit quaternions (n, 4)."""
    w, x, y, z = (quat_wxyz[:, k] for k in range(4))
    rows = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def rotated(R: FloatArray, vectors: FloatArray) -> FloatArray:
    """(n, k, 3) each vector (k, 3) under each rotation (n, 3, 3)."""
    parts = [R[:, None, :, axis] * vectors[None, :, axis, None] for axis in range(3)]
    return parts[0] + parts[1] + parts[2]


def to_world(position: FloatArray, R: FloatArray, points: FloatArray) -> FloatArray:
    """(n, k, 3) points (k, 3) of a body in W."""
    return rotated(R, points) + position[:, None, :]


def to_body(position: FloatArray, R: FloatArray, points_W: FloatArray) -> FloatArray:
    """(n, k, 3) points (n, k, 3) of W in the frame of a body."""
    offset = points_W - position[:, None, :]
    parts = [R[:, None, axis, :] * offset[:, :, axis, None] for axis in range(3)]
    return parts[0] + parts[1] + parts[2]


def length(vectors: FloatArray) -> FloatArray:
    """Lengths along the last axis, of two or three entries."""
    squares = vectors[..., 0] * vectors[..., 0] + vectors[..., 1] * vectors[..., 1]
    if vectors.shape[-1] == 3:
        squares = squares + vectors[..., 2] * vectors[..., 2]
    return np.sqrt(squares)


def dot(one: FloatArray, other: FloatArray) -> FloatArray:
    """Products along the last axis, of three entries."""
    return one[..., 0] * other[..., 0] + one[..., 1] * other[..., 1] + one[..., 2] * other[..., 2]


def angle_between(one: FloatArray, other: FloatArray) -> FloatArray:
    """(n,) angles between directions (n, 3) and (n, 3) or (3,), rad; exact also for small ones."""
    across = np.stack(
        [
            one[..., 1] * other[..., 2] - one[..., 2] * other[..., 1],
            one[..., 2] * other[..., 0] - one[..., 0] * other[..., 2],
            one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0],
        ],
        axis=-1,
    )
    return np.arctan2(length(across), dot(one, other))


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names) or "none"
