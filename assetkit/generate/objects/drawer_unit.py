"""A drawer unit: a case with levels, one drawer in each that slides out to the front (+x) by its handle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assetkit.generate.fittings import bar_handle
from assetkit.generate.generator import GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import count, quantity
from assetkit.generate.shape import Shape, box, union
from assetkit.generate.truth import TrueClearance, TrueInterior
from schemas.mechanism import MechanismJoint

SIDE_SHARE = 0.7  # height of a drawer's sides, of the level
DRAWER_HANDLE_SHARE = 0.3  # length of a handle, of the width


@dataclass(frozen=True)
class DrawerUnit:
    """Parameters of `drawer_unit`."""

    levels: int = count(3, 1, 6, "drawers, one above the other")
    width_m: float = quantity(0.40, 0.25, 1.00, "m", "outer width of the case")
    depth_m: float = quantity(0.40, 0.25, 0.70, "m", "outer depth of the case, without fronts")
    level_height_m: float = quantity(0.15, 0.10, 0.30, "m", "clear height of each level")
    wall_m: float = quantity(0.012, 0.008, 0.020, "m", "thickness of all boards")
    gap_m: float = quantity(0.002, 0.001, 0.003, "m", "gap between a drawer and the case")
    travel: float = quantity(0.8, 0.5, 0.95, "", "how far a drawer slides out, as a share of its inside length")
    damping_Ns_per_m: float = quantity(5.0, 0.1, 50.0, "N s/m", "viscous friction of a drawer")
    friction_N: float = quantity(1.0, 0.0, 5.0, "N", "dry friction of a drawer")


def build(p: DrawerUnit) -> GeneratedSet:
    """The case and its drawers, closed; positions are 0 closed, positive out."""
    t, pitch = p.wall_m, p.level_height_m + p.wall_m
    front, half = 0.5 * p.depth_m, 0.5 * p.width_m
    height = p.levels * pitch + t
    boards = [box((-front, -half, k * pitch), (front, half, k * pitch + t)) for k in range(p.levels + 1)]
    walls = [
        box((-front, y, k * pitch + t), (front, y + t, (k + 1) * pitch))
        for k in range(p.levels)
        for y in (-half, half - t)
    ]
    backs = [box((-front, t - half, k * pitch + t), (t - front, half - t, (k + 1) * pitch)) for k in range(p.levels)]
    case = GeneratedLink("body", (GeneratedPart("body", union([*boards, *walls, *backs]), "wood", "oak"),))
    names = [f"drawer_{k + 1}" for k in range(p.levels)]
    drawers = [_drawer(p, name, k * pitch + t, k * pitch, height) for k, name in enumerate(names)]
    inside = front + p.gap_m - (t - front + p.gap_m + t)
    joints = tuple(
        MechanismJoint(
            name,
            "prismatic",
            "body",
            name,
            np.array([front + p.gap_m, 0.0, k * pitch + t]),
            np.array([1.0, 0.0, 0.0]),
            limits=(0.0, p.travel * inside),
            damping=p.damping_Ns_per_m,
            friction=p.friction_N,
        )
        for k, name in enumerate(names)
    )
    interiors = tuple(_interior(p, name, k * pitch + t) for k, name in enumerate(names))
    unit = GeneratedObject("drawer_unit", (case, *drawers), joints, interiors)
    gaps = tuple(
        TrueClearance(name=f"gap around {name}", inner=name, outer="body", clearance_m=p.gap_m) for name in names
    )
    return GeneratedSet((unit,), gaps)


def _drawer(p: DrawerUnit, name: str, floor: float, bottom: float, height: float) -> GeneratedLink:
    """An open box behind a front board that covers the level, with a handle of steel; `floor` is that of the level."""
    t, front = p.wall_m, 0.5 * p.depth_m + p.gap_m
    x0, x1, y1 = -0.5 * p.depth_m + t + p.gap_m, front, 0.5 * p.width_m - t - p.gap_m
    z0, z1 = floor + p.gap_m, floor + SIDE_SHARE * p.level_height_m
    top = min(bottom + p.level_height_m + t - p.gap_m, height)
    plates: list[Shape] = [
        box((x0, -y1, z0), (x1, y1, z0 + t)),
        box((x0, -y1, z0 + t), (x0 + t, y1, z1)),
        box((x0 + t, -y1, z0 + t), (x1, t - y1, z1)),
        box((x0 + t, y1 - t, z0 + t), (x1, y1, z1)),
        box((front, -0.5 * p.width_m, bottom + p.gap_m), (front + t, 0.5 * p.width_m, top)),
    ]
    handle = bar_handle(DRAWER_HANDLE_SHARE * p.width_m, front + t, 0.0, 0.5 * (bottom + p.gap_m + top), "y")
    return GeneratedLink(
        name, (GeneratedPart("drawer", union(plates), "wood", "oak"), GeneratedPart("handle", handle, "steel", "grey"))
    )


def _interior(p: DrawerUnit, name: str, floor: float) -> TrueInterior:
    t = p.wall_m
    low = (-0.5 * p.depth_m + 2.0 * t + p.gap_m, -0.5 * p.width_m + 2.0 * t + p.gap_m, floor + p.gap_m + t)
    high = (0.5 * p.depth_m + p.gap_m, -low[1], floor + SIDE_SHARE * p.level_height_m)
    volume = float(np.prod(np.array(high) - np.array(low)))
    return TrueInterior(name="inside", link=name, volume_m3=volume, low_m=low, high_m=high)


GENERATOR = Generator("drawer_unit", "A case with drawers, one above the other", DrawerUnit, build)
