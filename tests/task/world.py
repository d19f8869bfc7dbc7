"""A small world for samples of predicates: a table, blocks, a basket, a cup, a rod, a hook, a button, a gripper.

Everything rests where `REST` says, for `FRAMES` frames at 20 Hz, unless a sample writes otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np

from schemas.anchors import AnchorPolygon, ContainmentVolume, SupportSurface
from schemas.arrays import FloatArray
from schemas.task.scene_facts import ObjectFacts, SceneFacts
from schemas.task.state_log import GripperParts, StateLog

FRAMES, RATE_HZ = 60, 20.0
LEVEL = (1.0, 0.0, 0.0, 0.0)
Pose = Sequence[float]  # x, y, z in metres, and perhaps w, x, y, z


def square(half_x: float, half_y: float | None = None) -> AnchorPolygon:
    """A rectangle about the origin with these half edges (m)."""
    y = half_x if half_y is None else half_y
    return AnchorPolygon(outline_m=((-half_x, -y), (half_x, -y), (half_x, y), (-half_x, y)))


def box(half: Sequence[float]) -> FloatArray:
    """(8, 3) corners of a box that stands on its origin, half edges (m) in x, y and height / 2."""
    return np.array([(a * half[0], b * half[1], c * half[2] + half[2]) for a, b, c in product((-1, 1), repeat=3)])


def top(half_x: float, half_y: float, height: float, name: str = "top") -> SupportSurface:
    """The upper face of a box that stands on its origin."""
    return SupportSurface(
        anchor_id=name,
        position_m=(0.0, 0.0, height),
        polygon=square(half_x, half_y),
        normal=(0.0, 0.0, 1.0),
        area_m2=4.0 * half_x * half_y,
        clearance_m=None,
        load_directions=((0.0, 0.0, 1.0),),
    )


def inside(half: float, height: float, floor: float, name: str = "volume_0") -> ContainmentVolume:
    """A square inside."""
    return ContainmentVolume(
        anchor_id=name,
        position_m=(0.0, 0.0, floor),
        opening=square(half),
        direction=(0.0, 0.0, 1.0),
        height_m=height,
        volume_m3=4.0 * half * half * height,
        passes_m=2.0 * half,
        slices=(),
    )


def block(name: str, colour: str, half: float = 0.02) -> ObjectFacts:
    """A cube that carries things on its top."""
    return ObjectFacts(
        name,
        box((half, half, half)),
        name,
        surfaces=(top(half, half, 2.0 * half),),
        tags=("block",),
        attributes={"colour": colour, "shape": "cube"},
    )


OBJECTS = (
    ObjectFacts("table", box((0.6, 0.4, 0.01)), "table", surfaces=(top(0.6, 0.4, 0.02),)),
    block("red", "red"),
    block("blue", "blue"),
    block("green", "green"),
    ObjectFacts("basket", box((0.1, 0.1, 0.05)), "basket", volumes=(inside(0.095, 0.095, 0.005),)),
    ObjectFacts("cup", box((0.04, 0.04, 0.05)), "cup", volumes=(inside(0.036, 0.095, 0.005),)),
    ObjectFacts("peg", box((0.01, 0.01, 0.05)), "peg"),
    ObjectFacts("socket", box((0.03, 0.03, 0.03)), "socket", volumes=(inside(0.0105, 0.05, 0.01),)),
    ObjectFacts("hook", box((0.01, 0.03, 0.01)), "hook"),
    ObjectFacts("base", box((0.1, 0.1, 0.05)), "base"),
    ObjectFacts("box", box((0.03, 0.03, 0.02)), "box"),
)
SCENE = SceneFacts({each.name: each for each in OBJECTS}, home={"arm/j1": 0.5, "arm/j2": -1.0})
REST: Mapping[str, Pose] = {
    "table": (0.0, 0.0, 0.0),
    "red": (-0.3, 0.0, 0.02),
    "blue": (-0.3, 0.2, 0.02),
    "green": (-0.3, -0.2, 0.02),
    "basket": (0.3, 0.0, 0.02),
    "cup": (0.0, 0.2, 0.02),
    "peg": (0.0, -0.2, 0.02),
    "socket": (0.1, -0.2, 0.02),
    "hook": (0.5, 0.3, 0.3),
    "box": (-0.5, 0.3, 0.02),
    "palm": (0.0, 0.0, 0.8),
    "left": (0.0, 0.03, 0.75),
    "right": (0.0, -0.03, 0.75),
    "base": (-0.7, 0.0, 0.0),
}
STANDING = ("red", "blue", "green", "basket", "cup", "peg", "socket", "box")
JOINTS: Mapping[str, float] = {
    "arm/j1": 0.5,
    "arm/j2": -1.0,
    "button/press": 0.0,
    "bell/press": 0.0,
    "nut/turn": 0.0,
    "drawer/slide": 0.0,
    "scale/beam": 0.0,
}
GRIPPER = GripperParts("hand", "palm", ("left", "right"))
PAIRS = tuple(
    (one, other)
    for k, one in enumerate(REST)
    for other in list(REST)[k + 1 :]
    if not {one, other} <= {"palm", "left", "right", "base"}
)


def logged(
    poses: Mapping[str, Pose] | None = None,
    joints: Mapping[str, float | FloatArray] | None = None,
    touches: Mapping[str, Sequence[str]] | None = None,
    motion: Mapping[str, FloatArray] | None = None,
    frames: int = FRAMES,
) -> StateLog:
    """A log in which some bodies stand elsewhere (`poses`), move (`motion` (n, 3) origins), joints have other
    positions, or bodies touch others than the table (`touches`: all that a body touches).
    """
    names = list(REST)
    placed = {**REST, **(poses or {})}
    position = np.empty((frames, len(names), 3))
    quats = np.empty((frames, len(names), 4))
    for column, name in enumerate(names):
        pose = tuple(placed[name])
        position[:, column] = pose[:3]
        quats[:, column] = pose[3:] or LEVEL
        if motion and name in motion:
            position[:, column] = motion[name]
    positions = np.empty((frames, len(JOINTS)))
    for column, (name, rest) in enumerate(JOINTS.items()):
        positions[:, column] = (joints or {}).get(name, rest)
    contacts = dict.fromkeys(STANDING, ("table",)) | {k: tuple(v) for k, v in (touches or {}).items()}
    touching = np.zeros((frames, len(PAIRS)), dtype=bool)
    for column, (one, other) in enumerate(PAIRS):
        touching[:, column] = other in contacts.get(one, ()) or one in contacts.get(other, ())
    stamps = np.arange(frames) / RATE_HZ
    return StateLog(stamps, tuple(names), position, quats, tuple(JOINTS), positions, PAIRS, touching, (GRIPPER,))


def turned(axis: Sequence[float], angle_rad: float) -> tuple[float, float, float, float]:
    """wxyz of a turn about a unit axis."""
    s = float(np.sin(angle_rad / 2.0))
    return (float(np.cos(angle_rad / 2.0)), s * axis[0], s * axis[1], s * axis[2])
