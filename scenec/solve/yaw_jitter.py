"""Turns things that a structured family placed in rows by random yaws where there is room, for less regular scenes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import pi

from scenec.solve.check import blockers
from scenec.solve.model import SolverModel, yaw_allowed
from scenec.solve.placed import Placed
from scenec.solve.streams import stream

TURNS = (1.0, 0.3, 0.1)  # shares of half a turn within which a yaw is drawn, the widest first


def with_jittered_yaws(model: SolverModel, assignment: Mapping[str, Placed], seed: int) -> dict[str, Placed]:
    """The same things at the same points, those with free yaw turned as far as a few draws allow; still valid."""
    jittered = dict(assignment)
    for name in sorted(assignment):
        placed, domain = assignment[name], model.things[name].domain
        if domain.fixed_poses or domain.yaw_rad[0] == domain.yaw_rad[1] or name in model.carriers:
            continue
        for share, draw in zip(TURNS, stream(seed, "loosen", name).uniform(-pi, pi, len(TURNS)).tolist(), strict=True):
            yaw = yaw_allowed(placed.placement.yaw_rad + share * draw, domain.yaw_rad)
            if yaw is None:
                continue
            jittered[name] = model.put(name, replace(placed.placement, yaw_rad=yaw))
            if blockers(model, jittered, name) is None:
                break
            jittered[name] = placed
    return jittered
