"""Rule: the inertia fits the mass and the shape of the colliders."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Body, Subject
from gate.subject.inertial import shows_one_material, stated_inertia
from gate.subject.values import at
from geom.mass.inertia import sheet_volume
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-inertia-scale",
    "The inertia does not fit mass and shape",
    "The object would spin far too easily or hardly at all.",
    "recompute the inertia in kg m2 about the mass centre",
)
# Against the colliders filled evenly with the same mass: a hollow box has 5/3, a box of edges alone 7/3 of its
# inertia, a lamp with a lead foot a fifth. One order of magnitude is out either way.
LEAST_INERTIA_RATIO, MOST_INERTIA_RATIO = 0.125, 4.0
# Suspicious in a package: further out than a thin shell, or, of one material, far more compact than evenly filled.
SHELL_FACTOR, ONE_MATERIAL_LEAST = 1.15, 0.5
MOST_APART = 0.25  # of the trace; a rod turned by 90 degrees is 0.5 off
ELSEWHERE = 2.5  # times looser: the colliders of other files may be coarse


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body whose `trace(I) / 2`, the sum of `m r^2` about the mass centre, is far from that of its
    colliders filled with its mass, or whose axes lie otherwise. In packages a warning when the size is possible but
    beyond what lies between filled and hollow.
    """
    for body in subject.active_bodies:
        stated = stated_inertia(body, subject)
        if stated is None or body.collider_volume is None or body.mass_kg is None:
            continue
        even = body.collider_volume.filled(body.mass_kg / body.collider_volume.volume_m3).inertia_kgm2
        ratio = float(np.trace(stated) / np.trace(even))
        slack = 1.0 if subject.released else ELSEWHERE
        if not LEAST_INERTIA_RATIO / slack <= ratio <= MOST_INERTIA_RATIO * slack:
            yield finding(
                CODE,
                f"the inertia is {ratio:.3g} times that of its colliders filled evenly",
                where=at(body.prim),
                value=ratio,
                bound=LEAST_INERTIA_RATIO / slack if ratio < 1.0 else MOST_INERTIA_RATIO * slack,
                severity=subject.suspect_severity,
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
                severity=subject.suspect_severity,
            )
        elif subject.released:
            yield from _unusual(body, ratio)


def _unusual(body: Body, ratio: float) -> Iterator[Diagnostic]:
    most = SHELL_FACTOR * max(1.0, _shell_ratio(body))
    least = ONE_MATERIAL_LEAST if shows_one_material(body) else LEAST_INERTIA_RATIO
    if not least <= ratio <= most:
        headline = "the mass lies further out than a hollow shell" if ratio > most else "the mass lies close together"
        bound, severity = most if ratio > most else least, Severity.WARNING
        yield finding(CODE, headline, where=at(body.prim), value=ratio, bound=bound, severity=severity)


def _shell_ratio(body: Body) -> float:
    """`trace(I)` of a thin shell in the form of the colliders' common hull, against the colliders filled evenly."""
    if body.collider_volume is None or body.hull_W is None:
        return np.inf
    points, triangles = body.in_body(body.hull_W.points), body.hull_W.triangles
    thin_m = 1e-6 * body.diagonal_m
    shell = sheet_volume(points, triangles, thin_m)
    even = body.collider_volume.second_moment_m5 / body.collider_volume.volume_m3
    return float(np.trace(shell.second_moment_m5) / shell.volume_m3 / np.trace(even))


RULE = Rule(
    CODE,
    "0.125 .. 4 times the evenly filled colliders (warning in packages: above a thin shell, below 0.5 where one "
    "material shows); within 0.25 of the trace in direction",
    "polyhedral mass properties (Mirtich 1996)",
    check,
)
