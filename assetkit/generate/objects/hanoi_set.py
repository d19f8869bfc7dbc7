"""A set for the towers of Hanoi: a board with three rods, and discs of falling size with a hole."""

from __future__ import annotations

from dataclasses import dataclass

from assetkit.generate.generator import GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import count, quantity
from assetkit.generate.shape import box, cylinder, tube, union
from assetkit.generate.truth import TrueClearance, TrueHole

BOARD_M, MARGIN_M = 0.015, 0.010  # thickness of the board; least distance between discs of neighbouring rods
DISC_COLOURS = ("red", "orange", "yellow", "green", "blue", "purple", "pink")


@dataclass(frozen=True)
class HanoiSet:
    """Parameters of `hanoi_set`."""

    discs: int = count(4, 3, 7, "discs, the largest first")
    rod_radius_m: float = quantity(0.007, 0.005, 0.010, "m", "radius of a rod")
    clearance_m: float = quantity(0.008, 0.003, 0.015, "m", "width of a disc's hole less width of a rod")
    smallest_radius_m: float = quantity(0.028, 0.024, 0.035, "m", "outer radius of the smallest disc")
    step_m: float = quantity(0.006, 0.004, 0.010, "m", "how much larger the radius of the next disc is")
    disc_height_m: float = quantity(0.014, 0.010, 0.025, "m", "height of a disc")


def build(p: HanoiSet) -> GeneratedSet:
    """The board and the discs, each an object of its own, with the clearance of every hole around a rod."""
    largest = p.smallest_radius_m + (p.discs - 1) * p.step_m
    pitch = 2.0 * largest + MARGIN_M
    x, y = largest + MARGIN_M, pitch + largest + MARGIN_M
    rod = (p.discs + 1) * p.disc_height_m
    rods = [cylinder(p.rod_radius_m, rod, (0.0, k * pitch, BOARD_M)) for k in (-1, 0, 1)]
    board = union([box((-x, -y, 0.0), (x, y, BOARD_M)), *rods])
    base = GeneratedObject("hanoi_board", (GeneratedLink("body", (GeneratedPart("body", board, "wood", "oak"),)),))
    discs = tuple(_disc(p, k, largest - k * p.step_m) for k in range(p.discs))
    clearances = tuple(
        TrueClearance(name="hole", inner=base.name, outer=disc.name, clearance_m=p.clearance_m) for disc in discs
    )
    return GeneratedSet((base, *discs), clearances)


def _disc(p: HanoiSet, number: int, outer: float) -> GeneratedObject:
    inner = p.rod_radius_m + 0.5 * p.clearance_m
    shape = tube(inner, outer, p.disc_height_m, (0.0, 0.0, 0.0))
    hole = TrueHole(
        name="hole", link="body", centre_m=(0.0, 0.0, p.disc_height_m), axis=(0.0, 0.0, 1.0), width_m=2.0 * inner
    )
    part = GeneratedPart("body", shape, "wood", DISC_COLOURS[number])
    return GeneratedObject(f"hanoi_disc_{number + 1}", (GeneratedLink("body", (part,)),), holes=(hole,))


GENERATOR = Generator("hanoi_set", "A board with three rods, and discs", HanoiSet, build)
