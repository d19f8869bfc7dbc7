"""Stacking rings: a stand with an upright rod, and rings of falling size that go over it."""

from __future__ import annotations

from dataclasses import dataclass

from assetkit.generate.generator import GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import choice, count, quantity
from assetkit.generate.shape import cylinder, revolved
from assetkit.generate.truth import TrueClearance, TrueHole

STAND_BASE_M = 0.012  # height of the stand's base
COLOURS_BY_SIZE = ("red", "orange", "yellow", "green", "blue", "purple")
SMALLEST_SHARE = 0.6  # radius of the smallest ring, of the largest one's
BEVEL_SHARE = 0.25  # of a ring's height: its edges are bevelled so much


@dataclass(frozen=True)
class StackingRings:
    """Parameters of `stacking_rings`."""

    rings: int = count(4, 1, 6, "rings, the largest first")
    rod_radius_m: float = quantity(0.008, 0.006, 0.012, "m", "radius of the rod")
    clearance_m: float = quantity(0.008, 0.003, 0.020, "m", "width of a ring's hole less width of the rod")
    outer_radius_m: float = quantity(0.045, 0.038, 0.070, "m", "outer radius of the largest ring")
    ring_height_m: float = quantity(0.022, 0.015, 0.030, "m", "height of a ring")
    material: str = choice("wood", ("wood", "plastic"), "material of stand and rings")


def build(p: StackingRings) -> GeneratedSet:
    """The stand and the rings, each an object of its own, with the clearance of every hole around the rod."""
    rod = p.rings * p.ring_height_m + p.ring_height_m
    base = cylinder(p.outer_radius_m, STAND_BASE_M, (0.0, 0.0, 0.0))
    shape = base + cylinder(p.rod_radius_m, rod, (0.0, 0.0, STAND_BASE_M))
    part = GeneratedPart("body", shape, p.material, "oak" if p.material == "wood" else "white")
    stand = GeneratedObject("rod_stand", (GeneratedLink("body", (part,)),))
    steps = max(p.rings - 1, 1)
    rings = tuple(
        _ring(p, p.outer_radius_m * (1.0 - (1.0 - SMALLEST_SHARE) * k / steps), COLOURS_BY_SIZE[k])
        for k in range(p.rings)
    )
    clearances = tuple(
        TrueClearance(name="hole", inner=stand.name, outer=ring.name, clearance_m=p.clearance_m) for ring in rings
    )
    return GeneratedSet((stand, *rings), clearances)


def _ring(p: StackingRings, outer: float, colour: str) -> GeneratedObject:
    """A ring of octagonal section whose hole is open from end to end."""
    inner, h = p.rod_radius_m + 0.5 * p.clearance_m, p.ring_height_m
    b = BEVEL_SHARE * h
    section = (
        (inner + b, 0.0),
        (outer - b, 0.0),
        (outer, b),
        (outer, h - b),
        (outer - b, h),
        (inner + b, h),
        (inner, h - b),
        (inner, b),
    )
    hole = TrueHole(name="hole", link="body", centre_m=(0.0, 0.0, h), axis=(0.0, 0.0, 1.0), width_m=2.0 * inner)
    part = GeneratedPart("body", revolved([section]), p.material, colour)
    return GeneratedObject(f"{colour}_ring", (GeneratedLink("body", (part,)),), holes=(hole,))


GENERATOR = Generator("stacking_rings", "Rings and the stand whose rod they go over", StackingRings, build)
