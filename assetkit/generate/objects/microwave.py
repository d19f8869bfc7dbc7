"""A microwave oven: a hollow body, a door with a window, and a knob that turns or a button that is pressed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assetkit.generate.fittings import bar_handle, door_hinge, knob_link
from assetkit.generate.generator import GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import choice, quantity
from assetkit.generate.shape import Shape, box, cylinder, union
from assetkit.generate.truth import TrueClearance, TrueInterior
from schemas.mechanism import MechanismJoint

GAP_M = 0.002  # between the body and what moves
PANEL_SHARE = 0.22  # width of the panel with the control, of the width
CONTROL_SHARE = 0.3  # radius of the control, of the width of the panel
KNOB_M, BUTTON_M = 0.018, 0.008  # how far a control stands out
KNOB_TURN_RAD, BUTTON_TRAVEL_M = 4.7, 0.004
BUTTON_SPRING_N_PER_M = 400.0
FRAME_M, WINDOW_SHARE = 0.05, 0.5  # frame around the window, and the window's thickness, of the door's
OVEN_HANDLE_SHARE, OVEN_HANDLE_INSET_M = 0.6, 0.025  # length, of the height; distance from the door's free edge


@dataclass(frozen=True)
class Microwave:
    """Parameters of `microwave`."""

    width_m: float = quantity(0.48, 0.40, 0.60, "m", "outer width")
    depth_m: float = quantity(0.34, 0.30, 0.50, "m", "outer depth, without the door")
    height_m: float = quantity(0.28, 0.24, 0.36, "m", "outer height")
    wall_m: float = quantity(0.015, 0.010, 0.025, "m", "thickness of the walls and the door")
    opening_rad: float = quantity(1.7, 1.3, 2.2, "rad", "how far the door opens")
    control: str = choice("knob", ("knob", "button"), "what the panel holds")


def build(p: Microwave) -> GeneratedSet:
    """The closed oven; the door's position is 0 closed, positive open; a knob turns clockwise from 0."""
    t, x, y, z = p.wall_m, 0.5 * p.depth_m, 0.5 * p.width_m, p.height_m
    edge = y - PANEL_SHARE * p.width_m  # the inside ends before it, the panel begins there
    front = x + GAP_M
    inside_low, inside_high = (t - x, t - y, t), (x, edge - t, z - t)
    body = _body(p, inside_low, inside_high, edge)
    links = [
        GeneratedLink("body", (GeneratedPart("body", body, "plastic", "white"),)),
        _door(p, front, edge - GAP_M),
        _control(p, x, 0.5 * (edge + y)),
    ]
    door = door_hinge("door", "door", front, -y, 0.5 * z, p.opening_rad)
    volume = float(np.prod(np.array(inside_high) - np.array(inside_low)))
    inside = TrueInterior(
        name="inside", link="body", volume_m3=volume, low_m=inside_low, high_m=inside_high, direction=(1.0, 0.0, 0.0)
    )
    joints = (door, _control_joint(p, x, 0.5 * (edge + y)))
    gap = TrueClearance(name="gap behind the door", inner="door", outer="body", clearance_m=GAP_M)
    return GeneratedSet((GeneratedObject("microwave", tuple(links), joints, (inside,)),), (gap,))


def _body(
    p: Microwave,
    inside_low: tuple[float, float, float],
    inside_high: tuple[float, float, float],
    edge: float,
) -> Shape:
    """Plates around the inside, and beside it the closed box of the electronics behind the panel."""
    x, y, z = 0.5 * p.depth_m, 0.5 * p.width_m, p.height_m
    (x0, y0, z0), (_, y1, z1) = inside_low, inside_high
    return union(
        (
            box((-x, -y, 0.0), (x0, edge, z)),
            box((x0, -y, 0.0), (x, y0, z)),
            box((x0, y1, 0.0), (x, edge, z)),
            box((x0, y0, 0.0), (x, y1, z0)),
            box((x0, y0, z1), (x, y1, z)),
            _panel_box(p, edge),
        )
    )


def _panel_box(p: Microwave, edge: float) -> Shape:
    """The box of the electronics: closed, with the walls of the oven."""
    t, x, y, z = p.wall_m, 0.5 * p.depth_m, 0.5 * p.width_m, p.height_m
    return union(
        (
            box((-x, edge, 0.0), (t - x, y, z)),
            box((x - t, edge, 0.0), (x, y, z)),
            box((t - x, edge, 0.0), (x - t, edge + t, z)),
            box((t - x, y - t, 0.0), (x - t, y, z)),
            box((t - x, edge + t, 0.0), (x - t, y - t, t)),
            box((t - x, edge + t, z - t), (x - t, y - t, z)),
        )
    )


def _door(p: Microwave, front: float, edge: float) -> GeneratedLink:
    """A frame with a pane of glass, and an upright handle near the free edge."""
    t, y, z, f = p.wall_m, 0.5 * p.width_m, p.height_m, FRAME_M
    frame = union(
        (
            box((front, -y, 0.0), (front + t, f - y, z)),
            box((front, edge - f, 0.0), (front + t, edge, z)),
            box((front, f - y, 0.0), (front + t, edge - f, f)),
            box((front, f - y, z - f), (front + t, edge - f, z)),
        )
    )
    pane = box((front, f - y, f), (front + WINDOW_SHARE * t, edge - f, z - f))
    handle = bar_handle(OVEN_HANDLE_SHARE * z, front + t, edge - OVEN_HANDLE_INSET_M, 0.5 * z, "z")
    return GeneratedLink(
        "door",
        (
            GeneratedPart("door", frame, "plastic", "black"),
            GeneratedPart("window", pane, "glass", "grey"),
            GeneratedPart("handle", handle, "steel", "grey"),
        ),
    )


def _control(p: Microwave, panel: float, y: float) -> GeneratedLink:
    radius, z = CONTROL_SHARE * PANEL_SHARE * p.width_m, 0.5 * p.height_m
    if p.control == "knob":
        return knob_link("knob", radius, KNOB_M, (panel + GAP_M, y, z))
    base = (panel + BUTTON_TRAVEL_M + GAP_M, y, z)
    return GeneratedLink(
        "button", (GeneratedPart("button", cylinder(radius, BUTTON_M, base, "x"), "plastic", "black"),)
    )


def _control_joint(p: Microwave, panel: float, y: float) -> MechanismJoint:
    anchor, inward = np.array([panel, y, 0.5 * p.height_m]), np.array([-1.0, 0.0, 0.0])
    if p.control == "knob":
        limits = (0.0, KNOB_TURN_RAD)
        return MechanismJoint(
            "knob_turn", "revolute", "body", "knob", anchor, inward, limits=limits, damping=0.002, friction=0.01
        )
    limits = (0.0, BUTTON_TRAVEL_M)
    return MechanismJoint(
        "button_press",
        "prismatic",
        "body",
        "button",
        anchor,
        inward,
        limits=limits,
        damping=1.0,
        stiffness=BUTTON_SPRING_N_PER_M,
    )


GENERATOR = Generator("microwave", "A microwave oven with a door and a knob or a button", Microwave, build)
