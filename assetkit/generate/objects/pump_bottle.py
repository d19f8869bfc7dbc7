"""A pump bottle: a hollow bottle, and a pump head on a stem that is pressed down and comes back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assetkit.generate.generator import PAINTS, GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import choice, quantity
from assetkit.generate.shape import SEGMENTS, box, cylinder, revolved
from assetkit.generate.truth import TrueClearance, TrueHole, TrueInterior
from schemas.mechanism import MechanismJoint

NECK_SHARE, NECK_M = 0.45, 0.02  # radius of the neck, of the bottle's; its height
STEM_SHARE = 0.4  # radius of the stem, of the inside of the neck
HEAD_M, NOZZLE_M = 0.012, 0.010  # height of the head; width of the nozzle
DAMPING_SHARE = 0.002  # damping per stiffness, s


@dataclass(frozen=True)
class PumpBottle:
    """Parameters of `pump_bottle`."""

    radius_m: float = quantity(0.034, 0.025, 0.050, "m", "outer radius of the bottle")
    height_m: float = quantity(0.13, 0.09, 0.20, "m", "height of the bottle up to its shoulder")
    wall_m: float = quantity(0.002, 0.0015, 0.003, "m", "wall of the bottle")
    travel_m: float = quantity(0.014, 0.008, 0.020, "m", "how far the pump goes down")
    stiffness_N_per_m: float = quantity(300.0, 100.0, 1000.0, "N/m", "stiffness of the return spring")
    colour: str = choice("white", PAINTS, "colour of the bottle")


def build(p: PumpBottle) -> GeneratedSet:
    """The bottle with the pump up; its position is 0 up, positive down."""
    r, t, h, neck = p.radius_m, p.wall_m, p.height_m, NECK_SHARE * p.radius_m
    top = h + NECK_M
    bottle = revolved(
        [
            ((0.0, 0.0), (r, 0.0), (r, t), (0.0, t)),
            ((r - t, t), (r, t), (r, h - t), (r - t, h - t)),
            ((neck - t, h - t), (r, h - t), (r, h), (neck - t, h)),
            ((neck - t, h), (neck, h), (neck, top), (neck - t, top)),
        ]
    )
    stem = STEM_SHARE * (neck - t)
    low = top + p.travel_m + t
    head = cylinder(neck, HEAD_M, (0.0, 0.0, low)) + cylinder(stem, low - h, (0.0, 0.0, h))
    head = head + box((0.0, -0.5 * NOZZLE_M, low + 0.002), (1.2 * r, 0.5 * NOZZLE_M, low + HEAD_M))
    links = (
        GeneratedLink("body", (GeneratedPart("body", bottle, "plastic", p.colour),)),
        GeneratedLink("pump_head", (GeneratedPart("pump_head", head, "plastic", "black"),)),
    )
    press = MechanismJoint(
        "press",
        "prismatic",
        "body",
        "pump_head",
        np.array([0.0, 0.0, low]),
        np.array([0.0, 0.0, -1.0]),
        limits=(0.0, p.travel_m),
        damping=DAMPING_SHARE * p.stiffness_N_per_m,
        stiffness=p.stiffness_N_per_m,
    )
    inner, mouth = r - t, neck - t
    circle = 0.5 * SEGMENTS * np.sin(2.0 * np.pi / SEGMENTS)  # area of the polygon for a unit circle
    inside = TrueInterior(
        name="inside",
        link="body",
        volume_m3=float(circle * (inner**2 * (h - 2.0 * t) + mouth**2 * (NECK_M + t))),
        low_m=(-inner, -inner, t),
        high_m=(inner, inner, top),
    )
    hole = TrueHole(name="mouth", link="body", centre_m=(0.0, 0.0, top), axis=(0.0, 0.0, 1.0), width_m=2.0 * mouth)
    gap = TrueClearance(name="mouth", inner="pump_head", outer="body", clearance_m=2.0 * (mouth - stem))
    return GeneratedSet((GeneratedObject("pump_bottle", links, (press,), (inside,), (hole,)),), (gap,))


GENERATOR = Generator("pump_bottle", "A hollow bottle with a pump", PumpBottle, build)
