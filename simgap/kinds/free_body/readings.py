"""Direct estimates of sensor errors from poses: age of velocities (s), rotation of the body frame (rad)."""

from __future__ import annotations

import numpy as np

from simgap.kinds.free_body.normal_equations import NormalEquations, of_rows, of_values
from simgap.kinds.free_body.toss import Toss, resting_facet


def velocity_age(toss: Toss) -> NormalEquations | None:
    """age_s: how far reported velocities lag behind the slope of the positions, in flight."""
    ages = []
    for part in toss.flights:
        if part.stop - part.start < toss.flight_rows:
            continue
        t = toss.t_s[part] - toss.t_s[part].mean()
        c = np.polynomial.polynomial.polyfit(t, toss.origin[part], 2)
        slope, acceleration = c[1] + 2.0 * t[:, None] * c[2], 2.0 * c[2]
        behind = slope - toss.support_rotation.apply(toss.series.columns["v_W"][part])
        ages.append(float(np.median(behind[1:-1] @ acceleration) / (acceleration @ acceleration)))
    return of_values(np.array(ages))


def frame_rotation(toss: Toss) -> NormalEquations | None:
    """x_rad, y_rad, z_rad: at rest the facet below lies flat; turning about the vertical does not show."""
    facet = resting_facet(toss)
    if facet is None or toss.rest is None:
        return None
    down = -toss.matrices[toss.rest][:, 2, :].mean(axis=0)
    x, y, z = facet
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return of_rows(across, down / np.linalg.norm(down) - facet, np.zeros(3))
