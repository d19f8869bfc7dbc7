"""Rule: the inertia fits the mass and the shape of the colliders."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from geom.principal_axes import inertia_from_principal
from schemas.diagnostics import Diagnostic, finding
from usdio.rules.rule import Rule
from usdio.subject import Body, Subject
from usdio.subject.values import at, quaternion, vector

CODE = "asset/gate-inertia-scale"
# Against the colliders filled evenly with the same mass: a hollow box has 5/3, a box of edges alone 7/3 of its
# inertia, a lamp with a lead foot a fifth. One order of magnitude is out either way.
LEAST_RATIO, MOST_RATIO = 0.125, 4.0
MOST_APART = 0.25  # of the trace; a rod turned by 90 degrees is 0.5 off
ELSEWHERE = 2.5  # times looser: the colliders of other files may be coarse


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body whose `trace(I) / 2`, the sum of `m r^2` about the mass centre, is far from that of its
    colliders filled with its mass; and per axis for which the moment is.
    """
    for body in subject.active_bodies:
        stated = _inertia(body, subject)
        if stated is None or body.filled is None or body.mass_kg is None:
            continue
        even = body.filled.inertia_kgm2 * (body.mass_kg / body.filled.mass_kg)
        ratio = float(np.trace(stated) / np.trace(even))
        slack = 1.0 if subject.released else ELSEWHERE
        if not LEAST_RATIO / slack <= ratio <= MOST_RATIO * slack:
            yield finding(
                CODE,
                f"the inertia is {ratio:.3g} times that of its colliders filled evenly",
                where=at(body.prim),
                value=ratio,
                bound=LEAST_RATIO / slack if ratio < 1.0 else MOST_RATIO * slack,
                severity=subject.suspect,
            )
            continue
        # The shape of the tensor, whatever its size: axes swapped or turned show here.
        apart = float(np.abs(np.linalg.eigvalsh(stated / ratio - even)).max() / np.trace(even))
        if apart > MOST_APART * slack:
            yield finding(
                CODE,
                "the inertia lies along other axes than the shape",
                where=at(body.prim),
                value=apart,
                bound=MOST_APART,
                severity=subject.suspect,
            )


def _inertia(body: Body, subject: Subject) -> np.ndarray | None:
    """(3, 3) the stated tensor in kg m2 along the body's axes, or None where the inertia rule speaks."""
    moments = vector(body.prim, "physics:diagonalInertia", (0.0, 0.0, 0.0))
    quat_wxyz = quaternion(body.prim, "physics:principalAxes")
    if not (np.all(moments > 0.0) and np.all(np.isfinite(moments)) and np.all(np.isfinite(quat_wxyz))):
        return None
    to_si = subject.kilograms_per_unit * subject.frames.meters_per_unit**2
    turned = quat_wxyz if np.any(quat_wxyz) else np.array([1.0, 0.0, 0.0, 0.0])
    return inertia_from_principal(moments * to_si, turned)


RULE = Rule(
    CODE,
    "0.125 .. 4 times the evenly filled colliders; within 0.25 of the trace in direction",
    "polyhedral mass properties (Mirtich 1996)",
    check,
)
