"""A standing panel with knobs in a row on its front, each with a pointer and two stops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assetkit.generate.fittings import knob_link
from assetkit.generate.generator import GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import count, quantity
from assetkit.generate.shape import box
from assetkit.generate.truth import TrueClearance
from schemas.mechanism import MechanismJoint

KNOB_GAP_M = 0.001  # between knob and panel
KNOB_SPACING = 3.0  # distance of knobs, of their radius
DEPTH_M = 0.08


@dataclass(frozen=True)
class KnobPanel:
    """Parameters of `knob_panel`."""

    knobs: int = count(3, 1, 6, "knobs, in a row along y")
    radius_m: float = quantity(0.022, 0.012, 0.035, "m", "radius of a knob")
    height_m: float = quantity(0.020, 0.012, 0.030, "m", "how far a knob stands out")
    turn_rad: float = quantity(4.7, 1.5, 6.0, "rad", "from one stop to the other")
    damping_Nms_per_rad: float = quantity(0.002, 0.0005, 0.02, "N m s/rad", "viscous friction of a knob")
    friction_Nm: float = quantity(0.01, 0.0, 0.05, "N m", "dry friction of a knob")


def build(p: KnobPanel) -> GeneratedSet:
    """The panel with all knobs at their first stop; positions are 0 there, positive clockwise seen from the front."""
    r = p.radius_m
    pitch = KNOB_SPACING * r
    y = [(k - 0.5 * (p.knobs - 1)) * pitch for k in range(p.knobs)]
    height, half, x = 1.6 * pitch, 0.5 * (p.knobs + 0.4) * pitch, 0.5 * DEPTH_M
    body = GeneratedLink("body", (GeneratedPart("body", box((-x, -half, 0.0), (x, half, height)), "wood", "white"),))
    names = [f"knob_{k + 1}" for k in range(p.knobs)]
    knobs = [
        knob_link(name, r, p.height_m, (x + KNOB_GAP_M, at, 0.5 * height)) for name, at in zip(names, y, strict=True)
    ]
    joints = tuple(
        MechanismJoint(
            f"turn_{k + 1}",
            "revolute",
            "body",
            name,
            np.array([x + KNOB_GAP_M, at, 0.5 * height]),
            np.array([-1.0, 0.0, 0.0]),
            limits=(0.0, p.turn_rad),
            damping=p.damping_Nms_per_rad,
            friction=p.friction_Nm,
        )
        for k, (name, at) in enumerate(zip(names, y, strict=True))
    )
    gaps = tuple(
        TrueClearance(name=f"gap behind {name}", inner=name, outer="body", clearance_m=KNOB_GAP_M) for name in names
    )
    return GeneratedSet((GeneratedObject("knob_panel", (body, *knobs), joints),), gaps)


GENERATOR = Generator("knob_panel", "A standing panel with knobs", KnobPanel, build)
