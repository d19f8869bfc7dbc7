"""What a simulator weighs: mass centre, principal axes, and the box of even density that has the same inertia.

A box of mass m with edges a, b, c about its centre has the moments m (b^2 + c^2) / 12 and so on; solved for the edges,
a^2 = 6 (I_b + I_c - I_a) / m.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from vtkmodules.vtkRenderingCore import vtkActor

from geom.mesh.primitives import sphere
from render.camera import AnnotationFrame
from render.modes.drawn import Drawn
from render.modes.request import DrawnMass, ModeRequest
from render.modes.sheet import plain_number
from render.modes.wire import line_actor
from render.surfaces import FAINT, ShadedSurface, actor, plain_actor
from render.textures import TextureSet
from schemas.appearance.material import Material
from schemas.arrays import FloatArray

_BODY_OPACITY = 0.35  # of the body
_CENTRE = (0.85, 0.08, 0.05)
_BOX = (0.1, 0.25, 0.6)
_AXES = ((0.8, 0.15, 0.1), (0.1, 0.55, 0.15), (0.1, 0.3, 0.85))  # as most viewers colour x, y, z
_BALL = 0.018  # radius, in units of the largest edge of the object
_AXIS, _BALL_SEGMENTS = 0.22, 24  # half length of an axis, in the same unit
_AXIS_PX = 3.0


def physics(request: ModeRequest, frame: AnnotationFrame, parts: tuple[ShadedSurface, ...]) -> Drawn:
    """A translucent body with the mass properties of each moving body; the legend has the numbers."""
    actors = [_translucent(parts)] if parts else []
    legend: list[tuple[tuple[float, float, float], str]] = []
    for mass in request.masses:
        centre = frame.from_asset(mass.centre_m[None])[0]
        actors.append(_ball(centre))
        box = inertia_box_m(mass)
        actors.append(line_actor(_box_edges(centre, mass.R_AP, box / frame.unit_m), _BOX, _AXIS_PX))
        for axis, color in enumerate(_AXES):
            reach = _AXIS * mass.R_AP[:, axis]
            actors.append(line_actor(np.stack([centre - reach, centre + reach])[None], color, _AXIS_PX))
        legend.append((_CENTRE, _figures(mass)))
    if request.masses:
        legend.append(
            (_BOX, "box of even density with the same inertia; principal axes red, green, blue by rising moment")
        )
    return Drawn(tuple(actors), True, tuple(legend) or ((FAINT, "no mass on record"),))


def inertia_box_m(mass: DrawnMass) -> FloatArray:
    """(3,) edges along the principal axes of the box with the same mass and moments."""
    squares = 6.0 * (mass.moments_kgm2.sum() - 2.0 * mass.moments_kgm2) / mass.mass_kg
    return np.sqrt(np.maximum(squares, 0.0))


def _figures(mass: DrawnMass) -> str:
    centre = ", ".join(f"{1000.0 * c:.1f}" for c in mass.centre_m)
    moments = ", ".join(f"{m:.2e}" for m in mass.moments_kgm2)
    return f"{mass.name}: {plain_number(mass.mass_kg)} kg, centre ({centre}) mm, moments ({moments}) kg m2"


def _box_edges(centre: FloatArray, R_NP: FloatArray, edges: FloatArray) -> FloatArray:
    """(12, 2, 3) the edges of a box."""
    corners = np.array(list(product((-0.5, 0.5), repeat=3)))
    pairs = [(a, b) for a in range(8) for b in range(a + 1, 8) if (corners[a] != corners[b]).sum() == 1]
    placed = centre + (corners * edges) @ R_NP.T
    return placed[np.array(pairs)]


def _ball(centre: FloatArray) -> vtkActor:
    points, triangles, normals = sphere(_BALL, _BALL_SEGMENTS)
    material = Material(name="mass centre", base_color=_CENTRE, roughness=0.5)
    placed = (points + centre)[triangles].astype(np.float32)
    return actor(ShadedSurface(material, (), placed, normals.astype(np.float32), {}), TextureSet(()))


def _translucent(parts: tuple[ShadedSurface, ...]) -> vtkActor:
    body = plain_actor(parts, FAINT)
    body.GetProperty().SetOpacity(_BODY_OPACITY)
    body.ForceOpaqueOff()
    body.ForceTranslucentOn()
    return body
