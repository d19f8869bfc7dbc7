"""A recorded episode: robots, free bodies, fixtures and cameras with their recorded motion (rad, m, s).

Frames: W world, z up. R base of a robot. L link, whose frame is also that of its joint. B free body. C camera, which
looks along -z with +y up. Every array over samples has the rows of `Episode.t_s`. Nothing here is ever written back:
output keeps the bytes of `Episode.source`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic
from schemas.physics import CollisionShape

JointKind = Literal["fixed", "revolute", "prismatic"]


@dataclass(frozen=True)
class Link:
    """A body of a robot or of an articulated fixture, and the joint that carries it.

    parent      index of the parent link, -1 for the base; parents come before their children.
    axis_L      (3,) unit vector; the joint turns about it, or slides along it, through the origin of L.
    X_PL        (4, 4) frame L in the parent's frame where the joint's position is zero.
    coordinate  column of `Robot.q` that drives it, -1 for a fixed joint; its position is gain * q + offset.
    shapes      convex collision shapes in L.
    """

    name: str
    parent: int
    kind: JointKind
    axis_L: FloatArray
    X_PL: FloatArray
    coordinate: int = -1
    gain: float = 1.0
    offset: float = 0.0
    shapes: tuple[CollisionShape, ...] = ()


@dataclass(frozen=True)
class Robot:
    """A tree of links with its recorded motion; an articulated fixture (door, drawer) is one too.

    X_WR  (n, 4, 4) pose of the base, the same in every row unless the base moves.
    q     (n, j) recorded positions (rad, m), `coordinates` their names; qd (n, j) rates, None where not recorded.
    """

    name: str
    links: tuple[Link, ...]
    coordinates: tuple[str, ...]
    X_WR: FloatArray
    q: FloatArray
    qd: FloatArray | None = None


@dataclass(frozen=True)
class FreeBody:
    """An object with recorded poses X_WB (n, 4, 4)."""

    name: str
    X_WB: FloatArray
    shapes: tuple[CollisionShape, ...]


@dataclass(frozen=True)
class Fixture:
    """What never moves: X_WB (4, 4). A top face of a shape may serve as a support, called by the shape's own name."""

    name: str
    X_WB: FloatArray
    shapes: tuple[CollisionShape, ...]
    shape_names: tuple[str, ...]


@dataclass(frozen=True)
class Camera:
    """A recorded camera: X_WC (n, 4, 4), vertical field of view (rad), picture size (pixels)."""

    name: str
    X_WC: FloatArray
    fovy_rad: float
    width_px: int = 256
    height_px: int = 256


@dataclass(frozen=True)
class Episode:
    """One recording. `t_s` (n,) are its stamps as recorded: never decreasing, repeats allowed.

    `part` is what holds it in a source of several recordings (a group of an HDF5 file, the number of an episode).
    `description` is the `episode.json` of recordings that need one beside. `notes` are findings that did not stop the
    reading.
    """

    name: str
    source: Path
    t_s: FloatArray
    robots: tuple[Robot, ...]
    objects: tuple[FreeBody, ...]
    fixtures: tuple[Fixture, ...]
    cameras: tuple[Camera, ...]
    part: str = ""
    notes: tuple[Diagnostic, ...] = ()
    description: Path | None = None


def link_names(episode: Episode, robot: Robot) -> list[str]:
    """Names of the links; `<robot>/<link>` where several robots have one of that name."""
    all_names = [link.name for one in episode.robots for link in one.links]
    return [name if all_names.count(name) == 1 else f"{robot.name}/{name}" for name in (k.name for k in robot.links)]
