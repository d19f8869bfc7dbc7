"""Crates of five plates with their inside on record, for tests of receptacles; metres, standing on z = 0."""

from __future__ import annotations

from collections.abc import Sequence

from schemas.anchors import AnchorPolygon, ContainmentVolume, Ring, SupportSurface, VolumeSlice
from schemas.physics import RigidBody
from tests.support.sample_bodies import boxes

LENGTH, HEIGHT, WALL = 0.12, 0.1, 0.004  # inner edge, inner height, and thickness of the plates
Plate = tuple[Sequence[float], Sequence[float]]  # edge lengths and centre


def square(edge: float) -> Ring:
    half = 0.5 * edge
    return ((-half, -half), (half, -half), (half, half), (-half, half))


def plates(floor: float = WALL, lift: float = 0.0) -> dict[str, Plate]:
    """The floor and four walls; the floor has its upper face at WALL + lift."""
    side, up = 0.5 * (LENGTH + WALL), lift + WALL + 0.5 * HEIGHT
    outer = LENGTH + 2.0 * WALL
    return {
        "floor": ((outer, outer, floor), (0.0, 0.0, lift + WALL - 0.5 * floor)),
        "-x": ((WALL, outer, HEIGHT), (-side, 0.0, up)),
        "+x": ((WALL, outer, HEIGHT), (side, 0.0, up)),
        "-y": ((LENGTH, WALL, HEIGHT), (0.0, -side, up)),
        "+y": ((LENGTH, WALL, HEIGHT), (0.0, side, up)),
    }


def crate(*more: Plate, lift: float = 0.0, floor: float = WALL, without: str = "") -> RigidBody:
    """The crate, `lift` over the ground, `without` one of its plates, with `more` of them."""
    parts = [plate for name, plate in plates(floor, lift).items() if name != without]
    return boxes([*parts, *more])


def inside(lift: float = 0.0) -> ContainmentVolume:
    """The inside of the crate whose floor lies at WALL + lift."""
    layer = HEIGHT / 8
    polygon = AnchorPolygon(outline_m=square(LENGTH))
    return ContainmentVolume(
        anchor_id="volume_0",
        position_m=(0.0, 0.0, WALL + lift),
        opening=polygon,
        direction=(0.0, 0.0, 1.0),
        height_m=HEIGHT,
        volume_m3=LENGTH**2 * HEIGHT,
        passes_m=LENGTH,
        slices=tuple(VolumeSlice(height_m=(k + 0.5) * layer, polygons=(polygon,)) for k in range(8)),
    )


def top(edge: float, z: float, anchor_id: str = "surface_0") -> SupportSurface:
    """A free square surface at a height."""
    return SupportSurface(
        anchor_id=anchor_id,
        position_m=(0.0, 0.0, z),
        polygon=AnchorPolygon(outline_m=square(edge)),
        normal=(0.0, 0.0, 1.0),
        area_m2=edge**2,
        clearance_m=None,
        load_directions=((0.0, 0.0, 1.0),),
    )
