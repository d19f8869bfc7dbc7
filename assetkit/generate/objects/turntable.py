"""A turntable: a round platform that turns without end on a base."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assetkit.generate.generator import PAINTS, GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import choice, quantity
from assetkit.generate.shape import cylinder
from assetkit.generate.truth import TrueClearance
from schemas.mechanism import MechanismJoint

PLATFORM_GAP_M = 0.001  # between base and platform
BASE_SHARE = 0.7  # radius of the base, of the platform's
MARK_SHARE, MARK_M = 0.08, 0.002  # radius and height of the mark that shows the turn


@dataclass(frozen=True)
class Turntable:
    """Parameters of `turntable`."""

    radius_m: float = quantity(0.15, 0.08, 0.30, "m", "radius of the platform")
    base_height_m: float = quantity(0.025, 0.015, 0.060, "m", "height of the base")
    platform_m: float = quantity(0.010, 0.006, 0.020, "m", "thickness of the platform")
    damping_Nms_per_rad: float = quantity(0.01, 0.001, 0.1, "N m s/rad", "viscous friction")
    friction_Nm: float = quantity(0.01, 0.0, 0.1, "N m", "dry friction")
    material: str = choice("wood", ("wood", "plastic"), "material of base and platform")
    colour: str = choice("blue", PAINTS, "colour of the platform")


def build(p: Turntable) -> GeneratedSet:
    """The table; its position is positive counter-clockwise seen from above."""
    r, z = p.radius_m, p.base_height_m + PLATFORM_GAP_M
    base = cylinder(BASE_SHARE * r, p.base_height_m, (0.0, 0.0, 0.0))
    platform = cylinder(r, p.platform_m, (0.0, 0.0, z))
    mark = cylinder(MARK_SHARE * r, MARK_M, (0.8 * r, 0.0, z + p.platform_m))
    links = (
        GeneratedLink("base", (GeneratedPart("base", base, p.material, "grey"),)),
        GeneratedLink(
            "platform",
            (
                GeneratedPart("platform", platform, p.material, p.colour),
                GeneratedPart("mark", mark, p.material, "white" if p.colour != "white" else "black"),
            ),
        ),
    )
    joint = MechanismJoint(
        "turn",
        "continuous",
        "base",
        "platform",
        np.array([0.0, 0.0, z]),
        np.array([0.0, 0.0, 1.0]),
        damping=p.damping_Nms_per_rad,
        friction=p.friction_Nm,
    )
    gap = TrueClearance(name="gap under the platform", inner="platform", outer="base", clearance_m=PLATFORM_GAP_M)
    return GeneratedSet((GeneratedObject("turntable", links, (joint,)),), (gap,))


GENERATOR = Generator("turntable", "A platform that turns on a base", Turntable, build)
