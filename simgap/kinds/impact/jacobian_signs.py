"""Convention check: sign of the recorded contact Jacobians against the measured change of rotation.

Jacobians are often written by hand from a drawing whose angles run the other way. Angular momentum decides: the moment
of the impulses must equal the change of spin, whatever the law of friction.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.sim_gap.report import ConventionCheck
from sim.dynamics.body_rollout import BodyModel
from simgap.inference.cluster_regression import Equations, regress
from simgap.kinds.impact.model import impulses
from simgap.recording.recording import Impacts

_SURE_SIGMAS = 4.0  # standard errors
_SIGN_BLOCKS = 20


def oriented(body: BodyModel, events: Impacts) -> tuple[Impacts, ConventionCheck]:
    """Events whose Jacobians' angular parts agree with the measured spin, and what was found."""
    seen = impulses(body, events)
    X = np.stack([seen.normal_arm * seen.normal, seen.along_arm * seen.along], axis=1)
    blocks = np.array_split(np.arange(len(events)), min(_SIGN_BLOCKS, max(len(events) // 3, 1)))
    names = ("normal", "tangent")
    found = regress([Equations(seen.spin[k], X[k], X[k]) for k in blocks], names, dict.fromkeys(names, 1.0))
    if found is None:
        return events, ConventionCheck(
            name="jacobian_signs", status="ok", evidence="too few events turn the body; the signs stand as given"
        )
    shares = {n: (found.values[n], found.standard_errors[n]) for n in names}
    wrong = [n for n in names if shares[n][0] < -_SURE_SIGMAS * shares[n][1]]
    figures = "; ".join(f"{n} {v:.2f} +- {1.96 * e:.2f}" for n, (v, e) in shares.items())
    text = f"spin per moment of the impulses (1 is mechanics): {figures}"
    if not wrong:
        return events, ConventionCheck(name="jacobian_signs", status="ok", evidence=text)
    turn = np.array([1.0, 1.0, -1.0])
    fixed = replace(
        events,
        normal=events.normal * (turn if "normal" in wrong else 1.0),
        tangent=events.tangent * (turn if "tangent" in wrong else 1.0),
    )
    what = f"; the angular part of the {' and '.join(wrong)} Jacobian has the wrong sign and was turned round"
    return fixed, ConventionCheck(name="jacobian_signs", status="fixed", evidence=text + what)
