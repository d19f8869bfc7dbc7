"""A cabinet with shelves and one door that swings about an upright edge."""

from __future__ import annotations

from dataclasses import dataclass

from assetkit.generate.fittings import bar_handle, door_hinge
from assetkit.generate.generator import GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import choice, count, quantity
from assetkit.generate.shape import box, open_box, union
from assetkit.generate.truth import TrueClearance, TrueInterior

GAP_M = 0.002  # between the case and the door
DOOR_HANDLE_SHARE = 0.25  # length of the handle, of the height
DOOR_HANDLE_INSET_M = 0.04  # its distance from the free edge


@dataclass(frozen=True)
class Cabinet:
    """Parameters of `cabinet`."""

    width_m: float = quantity(0.45, 0.25, 0.80, "m", "outer width")
    depth_m: float = quantity(0.35, 0.20, 0.60, "m", "outer depth, without the door")
    height_m: float = quantity(0.60, 0.30, 1.60, "m", "outer height")
    wall_m: float = quantity(0.016, 0.010, 0.025, "m", "thickness of boards and door")
    shelves: int = count(1, 0, 3, "boards inside, evenly spaced")
    opening_rad: float = quantity(1.8, 1.3, 2.6, "rad", "how far the door opens")
    hinge: str = choice("left", ("left", "right"), "side of the hinge, seen from the front")


def build(p: Cabinet) -> GeneratedSet:
    """The closed cabinet; the door's position is 0 closed, positive open."""
    t, x, y, z = p.wall_m, 0.5 * p.depth_m, 0.5 * p.width_m, p.height_m
    pitch = (z - t) / (p.shelves + 1)
    shelves = [box((t - x, t - y, k * pitch), (x, y - t, k * pitch + t)) for k in range(1, p.shelves + 1)]
    body = union([open_box((-x, -y, 0.0), (x, y, z), t, "+x"), *shelves])
    side = -1.0 if p.hinge == "left" else 1.0
    front = x + GAP_M
    door = box((front, -y, 0.0), (front + t, y, z))
    handle = bar_handle(DOOR_HANDLE_SHARE * z, front + t, -side * (y - DOOR_HANDLE_INSET_M), 0.5 * z, "z")
    links = (
        GeneratedLink("body", (GeneratedPart("body", body, "wood", "oak"),)),
        GeneratedLink(
            "door", (GeneratedPart("door", door, "wood", "oak"), GeneratedPart("handle", handle, "steel", "grey"))
        ),
    )
    clear = pitch - t
    interiors = tuple(
        TrueInterior(
            name=f"inside_{k + 1}",
            link="body",
            volume_m3=(p.depth_m - t) * (p.width_m - 2.0 * t) * clear,
            low_m=(t - x, t - y, k * pitch + t),
            high_m=(x, y - t, k * pitch + t + clear),
            direction=(1.0, 0.0, 0.0),
        )
        for k in range(p.shelves + 1)
    )
    hinge = door_hinge("door", "door", front, side * y, 0.5 * z, p.opening_rad)
    gap = TrueClearance(name="gap behind the door", inner="door", outer="body", clearance_m=GAP_M)
    return GeneratedSet((GeneratedObject("cabinet", links, (hinge,), interiors),), (gap,))


GENERATOR = Generator("cabinet", "A cabinet with shelves and a door", Cabinet, build)
