"""A stackable cup: hollow, wider above than below, so that cups of one kind go into each other."""

from __future__ import annotations

import math
from dataclasses import dataclass

from assetkit.generate.generator import PAINTS, GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import choice, quantity
from assetkit.generate.shape import revolved
from assetkit.generate.truth import TrueClearance, TrueInterior


@dataclass(frozen=True)
class StackableCup:
    """Parameters of `stackable_cup`."""

    radius_m: float = quantity(0.042, 0.030, 0.050, "m", "outer radius at the rim")
    height_m: float = quantity(0.095, 0.060, 0.140, "m", "height")
    wall_m: float = quantity(0.0025, 0.0015, 0.0035, "m", "thickness of the wall, level, and of the floor")
    draft_rad: float = quantity(0.09, 0.05, 0.10, "rad", "slope of the wall against the vertical")
    colour: str = choice("blue", PAINTS, "colour")


def build(p: StackableCup) -> GeneratedSet:
    """One cup. A second one in it stands `nesting step` higher: the wall's thickness over the slope."""
    slope, t, h = math.tan(p.draft_rad), p.wall_m, p.height_m
    top, bottom = p.radius_m, p.radius_m - h * slope
    at_floor = bottom + t * slope  # outer radius at the height of the floor
    shape = revolved(
        [
            ((0.0, 0.0), (bottom, 0.0), (at_floor, t), (0.0, t)),
            ((at_floor - t, t), (at_floor, t), (top, h), (top - t, h)),
        ]
    )
    inner = revolved([((0.0, t), (at_floor - t, t), (top - t, h), (0.0, h))])
    inside = TrueInterior(
        name="inside",
        link="body",
        volume_m3=inner.solid.volume(),
        low_m=(t - top, t - top, t),
        high_m=(top - t, top - t, h),
    )
    name = f"{p.colour}_stackable_cup"
    cup = GeneratedObject(
        name, (GeneratedLink("body", (GeneratedPart("body", shape, "plastic", p.colour),)),), (), (inside,)
    )
    step = TrueClearance(name="nesting step", inner=name, outer=name, clearance_m=max(t / slope, t))
    return GeneratedSet((cup,), (step,))


GENERATOR = Generator("stackable_cup", "A hollow cup; cups of one kind nest", StackableCup, build)
