"""The static gate: plausibility of a released package that outside validators do not judge."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Tf

from schemas.diagnostics import Diagnostic, InvalidInput, finding
from usdio.rules import (
    body_scale,
    collider_convex,
    collider_displaced,
    collider_present,
    default_prim,
    density,
    extent,
    files,
    friction,
    inertia,
    inertia_scale,
    joint_limits,
    mass,
    mass_centre,
    restitution,
    units,
)
from usdio.stage import open_stage

Rule = Callable[[Any], Iterator[Diagnostic]]  # takes a Usd.Stage

RULES: tuple[Rule, ...] = (
    units.check,
    default_prim.check,
    files.check,
    extent.check,
    body_scale.check,
    mass.check,
    density.check,
    inertia.check,
    inertia_scale.check,
    mass_centre.check,
    collider_present.check,
    collider_convex.check,
    collider_displaced.check,
    friction.check,
    restitution.check,
    joint_limits.check,
)


def gate(main_file: Path) -> tuple[Diagnostic, ...]:
    """Every finding of every rule on the package with this main file, in rule order; empty means passed.

    A file that cannot be opened gives the one finding `asset/package-invalid`.
    """
    try:
        stage = open_stage(main_file)
    except InvalidInput as error:
        return (error.diagnostic,)
    with np.errstate(all="ignore"):  # Broken files hold infinities; every comparison is written so that NaN fails it.
        return tuple(diagnostic for rule in RULES for diagnostic in _findings(rule, stage))


def _findings(rule: Rule, stage: Any) -> tuple[Diagnostic, ...]:
    """What a rule says; a value that OpenUSD itself refuses to read is one finding, not the end of the gate."""
    try:
        return tuple(rule(stage))
    except Tf.ErrorException as error:
        reason = str(error.args[0] if error.args else error).rpartition(" : ")[2].strip("' \n")
        return (finding("asset/package-invalid", "OpenUSD refuses a value in the file", value=reason[:300]),)
