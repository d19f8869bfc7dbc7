"""A coloured basket: an open box with walls that lean outwards, to sort things into."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assetkit.generate.generator import PAINTS, GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import choice, quantity
from assetkit.generate.shape import Shape, box, frustum
from assetkit.generate.truth import TrueInterior


@dataclass(frozen=True)
class ColouredBasket:
    """Parameters of `coloured_basket`."""

    width_m: float = quantity(0.28, 0.14, 0.50, "m", "width at the floor")
    depth_m: float = quantity(0.20, 0.12, 0.40, "m", "depth at the floor")
    height_m: float = quantity(0.11, 0.06, 0.25, "m", "height")
    wall_m: float = quantity(0.004, 0.003, 0.008, "m", "thickness of the walls, level, and of the floor")
    flare: float = quantity(0.15, 0.0, 0.3, "", "how far each wall leans out at the rim, as a share of the height")
    colour: str = choice("red", PAINTS, "colour")


def build(p: ColouredBasket) -> GeneratedSet:
    """The basket."""
    t, h = p.wall_m, p.height_m
    floor = np.array([p.depth_m, p.width_m])
    rim = floor + 2.0 * p.flare * h
    at_floor = floor + 2.0 * p.flare * t  # outer size at the height of the floor
    inner = frustum(at_floor - 2.0 * t, rim - 2.0 * t, t, h)
    # The cut goes on beyond the rim: one that ended level with it could leave a film there.
    cut = frustum(at_floor - 2.0 * t, at_floor - 2.0 * t + 2.0 * (rim - at_floor), t, 2.0 * h - t)
    solid = frustum(floor, rim, 0.0, h).solid - cut.solid
    walls = [
        piece for axis in (0, 1) for side in (-1.0, 1.0) for piece in _wall(at_floor, rim, t, h, axis, side).convex
    ]
    bottom = box((*(-0.5 * floor), 0.0), (*(0.5 * floor), t))
    shape = Shape(solid, (*bottom.convex, *walls))
    top = 0.5 * (rim - 2.0 * t)
    inside = TrueInterior(
        name="inside",
        link="body",
        volume_m3=inner.solid.volume(),
        low_m=(-float(top[0]), -float(top[1]), t),
        high_m=(float(top[0]), float(top[1]), h),
    )
    part = GeneratedPart("body", shape, "plastic", p.colour)
    basket = GeneratedObject(f"{p.colour}_basket", (GeneratedLink("body", (part,)),), (), (inside,))
    return GeneratedSet((basket,))


def _wall(low: np.ndarray, high: np.ndarray, t: float, h: float, axis: int, side: float) -> Shape:
    """One leaning wall as a convex piece."""
    shift, size = np.zeros(2), [low.copy(), high.copy()]
    for s in size:
        s[axis] = t
    shift[axis] = 1.0
    centres = [side * 0.5 * (s[axis] - t) * shift for s in (low, high)]
    return frustum(size[0], size[1], t, h, *centres)


GENERATOR = Generator("coloured_basket", "An open basket with leaning walls", ColouredBasket, build)
