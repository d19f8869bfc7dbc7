"""`episode.json`: robots, bodies and cameras of the columns of a recording (docs/reference/episode-folder.md).

Metres, radians unless a name says degrees, quaternions wxyz, z up. W world; R base of a robot, B body, C camera, which
looks along -z with +y up. Paths are relative to the folder of the file.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, PositiveFloat

from schemas.scene.compiled import Point3, Quat_wxyz

SCHEMA_VERSION = "1.0"
EPISODE_FILE = "episode.json"


# Names of files and folders that are written follow from it.
FileName = Annotated[str, Field(pattern=r"^([^./\\\x00][^/\\\x00]*)?$")]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Posed(_Model):
    """Something at a pose."""

    position_m: Point3 = (0.0, 0.0, 0.0)
    quat_wxyz: Quat_wxyz = (1.0, 0.0, 0.0, 0.0)


class BoxShape(Posed):
    """A box of full edge lengths (x, y, z), centred at its pose."""

    type: Literal["box"] = "box"
    name: str = ""
    size_m: tuple[PositiveFloat, PositiveFloat, PositiveFloat]


class SphereShape(Posed):
    """A ball."""

    type: Literal["sphere"] = "sphere"
    name: str = ""
    radius_m: PositiveFloat


class RoundShape(Posed):
    """A cylinder or a capsule along its z axis; a capsule's height does not count its caps."""

    type: Literal["cylinder", "capsule"]
    name: str = ""
    radius_m: PositiveFloat
    height_m: PositiveFloat


class MeshShape(Posed):
    """The convex hull of a mesh file (OBJ, STL, PLY), or of the array `key` (n, 3) of an archive (npz).

    Give a bin or a shelf as several convex pieces: a hull fills what is hollow.
    """

    type: Literal["mesh"] = "mesh"
    name: str = ""
    file: str
    key: str = ""
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


Shape = Annotated[BoxShape | SphereShape | RoundShape | MeshShape, Field(discriminator="type")]


class RobotEntry(Posed):
    """A robot, or a fixture with joints. Its base is fixed at its pose unless the table has `base.<name>.px ...`.

    `model` is a URDF or MuJoCo file. `positions` are joints that were not recorded and did not move. `joints` is the
    order of the coordinates where the recording has them as one vector (ManiSkill).
    """

    name: str
    model: str
    positions: dict[str, FiniteFloat] = {}
    joints: tuple[str, ...] = ()


class ObjectEntry(_Model):
    """An object that moves: shapes in its frame; its poses are `obj.<name>.px ... qz`."""

    name: str
    shapes: tuple[Shape, ...] = Field(min_length=1)


class FixtureEntry(Posed):
    """What never moves. A top face may be a support, called by the name of its shape."""

    name: str
    shapes: tuple[Shape, ...] = Field(min_length=1)


class CameraEntry(Posed):
    """A camera at its pose in W, or in the frame of `link` of `robot`, or at recorded `cam.<name>.px ... qz`."""

    name: str
    fovy_deg: Annotated[float, Field(gt=0.0, lt=180.0)]
    width_px: Annotated[int, Field(gt=0)] = 256
    height_px: Annotated[int, Field(gt=0)] = 256
    robot: str = ""
    link: str = ""


class EpisodeDescription(_Model):
    """The file. `columns` maps streams to columns of a table with other names: `{"q.joint1": "observation.state[0]"}`.

    `control_hz` gives the stamps of recordings that have none (ManiSkill).
    """

    schema_version: str = SCHEMA_VERSION
    name: FileName = ""
    robots: tuple[RobotEntry, ...] = ()
    objects: tuple[ObjectEntry, ...] = ()
    fixtures: tuple[FixtureEntry, ...] = ()
    cameras: tuple[CameraEntry, ...] = ()
    columns: dict[str, str] = {}
    control_hz: PositiveFloat | None = None
