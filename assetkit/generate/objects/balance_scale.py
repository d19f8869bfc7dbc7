"""A balance scale: a beam on a post, and a pan that hangs from each of its ends."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from assetkit.generate.generator import GeneratedLink, GeneratedObject, GeneratedPart, GeneratedSet, Generator
from assetkit.generate.parameters import quantity
from assetkit.generate.shape import box, cylinder, revolved
from assetkit.generate.truth import TrueClearance, TrueInterior
from schemas.mechanism import MechanismJoint

BEAM_M, RAISED_M = 0.012, 0.012  # section of the beam; how far its hinge lies above the hinges of the pans
ROD_M, WALL_M, RIM_M = 0.003, 0.003, 0.012  # radius of a hanger; wall and height of a pan
POST_M, BASE_M, GAP_M = 0.010, 0.015, 0.002  # radius of the post, height of the base, least gap
SWING_RAD = 0.05  # how far a pan swings beyond the tilt of the beam
FREE_SHARE = 0.25  # of the arm: height of a pan above the base at rest


@dataclass(frozen=True)
class BalanceScale:
    """Parameters of `balance_scale`."""

    arm_m: float = quantity(0.13, 0.08, 0.22, "m", "from the hinge of the beam to that of a pan")
    drop: float = quantity(0.9, 0.6, 1.0, "", "from the hinge of a pan to its floor, as a share of the arm")
    pan: float = quantity(0.38, 0.25, 0.45, "", "outer radius of a pan, as a share of the arm")
    tilt_rad: float = quantity(0.2, 0.1, 0.3, "rad", "how far the beam tilts either way")
    friction_Nm: float = quantity(0.0, 0.0, 0.001, "N m", "dry friction of the beam's hinge")


def build(p: BalanceScale) -> GeneratedSet:
    """The empty scale, level. Positive positions of the beam lower the right pan, seen from the front.

    The hinge of the beam lies above those of the pans, so that the empty scale comes back to level.
    """
    a = 0.5 * BEAM_M
    free = BASE_M + FREE_SHARE * p.arm_m + p.arm_m * math.sin(p.tilt_rad)
    pivot_z = free + p.drop * p.arm_m  # of the pans
    hinge_z = pivot_z + RAISED_M
    underside_m = RAISED_M + a  # of the beam, below its hinge
    post_top = hinge_z - underside_m / math.cos(p.tilt_rad) - POST_M * math.tan(p.tilt_rad) - GAP_M
    base = cylinder(0.6 * p.arm_m, BASE_M, (0.0, 0.0, 0.0)) + cylinder(POST_M, post_top - BASE_M, (0.0, 0.0, BASE_M))
    beam = box((-a, -p.arm_m - a, pivot_z - a), (a, p.arm_m + a, pivot_z + a)) + box(
        (-a, -2.0 * a, pivot_z + a), (a, 2.0 * a, hinge_z + a)
    )
    links = [
        GeneratedLink("base", (GeneratedPart("base", base, "wood", "brown"),)),
        GeneratedLink("beam", (GeneratedPart("beam", beam, "copper", "yellow"),)),
    ]
    x_axis = np.array([1.0, 0.0, 0.0])
    hinge = MechanismJoint(
        "beam_hinge",
        "revolute",
        "base",
        "beam",
        np.array([0.0, 0.0, hinge_z]),
        -x_axis,
        limits=(-p.tilt_rad, p.tilt_rad),
        damping=0.002,
        friction=p.friction_Nm,
    )
    joints, interiors = [hinge], list[TrueInterior]()
    for side, y in (("left", -p.arm_m), ("right", p.arm_m)):
        links.append(_pan(p, f"pan_{side}", y, free, pivot_z))
        anchor = np.array([0.0, y, pivot_z])
        limits = (-p.tilt_rad - SWING_RAD, p.tilt_rad + SWING_RAD)
        joints.append(
            MechanismJoint(
                f"pan_{side}_hinge", "revolute", "beam", f"pan_{side}", anchor, x_axis, limits=limits, damping=0.0005
            )
        )
        interiors.append(_inside(p, f"pan_{side}", y, free))
    gaps = tuple(
        TrueClearance(name=f"gap over {name}", inner=name, outer="beam", clearance_m=GAP_M)
        for name in ("pan_left", "pan_right")
    )
    return GeneratedSet((GeneratedObject("balance_scale", tuple(links), tuple(joints), tuple(interiors)),), gaps)


def _pan(p: BalanceScale, name: str, y: float, floor: float, pivot_z: float) -> GeneratedLink:
    """A round dish below a rod, which ends under the beam so that it clears it at any swing."""
    r, t = p.pan * p.arm_m, WALL_M
    dish = revolved(
        [((0.0, -t), (r, -t), (r, 0.0), (0.0, 0.0)), ((r - t, 0.0), (r, 0.0), (r, RIM_M), (r - t, RIM_M))],
        (0.0, y, floor),
    )
    swing = p.tilt_rad + SWING_RAD
    top = pivot_z - (0.5 * BEAM_M + GAP_M + ROD_M * math.sin(swing)) / math.cos(swing)
    rod = cylinder(ROD_M, top - floor, (0.0, y, floor))
    return GeneratedLink(name, (GeneratedPart("pan", dish + rod, "copper", "yellow"),))


def _inside(p: BalanceScale, name: str, y: float, floor: float) -> TrueInterior:
    inner = p.pan * p.arm_m - WALL_M
    dish = cylinder(inner, RIM_M, (0.0, y, floor)).solid - cylinder(ROD_M, RIM_M, (0.0, y, floor)).solid
    return TrueInterior(
        name="inside",
        link=name,
        volume_m3=dish.volume(),
        low_m=(-inner, y - inner, floor),
        high_m=(inner, y + inner, floor + RIM_M),
    )


GENERATOR = Generator("balance_scale", "A balance with two hanging pans", BalanceScale, build)
