"""A box with a lid that swings up about the edge at its back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assetkit.generate.generator import (
    COLOURS,
    GeneratedLink,
    GeneratedObject,
    GeneratedPart,
    GeneratedSet,
    Generator,
)
from assetkit.generate.parameters import choice, quantity
from assetkit.generate.shape import box, open_box
from assetkit.generate.truth import TrueClearance, TrueInterior
from schemas.mechanism import MechanismJoint

RIM_GAP_M = 0.001  # between rim and lid
TAB_SHARE, TAB_M = 0.25, 0.015  # of the width, and how far the tab that lifts the lid stands out


@dataclass(frozen=True)
class HingedBox:
    """Parameters of `hinged_box`."""

    width_m: float = quantity(0.24, 0.10, 0.50, "m", "outer width")
    depth_m: float = quantity(0.16, 0.08, 0.40, "m", "outer depth")
    height_m: float = quantity(0.10, 0.05, 0.30, "m", "height without the lid")
    wall_m: float = quantity(0.006, 0.003, 0.012, "m", "thickness of walls and lid")
    opening_rad: float = quantity(1.9, 1.2, 2.4, "rad", "how far the lid opens")
    material: str = choice("wood", ("wood", "plastic"), "material of box and lid")
    colour: str = choice("oak", tuple(COLOURS), "colour of box and lid")


def build(p: HingedBox) -> GeneratedSet:
    """The closed box; the lid's position is 0 closed, positive open."""
    t, x, y, z = p.wall_m, 0.5 * p.depth_m, 0.5 * p.width_m, p.height_m
    body = open_box((-x, -y, 0.0), (x, y, z), t)
    low = z + RIM_GAP_M
    tab = box((x, -0.5 * TAB_SHARE * p.width_m, low), (x + TAB_M, 0.5 * TAB_SHARE * p.width_m, low + t))
    lid = box((-x, -y, low), (x, y, low + t))
    links = (
        GeneratedLink("body", (GeneratedPart("body", body, p.material, p.colour),)),
        GeneratedLink(
            "lid", (GeneratedPart("lid", lid, p.material, p.colour), GeneratedPart("handle", tab, p.material, p.colour))
        ),
    )
    hinge = MechanismJoint(
        "lid",
        "revolute",
        "body",
        "lid",
        np.array([-x, 0.0, low]),
        np.array([0.0, -1.0, 0.0]),
        limits=(0.0, p.opening_rad),
        damping=0.01,
        friction=0.02,
    )
    inside = TrueInterior(
        name="inside",
        link="body",
        volume_m3=(p.depth_m - 2.0 * t) * (p.width_m - 2.0 * t) * (z - t),
        low_m=(t - x, t - y, t),
        high_m=(x - t, y - t, z),
    )
    gap = TrueClearance(name="gap under the lid", inner="lid", outer="body", clearance_m=RIM_GAP_M)
    return GeneratedSet((GeneratedObject("hinged_box", links, (hinge,), (inside,)),), (gap,))


GENERATOR = Generator("hinged_box", "A box with a lid on a hinge", HingedBox, build)
