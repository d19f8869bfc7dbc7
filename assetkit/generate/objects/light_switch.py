"""A light switch: an upright plate on a foot, with a lever that is turned up and down."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assetkit.generate.generator import GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import quantity
from assetkit.generate.shape import AXES, box, cylinder
from assetkit.generate.truth import TrueClearance
from schemas.mechanism import MechanismJoint

FOOT_M, LEVER_GAP_M = 0.010, 0.001  # thickness of the foot; gap between plate and lever
LEVER_WIDTH_SHARE = 0.2  # of the plate


@dataclass(frozen=True)
class LightSwitch:
    """Parameters of `light_switch`."""

    plate_m: float = quantity(0.085, 0.070, 0.120, "m", "edge of the square plate")
    thickness_m: float = quantity(0.012, 0.008, 0.020, "m", "thickness of the plate")
    lever_m: float = quantity(0.030, 0.018, 0.045, "m", "length of the lever from its hinge")
    lever_thickness_m: float = quantity(0.008, 0.006, 0.012, "m", "thickness of the lever")
    throw_rad: float = quantity(0.9, 0.4, 1.4, "rad", "from off (down) to on (up)")
    friction_Nm: float = quantity(0.02, 0.005, 0.05, "N m", "dry friction, which holds the lever where it is")


def build(p: LightSwitch) -> GeneratedSet:
    """The switch turned off; the lever's position is 0 off, positive up."""
    half, t, a = 0.5 * p.plate_m, p.thickness_m, 0.5 * p.lever_thickness_m
    middle = FOOT_M + half
    plate = box((-t, -half, FOOT_M), (0.0, half, FOOT_M + p.plate_m))
    foot = box((-half, -half, 0.0), (half, half, FOOT_M))
    body = GeneratedLink("body", (GeneratedPart("body", plate + foot, "plastic", "white"),))
    pivot = np.array([a + LEVER_GAP_M, 0.0, middle])
    width = LEVER_WIDTH_SHARE * p.plate_m
    level = cylinder(a, width, (pivot[0], -0.5 * width, middle), "y") + box(
        (pivot[0], -0.5 * width, middle - a), (pivot[0] + p.lever_m, 0.5 * width, middle + a)
    )
    down = level.turned(AXES["y"], 0.5 * p.throw_rad, pivot)
    lever = GeneratedLink("lever", (GeneratedPart("lever", down, "plastic", "grey"),))
    hinge = MechanismJoint(
        "lever_hinge",
        "revolute",
        "body",
        "lever",
        pivot,
        np.array([0.0, -1.0, 0.0]),
        limits=(0.0, p.throw_rad),
        damping=0.001,
        friction=p.friction_Nm,
    )
    gap = TrueClearance(name="gap behind the lever", inner="lever", outer="body", clearance_m=LEVER_GAP_M)
    return GeneratedSet((GeneratedObject("light_switch", (body, lever), (hinge,)),), (gap,))


GENERATOR = Generator("light_switch", "A switch with a lever, on a foot", LightSwitch, build)
