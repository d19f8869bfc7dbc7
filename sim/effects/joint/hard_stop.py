"""Hard stop: a mechanical end of travel (rad, m) that the model lacks, as a stiff spring with losses."""

from __future__ import annotations

from typing import Any

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import JointState, JointTorque
from sim.effects.candidacy import Bounds, MechanismCandidacy, Values
from sim.effects.effect import Confusable, Effect, Export, Parameter
from sim.effects.ranges import JointRanges

_STOP_SHARES = (0.01, 0.03, 0.07, 0.13, 0.22, 0.33)  # of the range, from its edges
_STIFFEST_STOP = 0.3  # of inertia over a step's square: what is stiffer would throw a joint out faster than it came
_HARDER = (10.0, 1e4)  # than what the torque does over the range
_MOST_LOSS = 3.0  # of a stop's force on the way in beyond that at rest, at the speeds that were reached
_LEAST_SPAN = 1e-9  # rad (m)


def _torque(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    """More on the way in than on the way out, so that a blow loses energy; a stop never pulls."""
    lower_rad, upper_rad, stiffness_Nm_per_rad, loss_s_per_rad = values[0], values[1], values[2], values[3]
    above = np.maximum(state.q - upper_rad, 0.0) * np.maximum(1.0 + loss_s_per_rad * state.qd, 0.0)
    below = np.maximum(lower_rad - state.q, 0.0) * np.maximum(1.0 + loss_s_per_rad * -state.qd, 0.0)
    return stiffness_Nm_per_rad * (below - above)


def _bounds(r: JointRanges) -> Bounds:
    middle, soft = 0.5 * (r.low + r.high), r.torque / max(r.span, _LEAST_SPAN)
    hardest = max(_HARDER[0] * soft, min(_HARDER[1] * soft, _STIFFEST_STOP * r.inertia / r.step_s**2))
    return {
        "lower_rad": (r.low - r.span, middle),
        "upper_rad": (middle, r.high + r.span),
        "stiffness_Nm_per_rad": (soft, hardest),
        "loss_s_per_rad": (0.0, _MOST_LOSS / r.speed),
    }


def _ends_of_travel(r: JointRanges, null: Values, bounds: Bounds) -> tuple[Values, ...]:
    """Ends of travel within the range that was reached, near its edges first, soft to hard, above, below and both."""
    soft, hard = bounds["stiffness_Nm_per_rad"]
    return tuple(
        {
            "lower_rad": r.low + share * r.span if "lower" in sides else null["lower_rad"],
            "upper_rad": r.high - share * r.span if "upper" in sides else null["upper_rad"],
            "stiffness_Nm_per_rad": float(stiffness),
            "loss_s_per_rad": 0.1 * bounds["loss_s_per_rad"][1],
        }
        for sides in (("upper",), ("lower",), ("lower", "upper"))
        for share in _STOP_SHARES
        for stiffness in np.geomspace(3.0 * soft, 0.3 * hard, 3)
    )


EFFECT = Effect(
    name="joint.hard_stop",
    kinds=("mechanism",),
    formula=(
        "tau = stiffness_Nm_per_rad * (max(lower_rad - q, 0) * max(1 - loss_s_per_rad * qd, 0)"
        " - max(q - upper_rad, 0) * max(1 + loss_s_per_rad * qd, 0))"
    ),
    source="Hunt and Crossley, J. Appl. Mech. 42 (1975), with a force in proportion to the depth",
    reveals="motion turns back at the same position every time, with a short large torque",
    parameters=(
        Parameter("lower_rad", "rad (m)", -100.0, 100.0, -100.0),
        Parameter("upper_rad", "rad (m)", -100.0, 100.0, 100.0),
        Parameter("stiffness_Nm_per_rad", "N m/rad (N/m)", 1e-3, 1e6, 100.0),
        Parameter("loss_s_per_rad", "s/rad (s/m)", 0.0, 1000.0, 0.0),
    ),
    confusables=(Confusable("joint.spring", "approach the end slowly: a spring acts over the whole range"),),
    hook=JointTorque(_torque, ("lower_rad", "upper_rad", "stiffness_Nm_per_rad", "loss_s_per_rad")),
    mechanism=MechanismCandidacy(
        null=lambda r: {"lower_rad": r.low - r.span, "upper_rad": r.high + r.span},
        bounds=_bounds,
        extra_starts=_ends_of_travel,
        max_excursion=lambda r: {"lower_rad": r.low, "upper_rad": r.high},
    ),
    plot_against="position",
    export=Export(
        usd="physics:lowerLimit, physics:upperLimit",
        urdf="limit/@lower, limit/@upper",
        urdf_joint={"lower_rad": "lower", "upper_rad": "upper"},
        only_reached=True,
    ),
)
