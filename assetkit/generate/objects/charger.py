"""A charger: a plug with a flat tongue, and a socket with a slot that takes it, open at the top."""

from __future__ import annotations

from dataclasses import dataclass

from assetkit.generate.generator import GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import quantity
from assetkit.generate.shape import box, open_box
from assetkit.generate.truth import TrueClearance, TrueHole, TrueInterior

WALL_SHARE = 0.5  # wall of the socket, of the tongue's thickness
GRIP_M = 0.040  # height of the plug's grip


@dataclass(frozen=True)
class Charger:
    """Parameters of `charger`."""

    width_m: float = quantity(0.030, 0.020, 0.045, "m", "width of the tongue")
    thickness_m: float = quantity(0.014, 0.010, 0.020, "m", "thickness of the tongue")
    length_m: float = quantity(0.022, 0.015, 0.035, "m", "length of the tongue")
    clearance_m: float = quantity(0.002, 0.0005, 0.004, "m", "size of the slot less size of the tongue, both ways")


def build(p: Charger) -> GeneratedSet:
    """Plug, tongue up, and socket, slot up: two objects. The plug goes in upside down, by the length of its tongue."""
    wall = WALL_SHARE * p.thickness_m
    x, y = 0.5 * p.thickness_m, 0.5 * p.width_m
    grip = box((-x - wall, -y - wall, 0.0), (x + wall, y + wall, GRIP_M))
    tongue = box((-x, -y, GRIP_M), (x, y, GRIP_M + p.length_m))
    plug = GeneratedObject(
        "charger_plug",
        (
            GeneratedLink(
                "body",
                (
                    GeneratedPart("body", grip, "plastic", "white"),
                    GeneratedPart("tongue", tongue, "steel", "grey"),
                ),
            ),
        ),
    )
    u, v = x + 0.5 * p.clearance_m, y + 0.5 * p.clearance_m
    height = p.length_m + p.clearance_m + wall
    body = open_box((-u - wall, -v - wall, 0.0), (u + wall, v + wall, height), wall)
    inside = TrueInterior(
        name="slot",
        link="body",
        volume_m3=4.0 * u * v * (height - wall),
        low_m=(-u, -v, wall),
        high_m=(u, v, height),
    )
    slot = TrueHole(
        name="slot",
        link="body",
        centre_m=(0.0, 0.0, height),
        axis=(0.0, 0.0, 1.0),
        width_m=2.0 * u,
        depth_m=height - wall,
    )
    part = GeneratedPart("body", body, "plastic", "black")
    socket = GeneratedObject("charger_socket", (GeneratedLink("body", (part,)),), (), (inside,), (slot,))
    room = TrueClearance(name="slot", inner=plug.name, outer=socket.name, clearance_m=p.clearance_m)
    return GeneratedSet((plug, socket), (room,))


GENERATOR = Generator("charger", "A plug, and the socket that takes it", Charger, build)
