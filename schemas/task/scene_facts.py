"""What does not change during an episode: shapes, anchors and attributes of the objects of a task.

Everything is in the frame of the object's body, in metres. Packages, compiled scenes and recordings fill it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from pydantic import ConfigDict

from schemas.anchors import ContainmentVolume, SupportSurface
from schemas.arrays import FloatArray


@dataclass(frozen=True)
class ObjectFacts:
    """An object of the scene.

    points_m    (k, 3) corners of its convex hull, or of the hulls that it consists of; at least one.
    front       (3,) unit vector, its front; up (3,) its upright direction.
    volumes     insides of receptacles by name, `surfaces` places that carry things; the first is the main one.
    attributes  what a task may ask for, such as `colour: red`; `tags` are those of the scene program.
    body        the body of the log; `bodies` of volumes and surfaces that move with a link, by the anchor's name. Such
                an anchor is given in the frame of that body.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    name: str
    points_m: FloatArray
    body: str
    front: tuple[float, float, float] = (1.0, 0.0, 0.0)
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    volumes: tuple[ContainmentVolume, ...] = ()
    surfaces: tuple[SupportSurface, ...] = ()
    tags: tuple[str, ...] = ()
    attributes: Mapping[str, str] = field(default_factory=dict[str, str])
    bodies: Mapping[str, str] = field(default_factory=dict[str, str])


@dataclass(frozen=True)
class SceneFacts:
    """All objects of a scene by name; `home` joint positions (rad, m) of the robots by joint."""

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    objects: Mapping[str, ObjectFacts]
    home: Mapping[str, float] = field(default_factory=dict[str, float])

    def tagged(self, tag: str) -> tuple[str, ...]:
        """Names of the objects with a tag, in order of their names."""
        return tuple(sorted(name for name, facts in self.objects.items() if tag in facts.tags))
