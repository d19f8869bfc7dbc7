"""Anchors, to which scenes attach objects: support surfaces and containment volumes, in the frame of their asset (m).

An anchor frame A has its origin at the centre of the bounding box of the anchor's polygon and the axes of the asset
frame, so that z is up and `quat_wxyz` the identity (design: scene program). Lengths in metres.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

Point2 = tuple[float, float]
Point3 = tuple[float, float, float]
Ring = tuple[Point2, ...]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class AnchorPolygon(_Model):
    """An outline (counter-clockwise) and holes (clockwise) in x and y of the anchor frame; no ring repeats a point."""

    outline_m: Ring
    holes_m: tuple[Ring, ...] = ()


class SupportSurface(_Model):
    """A near-horizontal face that can support objects.

    `clearance_m` is the least free height above it, None where the sky is free. `load_directions` are unit vectors out
    of the surface along which a thing can come or go: up, and sideways over the edges of the narrowest box around it.
    `anchor_id` numbers the surfaces of an asset from the main one on: the highest of the large ones comes first.
    `link` is the link of an articulated object that it moves with; it is given at the rest state.
    """

    kind: Literal["surface"] = "surface"
    anchor_id: str
    link: str | None = Field(default=None, exclude_if=lambda link: link is None)
    position_m: Point3 = Field(description="origin of the anchor frame in the asset frame")
    quat_wxyz: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    polygon: AnchorPolygon
    normal: Point3
    area_m2: float
    clearance_m: float | None
    load_directions: tuple[Point3, ...]


class VolumeSlice(_Model):
    """The free cross-section at one height over the origin of the anchor frame, for a layer of equal height."""

    height_m: float
    polygons: tuple[AnchorPolygon, ...]


class ContainmentVolume(_Model):
    """The inside of a receptacle. The anchor frame lies at the lowest point of the floor, under the opening.

    `opening` is the cross-section just below the rim at `height_m`, the usable height; `direction` points out of it.
    `slices` cut the inside at the middles of equally high layers from the floor up; `volume_m3` is what it holds.
    `passes_m` is the diameter of the largest ball that is sure to get in. `link` as of a surface: the id of the inside
    of a drawer is `<link>/inside`.
    """

    kind: Literal["volume"] = "volume"
    anchor_id: str
    link: str | None = Field(default=None, exclude_if=lambda link: link is None)
    position_m: Point3 = Field(description="origin of the anchor frame in the asset frame")
    quat_wxyz: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    opening: AnchorPolygon
    direction: Point3
    height_m: float
    volume_m3: float
    passes_m: float
    slices: tuple[VolumeSlice, ...]


Anchor: TypeAlias = Annotated[SupportSurface | ContainmentVolume, Field(discriminator="kind")]
