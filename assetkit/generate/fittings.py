"""Fittings that several generators share: bar handles, hinges of doors, knobs with a pointer."""

from __future__ import annotations

from typing import Literal

import numpy as np

from assetkit.generate.generator import GeneratedLink, GeneratedPart
from assetkit.generate.shape import Shape, box, cylinder, union
from schemas.mechanism import MechanismJoint

HANDLE_M, STAND_OFF_M = 0.012, 0.03  # section of a bar handle, and its distance from the board
POINTER_SHARE = 0.3  # width and height of a knob's pointer, of its radius


def bar_handle(length_m: float, front_m: float, y_m: float, z_m: float, along: Literal["y", "z"]) -> Shape:
    """A straight bar on two posts in front (+x) of the board whose surface is at `front_m`, centred at y, z."""
    half, a, out = 0.5 * length_m, 0.5 * HANDLE_M, front_m + STAND_OFF_M

    def piece(x0: float, x1: float, low: float, high: float) -> Shape:
        if along == "y":
            return box((x0, y_m + low, z_m - a), (x1, y_m + high, z_m + a))
        return box((x0, y_m - a, z_m + low), (x1, y_m + a, z_m + high))

    posts = [piece(front_m, out, low, low + HANDLE_M) for low in (-half, half - HANDLE_M)]
    return union([*posts, piece(out, out + HANDLE_M, -half, half)])


def door_hinge(name: str, child: str, x_m: float, y_m: float, z_m: float, opening_rad: float) -> MechanismJoint:
    """The upright hinge at the edge y of a door that lies in front of `body`; positive positions open it.

    A door whose hinge is on the side of negative y turns about -z, another about +z.
    """
    axis = np.array([0.0, 0.0, -1.0 if y_m < 0.0 else 1.0])
    anchor = np.array([x_m, y_m, z_m])
    return MechanismJoint(
        name, "revolute", "body", child, anchor, axis, limits=(0.0, opening_rad), damping=0.05, friction=0.02
    )


def knob_link(name: str, radius_m: float, height_m: float, base_m: tuple[float, float, float]) -> GeneratedLink:
    """A round black knob with its axis along +x from `base_m`, and a white pointer on its face that shows the turn."""
    x, y, z = base_m
    top, a = x + height_m, 0.5 * POINTER_SHARE * radius_m
    knob = cylinder(radius_m, height_m, base_m, "x")
    pointer = box((top, y - a, z - 0.2 * radius_m), (top + 2.0 * a, y + a, z + 0.9 * radius_m))
    return GeneratedLink(
        name,
        (GeneratedPart("knob", knob, "plastic", "black"), GeneratedPart("pointer", pointer, "plastic", "white")),
    )
