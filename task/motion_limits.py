"""Motion that no episode can hold: bodies that jump. A success by teleport is none."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from schemas.task.state_log import StateLog
from task.frames import length

# What people and robots throw stays below 10 m/s; 20 mm cover contact corrections of simulators and rounded stamps.
FASTEST_MPS, JITTER_M = 10.0, 0.02


class Teleport(NamedTuple):
    """A body that jumped to where it is in `frame`, by `distance_m`."""

    body: str
    frame: int
    distance_m: float


def first_teleport(log: StateLog, bodies: tuple[str, ...], first: int = 1, last: int | None = None) -> Teleport | None:
    """The first jump of one of the bodies in rows [first, last), by the distance to the row before."""
    columns = [log.body_index[name] for name in bodies if name in log.body_index]
    end = len(log) if last is None else last
    if not columns or first >= end:
        return None
    places = log.position_m[first - 1 : end][:, columns]
    moved = length(places[1:] - places[:-1])
    allowed = FASTEST_MPS * (log.t_s[first:end] - log.t_s[first - 1 : end - 1]) + JITTER_M
    jumps = moved > allowed[:, None]
    if not jumps.any():
        return None
    row, column = (int(k) for k in np.argwhere(jumps)[0])
    return Teleport(log.bodies[columns[column]], first + row, float(moved[row, column]))
