"""How a scene program places things: poses, ranges, placements of single nodes, and groups that place their members.

Lengths in metres, angles in radians; `*_deg` keys take degrees. x, y, z are those of the anchor's frame.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from schemas.scene.written import Distance, Length, Range, Written

Quat_wxyz = tuple[float, float, float, float]


class Ranges(Written):
    """Bounds of the asset origin and heading in the anchor's frame; what is absent is free."""

    x: Range | None = None
    y: Range | None = None
    yaw: Range | None = None
    yaw_deg: Range | None = None


class Pose(Written):
    """A complete pose in the anchor's frame; `z` is the height of the asset origin over the anchor."""

    x: float
    y: float
    z: float = 0.0
    yaw: float | None = None
    yaw_deg: float | None = None
    quat_wxyz: Quat_wxyz | None = None


Orientation: TypeAlias = Literal["upright", "stable"] | tuple[Quat_wxyz, ...]


class SurfacePlacement(Written):
    """Placement on a surface, the footprint wholly on its polygon."""

    type: Literal["surface"]
    surface: str
    ranges: Ranges = Ranges()
    orientation: Orientation = "upright"


class VolumePlacement(Written):
    """Inside a receptacle, on its floor or on what lies there."""

    type: Literal["volume"]
    volume: str
    ranges: Ranges = Ranges()
    orientation: Orientation = "upright"


class DiscretePlacement(Written):
    """One of the poses written down, in the frame of an anchor."""

    type: Literal["discrete"]
    surface: str | None = None
    volume: str | None = None
    poses: tuple[Pose, ...] = Field(min_length=1)


Placement: TypeAlias = Annotated[SurfacePlacement | VolumePlacement | DiscretePlacement, Field(discriminator="type")]


class RegionGroup(Written):
    """Members share a stretch of a support."""

    type: Literal["region"]
    members: tuple[str, ...] = Field(min_length=1)
    surface: str
    ranges: Ranges = Ranges()
    orientation: Orientation = "upright"


class ScatterGroup(Written):
    """A denser, repeated collection: `count` copies of each member's object where it is given."""

    type: Literal["scatter"]
    members: tuple[str, ...] = Field(min_length=1)
    surface: str
    count: Annotated[int, Field(ge=1)] = 1
    ranges: Ranges = Ranges()
    orientation: Orientation = "upright"


class VolumeGroup(Written):
    """Members lie together in a receptacle."""

    type: Literal["volume"]
    members: tuple[str, ...] = Field(min_length=1)
    volume: str
    ranges: Ranges = Ranges()
    orientation: Orientation = "upright"


class Slot(Written):
    """One authored place of a slot group."""

    id: str
    x: float
    y: float
    z: float = 0.0
    yaw: float | None = None
    yaw_deg: float | None = None


class SlotGroup(Written):
    """Each member takes a slot of its own; `assign` fixes which."""

    type: Literal["slot"]
    members: tuple[str, ...] = Field(min_length=1)
    surface: str | None = None
    volume: str | None = None
    slots: tuple[Slot, ...] = Field(min_length=1)
    assign: dict[str, str] = Field(default={})


class StackGroup(Written):
    """Members stand on one another in their order: the first on the surface, each other on the top of the one below."""

    type: Literal["stack"]
    members: tuple[str, ...] = Field(min_length=1)
    surface: str
    count: Annotated[int, Field(ge=1)] = Field(default=1, description="copies of each member, one above the other")
    ranges: Ranges = Field(default=Ranges(), description="of the lowest one")
    alignment: Distance = Field(
        default=0.0, description="m along each axis by which an origin may be off the middle of the top below it"
    )
    turn_deg: Range = Field(default=(0.0, 0.0), description="heading of each relative to the one below it")


class GridGroup(Written):
    """Members in rows and columns; the whole grid moves and turns within `ranges`, its middle being its origin."""

    type: Literal["grid"]
    members: tuple[str, ...] = Field(min_length=1, description="one for each cell, or one for all of them")
    surface: str
    rows: Annotated[int, Field(ge=1)] | tuple[str, ...] = Field(description="number or names, from the front (-y)")
    columns: Annotated[int, Field(ge=1)] | tuple[str, ...] = Field(description="number or names, from the left (-x)")
    pitch: tuple[Length, Length] = Field(description="distance of origins along x and y of the grid")
    order: Literal["rows", "columns"] = Field(default="rows", description="what the members fill first")
    ranges: Ranges = Ranges()

    @property
    def row_names(self) -> tuple[str, ...]:
        """Names of the rows; `row_1`, `row_2` where only their number is written."""
        return _numbered("row", self.rows) if isinstance(self.rows, int) else self.rows

    @property
    def column_names(self) -> tuple[str, ...]:
        """Names of the columns; `column_1`, `column_2` where only their number is written."""
        return _numbered("column", self.columns) if isinstance(self.columns, int) else self.columns

    def cells(self) -> tuple[tuple[int, int], ...]:
        """Row and column of each cell, in the order in which members fill them."""
        rows, columns = range(len(self.row_names)), range(len(self.column_names))
        if self.order == "rows":
            return tuple((r, c) for r in rows for c in columns)
        return tuple((r, c) for c in columns for r in rows)


def _numbered(word: str, count: int) -> tuple[str, ...]:
    return tuple(f"{word}_{k}" for k in range(1, count + 1))


Group: TypeAlias = Annotated[
    RegionGroup | ScatterGroup | VolumeGroup | SlotGroup | StackGroup | GridGroup, Field(discriminator="type")
]
