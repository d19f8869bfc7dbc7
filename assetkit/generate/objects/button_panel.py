"""A panel with buttons in a row on top, each in a well, with a spring that brings it back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assetkit.generate.generator import GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import count, quantity
from assetkit.generate.shape import box, cylinder, drilled
from assetkit.generate.truth import TrueClearance, TrueHole
from schemas.mechanism import MechanismJoint

PANEL_M, FLOOR_M = 0.03, 0.008  # height of the panel; what is left below a well
CLEARANCE_M = 0.001  # the well is so much wider than the button
BUTTON_SPACING = 3.2  # distance of buttons, of their radius
DAMPING_SHARE = 0.002  # damping per stiffness, s: a button of some grams comes back without swinging
CAPS = ("red", "green", "blue", "yellow", "orange", "purple", "white", "black")


@dataclass(frozen=True)
class ButtonPanel:
    """Parameters of `button_panel`."""

    buttons: int = count(3, 1, 8, "buttons, in a row along y")
    radius_m: float = quantity(0.014, 0.008, 0.025, "m", "radius of a button")
    travel_m: float = quantity(0.005, 0.002, 0.010, "m", "how far a button goes down")
    stiffness_N_per_m: float = quantity(300.0, 50.0, 2000.0, "N/m", "stiffness of the return spring")


def build(p: ButtonPanel) -> GeneratedSet:
    """The panel with all buttons up; positions are 0 up, positive down."""
    r, well = p.radius_m, p.radius_m + 0.5 * CLEARANCE_M
    pitch = BUTTON_SPACING * r
    y = [(k - 0.5 * (p.buttons - 1)) * pitch for k in range(p.buttons)]
    x1, y1 = 0.75 * pitch, 0.5 * p.buttons * pitch + 0.25 * pitch
    panel = box((-x1, -y1, 0.0), (x1, y1, FLOOR_M)) + drilled(
        (-x1, -y1, FLOOR_M), (x1, y1, PANEL_M), [(0.0, at, well) for at in y]
    )
    bottom = FLOOR_M + p.travel_m + CLEARANCE_M
    top = PANEL_M + p.travel_m + 0.3 * r
    names = [f"button_{k + 1}" for k in range(p.buttons)]
    caps = [
        GeneratedLink(
            name, (GeneratedPart("button", cylinder(r, top - bottom, (0.0, at, bottom)), "plastic", CAPS[k]),)
        )
        for k, (name, at) in enumerate(zip(names, y, strict=True))
    ]
    joints = tuple(
        MechanismJoint(
            f"press_{k + 1}",
            "prismatic",
            "body",
            name,
            np.array([0.0, at, PANEL_M]),
            np.array([0.0, 0.0, -1.0]),
            limits=(0.0, p.travel_m),
            damping=DAMPING_SHARE * p.stiffness_N_per_m,
            stiffness=p.stiffness_N_per_m,
        )
        for k, (name, at) in enumerate(zip(names, y, strict=True))
    )
    wells = tuple(
        TrueHole(
            name=f"well of {name}",
            link="body",
            centre_m=(0.0, at, PANEL_M),
            axis=(0.0, 0.0, 1.0),
            width_m=2.0 * well,
            depth_m=PANEL_M - FLOOR_M,
        )
        for name, at in zip(names, y, strict=True)
    )
    body = GeneratedLink("body", (GeneratedPart("body", panel, "plastic", "grey"),))
    gaps = tuple(
        TrueClearance(name=f"well of {name}", inner=name, outer="body", clearance_m=CLEARANCE_M) for name in names
    )
    return GeneratedSet((GeneratedObject("button_panel", (body, *caps), joints, holes=wells),), gaps)


GENERATOR = Generator("button_panel", "A panel of buttons with return springs", ButtonPanel, build)
